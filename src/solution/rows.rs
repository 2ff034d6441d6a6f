//! What joint rows do in a solution.

use super::Solution;
use crate::{Mixed, Real, RowIndex, RowMode, RowSolution};

impl<T: Real, const N: usize, const D: usize, const C: usize> Solution<T, N, D, C, Mixed> {
    /// What the joint row with this key does; `None` if there is none, as of a limit that
    /// [`crate::Kernel::solve_with_limits`] has left out.
    #[must_use]
    pub fn row_by_key(&self, key: u32) -> Option<RowSolution<T>> {
        let places = (0..self.contacts.len()).flat_map(|slot| (0..D).map(move |row| (slot, row)));
        let mut rows = places.filter_map(|(slot, row)| self.row(RowIndex { slot, row }));
        rows.find(|row| row.key == key)
    }

    /// What a joint row does; `None` if there is none.
    #[must_use]
    pub fn row(&self, row: RowIndex) -> Option<RowSolution<T>> {
        let slot = self.rows.get(row.slot)?.as_ref()?;
        let contact = self.contacts.get(row.slot)?;
        (row.row < slot.count).then_some(RowSolution {
            key: *slot.keys.get(row.row)?,
            impulse: *contact.impulse.get(row.row)?,
            velocity: *contact.velocity.get(row.row)?,
            mode: *slot.modes.get(row.row)?,
            certificate: *slot.certificate.get(row.row)?,
        })
    }
}

/// What a slot of joint rows does.
#[derive(Clone, Copy, Debug)]
pub struct SlotSolution<T, const D: usize> {
    pub(crate) count: usize,
    pub(crate) keys: [u32; D],
    pub(crate) modes: [RowMode; D],
    pub(crate) certificate: [T; D],
}

impl<T: Real, const D: usize> SlotSolution<T, D> {
    /// Nothing yet.
    pub(crate) const fn none() -> Self {
        Self {
            count: 0,
            keys: [0; D],
            modes: [RowMode::Open; D],
            certificate: [T::ZERO; D],
        }
    }
}
