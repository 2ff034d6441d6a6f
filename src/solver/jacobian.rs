//! The linearised equation of a Newton step, factorised and kept.
//!
//! A step solves `[rho W (I - DP + λI) + DP - DS + λI] d = E` with the derivatives `DP` and `DS`
//! of [`crate::solver::frame`], where `λ` regularises hyperstatic scenes (singular `W`). In the frame of
//! a contact most of it decouples, and only what moves its impulse stays an unknown of the system:
//! three for a spatial contact that sticks, two for one that slips, one without friction, none for
//! an open one. Where none slips the system is symmetric in what the contacts push.

use crate::Real;
use crate::cone::split;
use crate::laws::{Coulomb, Laws};
use crate::linalg::blocks::{ContactMatrix, ContactVector, row_times};
use crate::linalg::elimination::Elimination;
use crate::linalg::hints::rolled;
use crate::problem::{ContactLaw, Problem};
use crate::solution::zeros;
use crate::solver::frame::{Frame, Kind};
use crate::solver::point::Point;
use core::array;
use nalgebra::SVector;

/// The linearised equation at some point, factorised.
#[derive(Clone, Debug)]
pub(crate) struct Jacobian<T: Real, const D: usize, const C: usize, L: Laws = Coulomb> {
    frames: [Frame<T, D, L>; C],
    /// `order[i]`: index of the frame that belongs to contact `i`. Contacts may have changed places.
    order: [usize; C],
    pub(super) elimination: Elimination<T, D, C>,
    damping: T,
    /// Number of contacts.
    contacts: usize,
}

impl<T: Real, const D: usize, const C: usize, L: Laws> Jacobian<T, D, C, L> {
    pub(crate) const fn none() -> Self {
        Self {
            frames: [const { Frame::none() }; C],
            order: [0; C],
            elimination: Elimination::none(),
            damping: T::ZERO,
            contacts: 0,
        }
    }

    /// Follows contacts to other places, from those given; a place there is not is of a new one.
    pub(crate) fn follow(&mut self, places: &[usize; C]) {
        let order = self.order;
        for (frame, &place) in self.order.iter_mut().zip(places) {
            *frame = order.get(place).copied().unwrap_or(C);
        }
    }

    /// Linearises at a point, and factorises in `matrix`; `None` if the system is singular.
    #[inline(never)]
    pub(crate) fn compute<const N: usize>(
        &mut self,
        problem: &Problem<'_, T, N, D, C, L>,
        point: &Point<T, D, C>,
        damping: T,
        matrix: &mut ContactMatrix<T, D, C>,
    ) -> Option<()> {
        self.order = array::from_fn(|i| i);
        self.damping = damping;
        let laws = problem.laws();
        let contacts = laws.iter().zip(&point.z);
        let contacts = contacts.zip(point.p.iter().zip(&point.r));
        for (frame, ((law, z), (velocity, impulse))) in self.frames.iter_mut().zip(contacts) {
            rolled();
            let kind = Kind::of(law, velocity, impulse);
            frame.set(law, kind, z, law.alpha, damping);
        }
        self.hold(laws, point);
        let frames = self.frames.get(..laws.len())?;
        self.elimination.lay_out(frames.iter().map(Frame::count));
        let symmetric = frames.iter().all(|frame| frame.kind != Kind::Slip);
        let delassus = problem.factor.delassus();
        for (j, frame) in frames.iter().enumerate() {
            let start = self.elimination.columns(j).start;
            if frame.kind == Kind::Open {
                continue;
            }
            for (i, (rows, tested)) in matrix.iter_mut().zip(frames).enumerate() {
                if symmetric && i > j {
                    break;
                }
                if tested.kind == Kind::Open {
                    continue;
                }
                let mut block = [[T::ZERO; D]; D];
                for (entries, source) in block.iter_mut().zip(delassus.get(i)?) {
                    *entries = frame.columns(source.get(j)?);
                }
                for (k, row) in rows.iter_mut().enumerate() {
                    let mut entries = [T::ZERO; D];
                    if k < tested.count() {
                        entries = match tested.combination(k) {
                            Some(rows) => row_times(rows, &block),
                            None => *block.get(k)?,
                        };
                        if i == j {
                            *entries.get_mut(k)? += match (frame.kind, k) {
                                (Kind::Slip, 0) => -damping - frame.skew * frame.tilt,
                                (Kind::Slip, _) => frame.turn + damping,
                                (Kind::Stick, 1..) => frame.hold * frame.compliance,
                                _ => damping * frame.compliance,
                            };
                        }
                    }
                    // Excess entries are overwritten by the next contact, or zero.
                    let target = row.as_flattened_mut().get_mut(start..)?;
                    *target.first_chunk_mut()? = entries;
                }
            }
        }
        self.elimination.factorise(matrix, symmetric)?;
        self.contacts = laws.len();
        Some(())
    }

