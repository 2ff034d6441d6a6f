//! What is known of contacts or joint rows after a solve, by key.

use crate::real::Real;
use core::mem;

/// `ũ` and `r` of a contact (`L` rows) or a joint row (one) in the last solve, in physical units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry<T, const L: usize> {
    pub(super) key: u32,
    pub(super) u: [T; L],
    pub(super) r: [T; L],
    /// `r` of the solve before, if `solves > 1`. (An option in an option would not be all zeros.)
    before: [T; L],
    /// How many solves have had it; 0 if its impulse was given, and `u` is not known.
    pub(super) solves: u32,
}

impl<T: Real, const L: usize> Entry<T, L> {
    /// `r`; if the solve is to go `onwards`, extrapolated from the last two solves. What is open stays open.
    pub(super) fn impulse(&self, onwards: bool) -> [T; L] {
        let mut r = self.r;
        if onwards && self.solves > 1 && r != [T::ZERO; L] {
            for ((r, &last), &before) in r.iter_mut().zip(&self.r).zip(&self.before) {
                *r += last - before;
            }
        }
        r
    }
}

/// What is known of contacts or joint rows, in the order of the last scene; `None` for what was not in the last solve, and
/// behind what is in use.
#[derive(Clone, Debug)]
pub(super) struct Table<T, const L: usize, const K: usize> {
    pub(super) entries: [Option<Entry<T, L>>; K],
}

impl<T: Real, const L: usize, const K: usize> Table<T, L, K> {
    pub(super) const fn empty() -> Self {
        Self { entries: [None; K] }
    }

    pub(super) fn known(&self) -> impl Iterator<Item = &Entry<T, L>> {
        self.entries.iter().flatten()
    }

    /// Are the keys of the last solve not those of a scene, in their order?
    pub(super) fn is_out_of_order(&self, keys: impl Iterator<Item = u32>) -> bool {
        let last = self.entries.iter().map_while(Option::as_ref);
        !last.map(|entry| entry.key).eq(keys)
    }

    /// Goes over to the order of the next scene: the first of a key takes what the first of that key left, the second what the
    /// second left. What nobody takes is forgotten. Returns the old place of each; `K` of what is new.
    pub(super) fn reorder(&mut self, keys: impl Iterator<Item = u32>) -> [usize; K] {
        let mut last = mem::replace(&mut self.entries, [None; K]);
        let mut places = [K; K];
        for ((entry, place), key) in self.entries.iter_mut().zip(&mut places).zip(keys) {
            let same = |left: &Option<Entry<T, L>>| left.is_some_and(|left| left.key == key);
            if let Some(found) = last.iter().position(same) {
                *place = found;
                *entry = last.get_mut(found).and_then(Option::take);
            }
        }
        places
    }

    /// Keeps what a solve has left, in place of what the last call left if it `replaces` that.
    pub(super) fn keep(&mut self, place: usize, key: u32, u: [T; L], r: [T; L], replaces: bool) {
        let Some(entry) = self.entries.get_mut(place) else {
            return;
        };
        let counts = !replaces || entry.is_none();
        let entry = entry.get_or_insert(Entry {
            key,
            u,
            r,
            before: r,
            solves: 0,
        });
        if counts {
            (entry.before, entry.solves) = (entry.r, entry.solves.saturating_add(1));
        }
        (entry.key, entry.u, entry.r) = (key, u, r);
    }

    /// Forgets all for impulses that are given.
    pub(super) fn set(&mut self, impulses: impl Iterator<Item = (u32, [T; L])>) {
        *self = Self::empty();
        for (entry, (key, r)) in self.entries.iter_mut().zip(impulses) {
            *entry = Some(Entry {
                key,
                u: [T::ZERO; L],
                r,
                before: [T::ZERO; L],
                solves: 0,
            });
        }
    }
}
