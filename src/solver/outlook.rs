//! Are impulses unique, and do contacts stick? The answers decide how a cold solve starts: with Newton's method at a guess, or
//! with sweeps.

use crate::cone::{add_to_normal, norm, split};
use crate::laws::{Laws, Room};
use crate::linalg::blocks::ContactVector;
use crate::linalg::hints::rolled;
use crate::problem::{ContactLaw, Problem};
use crate::solution::zeros;
use crate::solver::tuning;
use crate::{Model, Real};
use nalgebra::SVector;

impl<T: Real, const N: usize, const D: usize, const C: usize, L: Laws> Problem<'_, T, N, D, C, L> {
    /// Is it hyperstatic: do contacts with these impulses have rows >= moved dofs + D? Then impulses are far from unique:
    /// they can change without moving a body.
    pub(crate) fn is_hyperstatic(&self, r: &ContactVector<T, D, C>) -> bool {
        let rows = self.laws().iter().zip(r).map(|(law, r)| {
            rolled();
            match law.rows.get() {
                // A row at its bound is pushed by what is known.
                Some(rows) => rows.holding(r).into_iter().filter(|&holds| holds).count(),
                None if *r == [T::ZERO; D] => 0,
                None => law.rows(),
            }
        });
        self.is_redundant(rows.sum())
    }

    /// May it be hyperstatic, if all contacts and rows push?
    pub(crate) fn may_be_hyperstatic(&self) -> bool {
        self.is_redundant(self.laws().iter().map(ContactLaw::rows).sum())
    }

    /// Is rows >= moved dofs + D?
    fn is_redundant(&self, rows: usize) -> bool {
        rows >= self.factor.moved() + D
    }

    /// Does a cold solve sweep, if it does not guess? The convex relaxation only where impulses are unique: elsewhere Newton's
    /// method goes faster from rest.
    pub(crate) fn begins_with_sweeps(&self) -> bool {
        let unique = || self.can_be_swept() && !self.may_be_hyperstatic();
        self.model == Model::Coulomb || unique()
    }

    /// `alpha_i q_N` (N·s) above which a contact clearly separates.
    fn parting(&self) -> T {
        self.size * tuning::parting::<T>()
    }

    /// Is the scene hyperstatic, and is the total friction that sticking needs available, if each contact is stopped alone?
    pub(crate) fn is_likely_to_stick(&self) -> bool {
        if !self.may_be_hyperstatic() {
            return false;
        }
        let parting = self.parting();
        let (mut rows, mut demand, mut grip) = (0, T::ZERO, T::ZERO);
        for law in self.laws() {
            rolled();
            if let Some(joint_rows) = law.rows.get() {
                let alone = joint_rows.project(&(-law.q * law.alpha));
                let holding = joint_rows.holding(&alone.into());
                rows += holding.into_iter().filter(|&holds| holds).count();
                continue;
            }
            let (normal, tangent) = split(&law.q);
            if law.alpha * normal > parting {
                continue;
            }
            let (slip, held) = (norm(tangent), -law.cone.friction() * normal);
            rows += law.rows();
            let approaches = normal < -tuning::grazing::<T>() * slip;
            if approaches && law.rows() > 1 {
                demand += law.alpha * slip;
                grip += law.alpha * held;
            }
        }
        self.is_redundant(rows) && demand <= tuning::sticking::<T>() * grip
    }

    /// A `z` at which every contact sticks that does not clearly separate, pushed by the impulse that would stop it alone, and
    /// every joint row has the impulse that it would have alone.
    pub(crate) fn all_sticking(&self, z: &mut [SVector<T, D>; C]) {
        let parting = self.parting();
        for (z, law) in z.iter_mut().zip(self.laws()) {
            rolled();
            *z = law.augmented(&law.q);
            let normal = split(&law.q).0;
            let may_stick = law.rows.get().is_none() && law.alpha > T::ZERO;
            if may_stick && law.alpha * normal <= parting {
                *z = zeros();
                add_to_normal(z, normal.min(-parting / law.alpha));
            }
        }
    }
}

#[cfg(test)]
mod tests;
