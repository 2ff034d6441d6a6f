//! Impulses that are no solution, however small their error ([`crate::guide::error`], "Jammed scenes").
//!
//! An impulse of a million times the expected size makes a violation of the expected size a relative error of 1e-6. So impulses far above the
//! expected size are judged by velocities and energies as well, which they do not loosen.

use crate::linalg::stacked::Stacked;
use crate::linalg::vector::{at_least, square};
use crate::linalg::zip::zip4;
use crate::problem::Problem;
use crate::problem::infeasibility::violation;
use crate::real::Real;
use crate::scene::RowLaw;
use crate::solution::Solution;

/// Rounding of a velocity, relative to the velocities of all impulses.
const ROUNDING: f64 = 16.0;

/// Energies (J) of impulses and their velocities, twice each: those of a velocity `s` along a row with the effective mass `alpha` are `alpha s²`.
struct Squeeze<T> {
    /// The largest of a violation by the velocities.
    violated: T,
    /// The largest of a violation by the free velocities.
    met: T,
    /// Sum for the velocity of each impulse alone.
    pushed: T,
    /// Work of all impulses, seen from the walls.
    work: T,
}

impl<T: Real> Squeeze<T> {
    /// Takes in the law of a row, with its velocity and free velocity.
    fn take_in_law(&mut self, alpha: T, law: RowLaw<T>, [u, q]: [T; 2]) {
        let energy = |violation: T| alpha * violation * violation;
        self.violated = at_least(energy(violation(law, u)), self.violated);
        self.met = at_least(energy(violation(law, q)), self.met);
    }

    /// Takes in the impulses of a contact or a row, with their velocities and free velocities.
    fn take_in_work(&mut self, alpha: T, [r, u, q]: [&[T]; 3]) {
        for ((&r, &u), &q) in r.iter().zip(u).zip(q) {
            self.work += r * (u + q);
        }
        if alpha > T::ZERO {
            self.pushed += square(r) / alpha;
        }
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Problem<'_, T, N, D, C, R, S>
{
    /// Do these large impulses, those of the solution, add energy or let a contact or a joint row close faster than without them?
    ///
    /// Impulses that obey the law take energy, seen from the walls: `r · u <= 0` and `u - q = W r`, so `r · (u + q)` is negative. It is twice the
    /// energy that bodies and springs gain beyond the work `-r · w` of the walls.
    #[inline(never)]
    pub(crate) fn squeezes(&self, r: &Stacked<T, D, C, R>, solution: &Solution<T, N, D, C, R>) -> bool {
        let [violated, met, pushed, work] = [T::ZERO; 4];
        let mut squeeze = Squeeze { violated, met, pushed, work };
        let contacts = zip4(0..C, self.sets.contacts(), &r.contacts, &solution.contacts);
        for (i, set, r, contact) in contacts {
            let u = self.scene.scaled_velocity(i, contact.velocity);
            let normal = |x: &[T]| x.first().copied().unwrap_or(T::ZERO);
            let normals = [u.as_slice(), set.q.as_slice()].map(normal);
            squeeze.take_in_law(set.alpha, RowLaw::Limit, normals);
            squeeze.take_in_work(set.alpha, [r, u.as_slice(), set.q.as_slice()]);
        }
        let rows = zip4(self.scene.rows(), self.sets.rows(), &r.rows, &solution.rows);
        for (row, set, &r, found) in rows {
            let u = found.velocity;
            squeeze.take_in_law(set.alpha, row.law, [u, set.q]);
            squeeze.take_in_work(set.alpha, [&[r], &[u], &[set.q]]);
            // A motor that always pushes works, too.
            let least = set.project(T::ZERO);
            squeeze.work -= (least + least) * u;
        }
        let Squeeze { violated, met, pushed, work } = squeeze;
        let rounding = T::EPSILON * T::literal(ROUNDING);
        met > T::ZERO && violated > at_least(met, pushed * rounding * rounding) || work > pushed * rounding
    }
}
