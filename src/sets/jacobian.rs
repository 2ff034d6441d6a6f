//! The linearised equation of a Newton step, factorised and kept for chord steps, which use it again ([`crate::guide::method`]).
//!
//! A step `d` solves `[W A (I - DP + δI) + DP - DS + δI] d = E`, with `A = diag(alpha)` of the mean effective masses, and with
//! the derivatives `DP` and `DS` by `z` of the projection `P` and the De Saxcé shift `S` of [`super::point`]. The damping `δ`
//! regularises hyperstatic scenes, in which `W` is singular. In the frame of a contact ([`super::contact::frame`]) most of its
//! equations decouple. The unknowns of the system change impulses: three of a spatial contact that sticks, two of one that slips,
//! one of a frictionless one, none of an open one; one of a joint row that holds, none of one at its bound. The matrix is
//! symmetric if no contact slips.

use crate::cone::split;
use crate::factor::Delassus;
use crate::linalg::elimination::Elimination;
use crate::linalg::stacked::{Counts, Stacked, StackedMatrix};
use crate::linalg::zip::{zip3, zip4, zip5};
use crate::real::Real;
use crate::sets::Sets;
use crate::sets::assembly::assemble;
use crate::sets::contact::frame::{Damped, Frame, Kind};
use crate::sets::point::NewtonPoint;
use core::array::from_fn;
use nalgebra::SVector;

/// Indices of the contacts and joint rows of a scene in an earlier list; `C` and `R` for new ones.
#[derive(Clone, Debug)]
pub(crate) struct EarlierIndices<const C: usize, const R: usize> {
    pub(crate) contacts: [usize; C],
    pub(crate) rows: [usize; R],
}

/// The linearised equation at some point, factorised.
#[derive(Clone, Debug)]
pub(crate) struct Jacobian<T: Real, const D: usize, const C: usize, const R: usize> {
    frames: [Frame<T, D>; C],
    /// Does a joint row hold?
    holds: [bool; R],
    /// Index in `frames` of each contact, and in `holds` of each joint row. [`Self::follow`] changes them with the scene.
    order: EarlierIndices<C, R>,
    pub(crate) elimination: Elimination<T, D, C, R>,
    /// The damping `δ` of Levenberg and Marquardt.
    damping: T,
    counts: Counts,
}

impl<T: Real, const D: usize, const C: usize, const R: usize> Jacobian<T, D, C, R> {
    /// No equation yet.
    pub(crate) const fn none() -> Self {
        Self {
            frames: [const { Frame::none() }; C],
            holds: [false; R],
            order: EarlierIndices { contacts: [0; C], rows: [0; R] },
            elimination: Elimination::none(),
            damping: T::ZERO,
            counts: Counts { contacts: 0, rows: 0 },
        }
    }

    /// Follows the contacts and joint rows of a scene to their new indices, from the earlier ones.
    pub(crate) fn follow(&mut self, earlier: &EarlierIndices<C, R>) {
        let old = self.order.clone();
        for (frame, &index) in self.order.contacts.iter_mut().zip(&earlier.contacts) {
            *frame = old.contacts.get(index).copied().unwrap_or(C);
        }
        for (row, &index) in self.order.rows.iter_mut().zip(&earlier.rows) {
            *row = old.rows.get(index).copied().unwrap_or(R);
        }
    }

    /// Linearises at a point and factorises the system in `matrix`; `None` if it is singular.
    #[inline(never)]
    pub(crate) fn compute(
        &mut self,
        sets: &Sets<T, D, C, R>,
        delassus: &Delassus<T, D, C, R>,
        point: &NewtonPoint<T, D, C, R>,
        damping: T,
        matrix: &mut StackedMatrix<T, D, C, R>,
    ) -> Option<()> {
        self.order = EarlierIndices { contacts: from_fn(|i| i), rows: from_fn(|j| j) };
        self.damping = damping;
        self.counts = sets.counts();
        for (frame, set, &z, &velocity, impulse) in
            zip5(&mut self.frames, sets.contacts(), &point.z.contacts, &point.p.contacts, &point.r.contacts)
        {
            let kind = Kind::of(set, &velocity.into(), impulse);
            frame.set(set, kind, &z.into(), damping);
        }
        self.balance_damping(sets, point);
        for (holds, set, &r) in zip3(&mut self.holds, sets.rows(), &point.r.rows) {
            *holds = set.holds(r);
        }
        let frames = self.frames.get(..self.counts.contacts)?;
        let unknown_rows = self.holding_rows().count();
        self.elimination.lay_out(frames.iter().map(Frame::count), unknown_rows);
        let symmetric = frames.iter().all(|frame| frame.kind != Kind::Slip);
        let contacts = frames.iter().map(|frame| Damped { frame, damping });
        // `δ A⁻¹ / (1 + δ)`, as for contacts that stick.
        let add_own = |j: usize, entry: &mut T| {
            *entry += damping / (sets.rows().get(j)?.alpha * (T::ONE + damping));
            Some(())
        };
        let rows = (self.holding_rows(), add_own);
        assemble((delassus, matrix), &self.elimination, &contacts, rows, symmetric)?;
        self.elimination.factorise(matrix, symmetric)
    }