    /// Damps sticking contacts more the smaller their grip `mu r_N` is. Of all tangential impulses with the same effect those
    /// are preferred that use the same share of each cone.
    fn hold(&mut self, laws: &[ContactLaw<T, D, L>], point: &Point<T, D, C>) {
        let grip = |(law, z): (&ContactLaw<T, D, L>, &SVector<T, D>)| {
            law.cone.friction() * split(z).0.abs()
        };
        let (mut sum, mut sticking) = (T::ZERO, T::ZERO);
        for (frame, contact) in self.frames.iter().zip(laws.iter().zip(&point.z)) {
            rolled();
            if frame.sticks() {
                sum += grip(contact);
                sticking += T::ONE;
            }
        }
        for (frame, contact) in self.frames.iter_mut().zip(laws.iter().zip(&point.z)) {
            rolled();
            if frame.sticks() {
                let weight = sum / (sticking * grip(contact));
                frame.hold = self.damping * weight.min(T::literal(100.0));
            }
        }
    }

    /// Does every contact do at a point what it did where this was computed?
    #[inline(never)]
    pub(crate) fn has_same_active_set<const N: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C, L>,
        point: &Point<T, D, C>,
    ) -> bool {
        let laws = problem.laws();
        let contacts = point.p.iter().zip(&point.r);
        let mut contacts = laws.iter().zip(contacts).zip(&self.order);
        self.contacts == laws.len()
            && contacts.all(|((law, (velocity, r)), &frame)| {
                rolled();
                let frame = self.frames.get(frame);
                frame.is_some_and(|frame| frame.is_of(law, velocity, r))
            })
    }

    /// Residual plus a term that reduces internal tangential impulses (by the weights of [`Self::hold`]).
    ///
    /// Impulses of a hyperstatic scene that were carried from step to step end on the boundaries of their cones, although
    /// others inside have the same effect. What a contact on the boundary does next is hard to foresee.
    pub(crate) fn centred(&self, point: &Point<T, D, C>) -> ContactVector<T, D, C> {
        let mut residual = point.residual;
        for (residual, (&place, z)) in residual.iter_mut().zip(self.order.iter().zip(&point.z)) {
            rolled();
            if let Some(frame) = self.frames.get(place)
                && frame.sticks()
            {
                for (residual, &z) in residual.iter_mut().zip(z).skip(1) {
                    *residual -= frame.hold * z;
                }
            }
        }
        residual
    }

    /// The step `d` for a residual; `None` if it is not finite.
    #[inline(never)]
    pub(crate) fn step<const N: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C, L>,
        residual: &ContactVector<T, D, C>,
        matrix: &ContactMatrix<T, D, C>,
    ) -> Option<[SVector<T, D>; C]> {
        let laws = problem.laws();
        let order = self.order.get(..laws.len())?;
        let mut unknowns = [[T::ZERO; D]; C];
        let unknowns = unknowns.as_flattened_mut();
        for (&place, residual) in order.iter().zip(residual) {
            rolled();
            let unknowns = unknowns.get_mut(self.elimination.columns(place))?;
            let right = self.frames.get(place)?.test(residual);
            for (unknown, right) in unknowns.iter_mut().zip(right) {
                *unknown = right;
            }
        }
        self.elimination.solve(matrix, unknowns)?;
        let mut moved = [[T::ZERO; D]; C];
        let frames = self.frames.get(..laws.len())?;
        if frames.iter().any(|frame| !frame.sticks()) {
            let mut push = [[T::ZERO; D]; C];
            for (&place, push) in order.iter().zip(&mut push) {
                rolled();
                let unknowns = unknowns.get(self.elimination.columns(place))?;
                *push = frames.get(place)?.push(unknowns);
            }
            let contacts = ..laws.len();
            problem
                .factor
                .delassus_times(push.get(contacts)?, moved.get_mut(contacts)?);
        }
        let damping = T::ONE / (T::ONE + self.damping);
        let mut steps = [zeros(); C];
        let contacts = residual.iter().zip(&moved);
        let contacts = contacts.zip(laws.iter().zip(order));
        for (step, ((residual, moved), (law, &place))) in steps.iter_mut().zip(contacts) {
            rolled();
            let unknowns = unknowns.get(self.elimination.columns(place))?;
            let left = SVector::from(*residual) - SVector::from(*moved);
            *step = frames.get(place)?.step(law, unknowns, left, damping);
        }
        let finite = steps.iter().flatten().all(T::is_finite);
        finite.then_some(steps)
    }
}

#[cfg(test)]
mod tests;
