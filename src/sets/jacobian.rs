//! The linearised equation of a Newton step, factorised and kept.
//!
//! A step solves `[W A (I - DP + λI) + DP - DS + λI] d = E`, with the effective masses `A = diag(alpha)` and the derivatives `DP`
//! and `DS` of [`super::contact::frame`], where `λ` regularises hyperstatic scenes (singular `W`). In the frame of
//! a contact most of it decouples, and only what moves its impulse stays an unknown of the system:
//! three for a spatial contact that sticks, two for one that slips, one without friction, none for
//! an open one; one for a joint row that holds, none for one at its bound. Where none slips the system is symmetric in what they push.

use crate::cone::split;
use crate::factor::Delassus;
use crate::linalg::elimination::Elimination;
use crate::linalg::stacked::{Counts, Stacked, StackedMatrix};
use crate::real::Real;
use crate::sets::Sets;
use crate::sets::contact::frame::{Frame, Kind};
use crate::sets::point::Point;
use core::array::from_fn;
use nalgebra::SVector;

mod assembly;

/// Where in an earlier list the contacts and joint rows of a scene stood; `C` and `R` for new ones.
#[derive(Clone, Debug)]
pub(crate) struct Places<const C: usize, const R: usize> {
    pub(crate) contacts: [usize; C],
    pub(crate) rows: [usize; R],
}

/// The linearised equation at some point, factorised.
#[derive(Clone, Debug)]
pub(crate) struct Jacobian<T: Real, const D: usize, const C: usize, const R: usize> {
    frames: [Frame<T, D>; C],
    /// Does a joint row hold?
    holds: [bool; R],
    /// Which frame belongs to each contact, and which row to each joint row: they may have changed places.
    order: Places<C, R>,
    pub(crate) elimination: Elimination<T, D, C, R>,
    /// Levenberg and Marquardt's `λ`
    damping: T,
    counts: Counts,
}

impl<T: Real, const D: usize, const C: usize, const R: usize> Jacobian<T, D, C, R> {
    pub(crate) const fn none() -> Self {
        Self {
            frames: [const { Frame::none() }; C],
            holds: [false; R],
            order: Places {
                contacts: [0; C],
                rows: [0; R],
            },
            elimination: Elimination::none(),
            damping: T::ZERO,
            counts: Counts {
                contacts: 0,
                rows: 0,
            },
        }
    }

    /// Follows contacts and joint rows to other places, from those given.
    pub(crate) fn follow(&mut self, places: &Places<C, R>) {
        let old = self.order.clone();
        for (frame, &place) in self.order.contacts.iter_mut().zip(&places.contacts) {
            *frame = old.contacts.get(place).copied().unwrap_or(C);
        }
        for (row, &place) in self.order.rows.iter_mut().zip(&places.rows) {
            *row = old.rows.get(place).copied().unwrap_or(R);
        }
    }

    /// Linearises at a point, and factorises in `matrix`; `None` if the system is singular.
    #[inline(never)]
    pub(crate) fn compute(
        &mut self,
        sets: &Sets<T, D, C, R>,
        delassus: &Delassus<T, D, C, R>,
        point: &Point<T, D, C, R>,
        damping: T,
        matrix: &mut StackedMatrix<T, D, C, R>,
    ) -> Option<()> {
        self.order = Places {
            contacts: from_fn(|i| i),
            rows: from_fn(|j| j),
        };
        self.damping = damping;
        self.counts = sets.counts();
        let contacts = sets.contacts().iter().zip(&point.z.contacts);
        let contacts = contacts.zip(point.p.contacts.iter().zip(&point.r.contacts));
        for (frame, ((set, &z), (&velocity, impulse))) in self.frames.iter_mut().zip(contacts) {
            let kind = Kind::of(set, &velocity.into(), impulse);
            frame.set(set, kind, &z.into(), damping);
        }
        self.balance_damping(sets, point);
        let rows = sets.rows().iter().zip(&point.r.rows);
        for (holds, (set, &r)) in self.holds.iter_mut().zip(rows) {
            *holds = set.holds(r);
        }
        let frames = self.frames.get(..self.counts.contacts)?;
        let unknown_rows = self.holding_rows().count();
        self.elimination
            .lay_out(frames.iter().map(Frame::count), unknown_rows);
        let symmetric = frames.iter().all(|frame| frame.kind != Kind::Slip);
        self.assemble_contacts(delassus, symmetric, matrix)?;
        self.assemble_rows(sets, delassus, symmetric, matrix)?;
        self.elimination.factorise(matrix, symmetric)
    }

    /// The joint rows that hold.
    fn holding_rows(&self) -> impl Iterator<Item = usize> {
        let holds = self.holds.iter().enumerate().take(self.counts.rows);
        holds.filter(|&(_, &holds)| holds).map(|(j, _)| j)
    }

    /// Damps sticking contacts more the smaller their grip `mu r_N` is. Of all tangential impulses with the same effect those
    /// are preferred that use the same share of each cone.
    fn balance_damping(&mut self, sets: &Sets<T, D, C, R>, point: &Point<T, D, C, R>) {
        let sets = sets.contacts();
        let grips = || {
            let contacts = sets.iter().zip(&point.z.contacts);
            contacts.map(|(set, &z)| set.cone.friction() * split(&z.into()).0.abs())
        };
        let (mut sum, mut sticking) = (T::ZERO, T::ZERO);
        for (frame, grip) in self.frames.iter().zip(grips()) {
            if frame.kind == Kind::Stick {
                sum += grip;
                sticking += T::ONE;
            }
        }
        for (frame, grip) in self.frames.iter_mut().zip(grips()) {
            if frame.kind == Kind::Stick {
                let weight = sum / (sticking * grip);
                frame.tangential_damping = self.damping * weight.min(T::literal(100.0));
            }
        }
    }

