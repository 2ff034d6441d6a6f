//! A warm start as words: for a file, or for a kernel of another capacity.

use super::table::{Entry, Table};
use super::{CREEPING_TICKS, WarmStart};
use crate::real::Real;
use core::array::from_fn;

impl<T: Real, const D: usize, const C: usize, const R: usize> WarmStart<T, D, C, R> {
    /// The first word: version of the format, rows of a contact and bytes of a number.
    const FORMAT: u64 = 1 << 32 | (D as u64) << 8 | size_of::<T>() as u64;

    /// All that it holds, as words for [`Self::from_words`].
    pub fn words(&self) -> impl Iterator<Item = u64> + '_ {
        let flags = [self.is_solved, self.presumes_rest, self.is_disturbed].map(u64::from);
        let counts = [self.contacts.known().map(|_| 1).sum::<u64>(), self.rows.known().map(|_| 1).sum()];
        let contacts = self.contacts.known().flat_map(Entry::words);
        let rows = self.rows.known().flat_map(Entry::words);
        let head = [Self::FORMAT].into_iter().chain(flags).chain([self.creeping_ticks.into()]).chain(counts);
        head.chain(contacts).chain(rows)
    }

    /// The warm start of these words. `None` if they are not [`Self::words`] of this number type and `D`, or if there is no room for all their
    /// contacts or joint rows.
    pub fn from_words(words: impl IntoIterator<Item = u64>) -> Option<Self> {
        let words = &mut words.into_iter();
        words.next().filter(|&format| format == Self::FORMAT)?;
        let mut flag = || words.next().filter(|&word| word <= 1).map(|word| word == 1);
        let (is_solved, presumes_rest, is_disturbed) = (flag()?, flag()?, flag()?);
        let creeping_ticks = u8::try_from(words.next()?).ok().filter(|&ticks| ticks < CREEPING_TICKS)?;
        let [contacts, rows] = [words.next()?, words.next()?];
        let (contacts, rows) = (Table::from_words(contacts, words)?, Table::from_words(rows, words)?);
        let is_all = words.next().is_none();
        is_all.then_some(Self { contacts, rows, is_solved, presumes_rest, is_disturbed, creeping_ticks })
    }
}

impl<T: Real, const L: usize> Entry<T, L> {
    fn words(&self) -> impl Iterator<Item = u64> + '_ {
        let numbers = self.u.iter().chain(&self.r).chain(&self.before);
        [self.key, self.solves].map(u64::from).into_iter().chain(numbers.map(|number| number.to_word()))
    }

    fn from_words(words: &mut impl Iterator<Item = u64>) -> Option<Self> {
        let [key, solves] = [words.next()?, words.next()?];
        let (key, solves) = (u32::try_from(key).ok()?, u32::try_from(solves).ok()?);
        let mut is_finite = true;
        let [u, r, before] = from_fn(|_| {
            from_fn(|_| {
                let number = words.next().map_or(T::INFINITY, T::from_word);
                is_finite &= number.is_finite();
                number
            })
        });
        is_finite.then_some(Self { key, u, r, before, solves })
    }
}

impl<T: Real, const L: usize, const K: usize> Table<T, L, K> {
    fn from_words(count: u64, words: &mut impl Iterator<Item = u64>) -> Option<Self> {
        let count = usize::try_from(count).ok().filter(|&count| count <= K)?;
        let mut table = Self::empty();
        for entry in table.entries.iter_mut().take(count) {
            *entry = Some(Entry::from_words(words)?);
        }
        Some(table)
    }
}
