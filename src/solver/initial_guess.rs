//! The start of a cold solve: Newton's method at the guess that all contacts stick, or sweeps ([`crate::guide::method`], "The start").
//!
//! The choice depends on two questions: is the scene hyperstatic (are its impulses not unique), and does friction suffice to stick?

use crate::cone::{add_to_normal, split};
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::{norm, zeros};
use crate::problem::Problem;
use crate::real::Real;
use crate::solution::Model;
use crate::solver::tuning;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Problem<'_, T, N, D, C, R, S>
{
    /// Does a cold solve without a guess begin with sweeps? In the convex relaxation only if impulses are unique: otherwise
    /// Newton's method from zero impulses is faster.
    pub(crate) fn begins_with_sweeps(&self) -> bool {
        let unique = || self.can_be_swept() && !self.may_be_hyperstatic();
        self.model == Model::Coulomb || unique()
    }

    /// Value of `alpha_i q_N` (N·s) above which a contact clearly separates.
    fn open_threshold(&self) -> T {
        self.expected_size * tuning::open_threshold::<T>()
    }

    /// Is the scene hyperstatic, and is there enough friction to stick: `Σ alpha_i |q_Ti| <= Σ alpha_i mu_i |q_Ni|` over the
    /// contacts with friction that approach?
    pub(crate) fn is_likely_to_stick(&self) -> bool {
        if !self.may_be_hyperstatic() {
            return false;
        }
        let threshold = self.open_threshold();
        let rows = self.sets.rows().iter();
        let mut holding = rows.filter(|set| set.holds(set.solve_local(T::ZERO, set.q))).count();
        let (mut demand, mut grip) = (T::ZERO, T::ZERO);
        for set in self.sets.contacts() {
            let (normal, tangent) = split(&set.q);
            if set.alpha * normal > threshold {
                continue;
            }
            let (slip, friction) = (norm(tangent), -set.cone.friction() * normal);
            holding += set.pushing_rows();
            let approaches = normal < -tuning::grazing::<T>() * slip;
            if approaches && set.pushing_rows() > 1 {
                demand += set.alpha * slip;
                grip += set.alpha * friction;
            }
        }
        self.makes_hyperstatic(holding) && demand <= tuning::sticking::<T>() * grip
    }

    /// Fills `z` with the guess: every contact that does not clearly separate sticks, with the normal impulse that would stop it
    /// alone, but at least the threshold. Every joint row has the impulse that it would have alone.
    pub(crate) fn all_sticking(&self, z: &mut Stacked<T, D, C, R>) {
        let threshold = self.open_threshold();
        for (z, set) in z.contacts.iter_mut().zip(self.sets.contacts()) {
            let mut start = set.augmented(&set.q);
            let normal = split(&set.q).0;
            if set.alpha > T::ZERO && set.alpha * normal <= threshold {
                start = zeros();
                add_to_normal(&mut start, normal.min(-threshold / set.alpha));
            }
            *z = start.into();
        }
        for (z, set) in z.rows.iter_mut().zip(self.sets.rows()) {
            *z = set.q;
        }
    }
}

#[cfg(test)]
mod tests;
