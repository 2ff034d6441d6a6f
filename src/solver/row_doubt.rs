//! The monitor's doubts where there are joint rows.

use crate::laws::{Laws, Room};
use crate::problem::row_proof;
use crate::solution::SlotSolution;
use crate::solver::monitor::Monitor;
use crate::{ContactSolution, Real};

impl<T: Real, const N: usize, const D: usize, const C: usize, L: Laws>
    Monitor<'_, '_, T, N, D, C, L>
{
    /// The impulse of a slot in its scaled rows.
    pub(super) fn unscaled(&self, slot: usize, contact: &ContactSolution<T, D>) -> [T; D] {
        self.problem.factor.unscaled(slot, contact.impulse).into()
    }

    /// [`Self::prove`] where there may be joint rows.
    pub(super) fn prove_with_rows(&mut self) -> Option<()> {
        let proof = row_proof::certificate(self.problem)?;
        self.solution.certificate.clear();
        let slots = self.problem.laws().len();
        for (i, (d, rows)) in proof
            .iter()
            .zip(&mut self.solution.rows)
            .enumerate()
            .take(slots)
        {
            // There is room: a solution holds as many slots as a scene.
            let _ = self.solution.certificate.push(self.problem.normal_of(i, d));
            let mut slot = rows.get().copied().unwrap_or(SlotSolution::none());
            slot.certificate = *d;
            *rows = L::Room::with(slot);
        }
        Some(())
    }
}
