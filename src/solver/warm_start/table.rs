//! A table of the last velocities and impulses of contacts or of joint rows, by key.

use crate::linalg::zip::zip3;
use crate::real::Real;
use core::mem;

/// `ũ` and `r` of one contact (`L` rows) or one joint row (`L` = 1) in the last solve, in physical rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry<T, const L: usize> {
    pub(super) key: u32,
    pub(super) u: [T; L],
    pub(super) r: [T; L],
    /// `r` of the solve before, if `solves > 1`. (An `Option` in an `Option` would not be all zeros.)
    pub(super) before: [T; L],
    /// Number of solves in a row that had this contact or row; 0 if its impulse was given, and `u` is not known.
    pub(super) solves: u32,
}

impl<T: Real, const L: usize> Entry<T, L> {
    /// The last impulse; if the solve goes `onwards` to the next tick, extrapolated from the last two solves. An impulse of 0 stays 0.
    pub(super) fn impulse(&self, onwards: bool) -> [T; L] {
        let mut r = self.r;
        if onwards && self.solves > 1 && r != [T::ZERO; L] {
            for (r, &last, &before) in zip3(&mut r, &self.r, &self.before) {
                *r += last - before;
            }
        }
        r
    }
}

/// The entries of contacts or joint rows, in the order of the last scene. Unused entries are `None`.
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

    /// Do the keys of a scene differ from those of the last solve, or in their order?
    pub(super) fn is_out_of_order(&self, keys: impl Iterator<Item = u32>) -> bool {
        let last = self.entries.iter().map_while(Option::as_ref);
        !last.map(|entry| entry.key).eq(keys)
    }

    /// Sorts the entries into the order of the next scene: the first contact with a key takes the first entry with that key, the second one
    /// the second. Other entries are forgotten. Returns the old index of each entry; `K` for a new one.
    pub(super) fn reorder(&mut self, keys: impl Iterator<Item = u32>) -> [usize; K] {
        let mut last = mem::replace(&mut self.entries, [None; K]);
        let mut earlier_indices = [K; K];
        for (entry, earlier_index, key) in zip3(&mut self.entries, &mut earlier_indices, keys) {
            let same = |old: &Option<Entry<T, L>>| old.is_some_and(|old| old.key == key);
            if let Some(found) = last.iter().position(same) {
                *earlier_index = found;
                *entry = last.get_mut(found).and_then(Option::take);
            }
        }
        earlier_indices
    }

    /// Keeps `ũ` and `r` of a solve at an index. If it `replaces` the last call, both belong to the same solve, and it counts once.
    pub(super) fn keep(&mut self, index: usize, key: u32, u: [T; L], r: [T; L], replaces: bool) {
        let Some(entry) = self.entries.get_mut(index) else {
            return;
        };
        let counts = !replaces || entry.is_none();
        let entry = entry.get_or_insert(Entry { key, u, r, before: r, solves: 0 });
        if counts {
            (entry.before, entry.solves) = (entry.r, entry.solves.saturating_add(1));
        }
        (entry.key, entry.u, entry.r) = (key, u, r);
    }

    /// Replaces all entries by given impulses.
    pub(super) fn set(&mut self, impulses: impl Iterator<Item = (u32, [T; L])>) {
        *self = Self::empty();
        let given = |(key, r)| Entry { key, u: [T::ZERO; L], r, before: [T::ZERO; L], solves: 0 };
        for (entry, new) in self.entries.iter_mut().zip(impulses.map(given)) {
            *entry = Some(new);
        }
    }
}
