//! Iterative refinement: corrects the velocities `W r + q` of a search where they differ from the `H v + w` of a solution by rounding.

use crate::linalg::stacked::Stacked;
use crate::linalg::zip::{zip3, zip4};
use crate::real::Real;
use crate::solution::Status;
use crate::solver::monitor::Monitor;
use nalgebra::SVector;

/// Largest number of corrections of the velocities. If they are not enough, rounding is to blame.
const CORRECTIONS: u8 = 4;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Monitor<'_, '_, T, N, D, C, R, S>
{
    /// Adds the difference of `H v + w` and `W r + q` to the constant terms of the velocities,
    /// [`ContactSet::base`](crate::sets::ContactSet), and lets the search continue. The solution that is written has the impulses `r`. After
    /// [`CORRECTIONS`] the solve ends instead.
    pub(super) fn correct_velocities(&mut self, r: &Stacked<T, D, C, R>) {
        if self.record.corrections >= CORRECTIONS {
            self.stop(Status::PrecisionLimit);
            return;
        }
        self.record.corrections += 1;
        let scene = self.problem.scene;
        let mut u = Stacked::zero();
        self.problem.velocities(r, &mut u);
        let sets = self.problem.sets.contacts_mut();
        for (i, set, contact, &u) in zip4(0..C, sets, &self.solution.contacts, &u.contacts) {
            let velocity = scene.scaled_velocity(i, contact.velocity);
            set.base += velocity - SVector::from(u);
        }
        for (set, row, &u) in zip3(self.problem.sets.rows_mut(), &self.solution.rows, &u.rows) {
            set.base += row.velocity - u;
        }
    }
}