    /// Indices of the joint rows that hold.
    fn holding_rows(&self) -> impl Iterator<Item = usize> + Clone {
        let holds = self.holds.iter().enumerate().take(self.counts.rows);
        holds.filter(|&(_, &holds)| holds).map(|(j, _)| j)
    }

    /// Damps the tangents of sticking contacts with the weight `mean(grip) / grip`, at most 100. The grip is
    /// `mu |z_N| = mu r_N / alpha` (m/s). Of all tangential impulses with the same effect the step then prefers those with the
    /// same share `|r_T| / (mu r_N)` at each contact.
    fn balance_damping(&mut self, sets: &Sets<T, D, C, R>, point: &NewtonPoint<T, D, C, R>) {
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

    /// Do all contacts and joint rows have the same mode at `point` as at the point of this Jacobian?
    #[inline(never)]
    pub(crate) fn has_same_active_set(
        &self,
        sets: &Sets<T, D, C, R>,
        point: &NewtonPoint<T, D, C, R>,
    ) -> bool {
        let order = &self.order;
        let mut contacts = zip4(&order.contacts, sets.contacts(), &point.p.contacts, &point.r.contacts);
        let mut rows = zip3(&order.rows, sets.rows(), &point.r.rows);
        self.counts == sets.counts()
            && contacts.all(|(&frame, set, &velocity, r)| {
                let kind = || Kind::of(set, &velocity.into(), r);
                self.frames.get(frame).is_some_and(|frame| frame.kind == kind())
            })
            && rows.all(|(&row, set, &r)| self.holds.get(row) == Some(&set.holds(r)))
    }

    /// Residual plus a term that reduces internal tangential impulses, by the weights of [`Self::balance_damping`].
    ///
    /// In a hyperstatic scene impulses drift from step to step to the boundaries of their cones, although other impulses inside have
    /// the same effect. At the boundary the mode of a contact is hard to predict.
    pub(crate) fn centred(&self, point: &NewtonPoint<T, D, C, R>) -> Stacked<T, D, C, R> {
        let mut residual = point.residual;
        let residuals = &mut residual.contacts;
        for (residual, &index, z) in zip3(residuals, &self.order.contacts, &point.z.contacts) {
            if let Some(frame) = self.frames.get(index)
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
        for (&index, residual) in order.iter().zip(&residual.contacts) {
            let unknowns = of_contacts.get_mut(self.elimination.columns(index))?;
            let right = self.frames.get(index)?.right_sides(residual);
            for (unknown, right) in unknowns.iter_mut().zip(right) {
                *unknown = right;
            }
        }
        // Index of the unknown of each joint row; `R` for a row at its bound.
        let mut unknown_rows = [R; R];
        for (index, j) in self.holding_rows().enumerate() {
            *unknown_rows.get_mut(j)? = index;
        }
        for (&index, &residual) in row_order.iter().zip(&residual.rows) {
            let unknown = unknowns.rows.get_mut(*unknown_rows.get(index)?);
            if let Some(unknown) = unknown {
                *unknown = residual;
            }
        }
        self.elimination.solve(matrix, &mut unknowns)?;
        let of_contacts = unknowns.contacts.as_flattened();
        // `W x` of the impulses `x` of the unknowns. No step needs it if all contacts stick and all rows hold.
        let mut moved = Stacked::zero();
        let sticks = |frame: &Frame<T, D>| frame.kind == Kind::Stick;
        let frames = self.frames.get(..counts.contacts)?;
        let holds = self.holds.get(..counts.rows)?;
        if !(frames.iter().all(sticks) && holds.iter().all(|&holds| holds)) {
            let mut impulses = Stacked::zero();
            for (&index, impulse) in order.iter().zip(&mut impulses.contacts) {
                let unknowns = of_contacts.get(self.elimination.columns(index))?;
                *impulse = self.frames.get(index)?.impulse(unknowns);
            }
            for (&index, impulse) in row_order.iter().zip(&mut impulses.rows) {
                let unknown = unknowns.rows.get(*unknown_rows.get(index)?);
                *impulse = unknown.copied().unwrap_or(T::ZERO);
            }
            delassus.times(&impulses, &mut moved, counts);
        }
        let undamped = T::ONE / (T::ONE + self.damping);
        let mut steps = Stacked::zero();
        for (step, &index, set, &residual, &moved) in
            zip5(&mut steps.contacts, order, sets.contacts(), &residual.contacts, &moved.contacts)
        {
            let unknowns = of_contacts.get(self.elimination.columns(index))?;
            let residual = SVector::from(residual) - SVector::from(moved);
            let frame = self.frames.get(index)?;
            *step = frame.step(set, unknowns, residual, undamped).into();
        }
        for (step, &index, set, &residual, &moved) in
            zip5(&mut steps.rows, row_order, sets.rows(), &residual.rows, &moved.rows)
        {
            *step = match unknowns.rows.get(*unknown_rows.get(index)?) {
                Some(&unknown) => unknown * undamped / set.alpha,
                None => (residual - moved) * undamped,
            };
        }
        steps.is_finite().then_some(steps)
    }
}

#[cfg(test)]
mod tests;