    /// Does everything do at a point what it did where this was computed?
    #[inline(never)]
    pub(crate) fn has_same_active_set(
        &self,
        sets: &Sets<T, D, C, R>,
        point: &Point<T, D, C, R>,
    ) -> bool {
        let contacts = point.p.contacts.iter().zip(&point.r.contacts);
        let mut contacts = sets
            .contacts()
            .iter()
            .zip(contacts)
            .zip(&self.order.contacts);
        let rows = sets.rows().iter().zip(&point.r.rows);
        let mut rows = rows.zip(&self.order.rows);
        self.counts == sets.counts()
            && contacts.all(|((set, (&velocity, r)), &frame)| {
                let kind = || Kind::of(set, &velocity.into(), r);
                self.frames
                    .get(frame)
                    .is_some_and(|frame| frame.kind == kind())
            })
            && rows.all(|((set, &r), &row)| self.holds.get(row) == Some(&set.holds(r)))
    }

    /// Residual plus a term that reduces internal tangential impulses (by the weights of [`Self::balance_damping`]).
    ///
    /// Impulses of a hyperstatic scene that were carried from step to step end on the boundaries of their cones, although
    /// others inside have the same effect. What a contact on the boundary does next is hard to foresee.
    pub(crate) fn centred(&self, point: &Point<T, D, C, R>) -> Stacked<T, D, C, R> {
        let mut residual = point.residual;
        let contacts = self.order.contacts.iter().zip(&point.z.contacts);
        for (residual, (&place, z)) in residual.contacts.iter_mut().zip(contacts) {
            if let Some(frame) = self.frames.get(place)
                && frame.kind == Kind::Stick
            {
                for (residual, &z) in residual.iter_mut().zip(z).skip(1) {
                    *residual -= frame.tangential_damping * z;
                }
            }
        }
        residual
    }

    /// The step `d` for a residual; `None` if it is not finite.
    #[inline(never)]
    pub(crate) fn step(
        &self,
        sets: &Sets<T, D, C, R>,
        delassus: &Delassus<T, D, C, R>,
        residual: &Stacked<T, D, C, R>,
        matrix: &StackedMatrix<T, D, C, R>,
    ) -> Option<Stacked<T, D, C, R>> {
        let counts = self.counts;
        let order = self.order.contacts.get(..counts.contacts)?;
        let row_order = self.order.rows.get(..counts.rows)?;
        let mut unknowns = Stacked::zero();
        let of_contacts = unknowns.contacts.as_flattened_mut();
        for (&place, residual) in order.iter().zip(&residual.contacts) {
            let unknowns = of_contacts.get_mut(self.elimination.columns(place))?;
            let right = self.frames.get(place)?.test(residual);
            for (unknown, right) in unknowns.iter_mut().zip(right) {
                *unknown = right;
            }
        }
        // Where in the system each joint row stands that holds.
        let mut unknown_rows = [R; R];
        for (place, j) in self.holding_rows().enumerate() {
            *unknown_rows.get_mut(j)? = place;
        }
        for (&place, &residual) in row_order.iter().zip(&residual.rows) {
            let unknown = unknowns.rows.get_mut(*unknown_rows.get(place)?);
            if let Some(unknown) = unknown {
                *unknown = residual;
            }
        }
        self.elimination.solve(matrix, &mut unknowns)?;
        let of_contacts = unknowns.contacts.as_flattened();
        let mut moved = Stacked::zero();
        let sticks = |frame: &Frame<T, D>| frame.kind == Kind::Stick;
        let frames = self.frames.get(..counts.contacts)?;
        let holds = self.holds.get(..counts.rows)?;
        if !(frames.iter().all(sticks) && holds.iter().all(|&holds| holds)) {
            let mut push = Stacked::zero();
            for (&place, push) in order.iter().zip(&mut push.contacts) {
                let unknowns = of_contacts.get(self.elimination.columns(place))?;
                *push = self.frames.get(place)?.impulse(unknowns);
            }
            for (&place, push) in row_order.iter().zip(&mut push.rows) {
                let unknown = unknowns.rows.get(*unknown_rows.get(place)?);
                *push = unknown.copied().unwrap_or(T::ZERO);
            }
            delassus.times(&push, &mut moved, counts);
        }
        let undamped = T::ONE / (T::ONE + self.damping);
        let mut steps = Stacked::zero();
        let contacts = residual.contacts.iter().zip(&moved.contacts);
        let contacts = contacts.zip(sets.contacts().iter().zip(order));
        for (step, ((&residual, &moved), (set, &place))) in steps.contacts.iter_mut().zip(contacts)
        {
            let unknowns = of_contacts.get(self.elimination.columns(place))?;
            let left = SVector::from(residual) - SVector::from(moved);
            let frame = self.frames.get(place)?;
            *step = frame.step(set, unknowns, left, undamped).into();
        }
        let rows = residual.rows.iter().zip(&moved.rows);
        let rows = rows.zip(sets.rows().iter().zip(row_order));
        for (step, ((&residual, &moved), (set, &place))) in steps.rows.iter_mut().zip(rows) {
            *step = match unknowns.rows.get(*unknown_rows.get(place)?) {
                Some(&unknown) => unknown * undamped / set.alpha,
                None => (residual - moved) * undamped,
            };
        }
        steps.is_finite().then_some(steps)
    }
}

#[cfg(test)]
mod tests;
