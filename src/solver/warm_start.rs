//! What survives between solves: velocities and impulses by key, and where a solve starts from them.

use crate::error::{Error, Input, List};
use crate::linalg::stacked::Stacked;
use crate::problem::Problem;
use crate::real::Real;
use crate::scene::{Scene, check_finite};
use crate::sets::jacobian::EarlierIndices;
use crate::solution::Model;
use crate::solver::phases::Phases;
use crate::solver::point::NewtonPoint;
use core::array::from_fn;
use nalgebra::SVector;
use table::{Entry, Table};

mod table;

/// Impulses this many times as large as expected are no start.
const MAX_IMPULSE_RATIO: f64 = 1e8;

/// In the last of so many ticks in a row that creep a body asks whether it can stay.
const PATIENCE: u8 = 4;

/// What is known where a solve starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum WarmStartKind {
    /// Nothing: it starts without impulses.
    None,
    /// The last solution, which sweeps may go on from, because impulses are unique.
    Isostatic,
    /// The last solution, where they are not.
    Hyperstatic,
}

/// `ũ` and `r` of the last solve and `r` of the one before.
#[derive(Clone, Debug)]
pub(crate) struct WarmStart<T, const D: usize, const C: usize, const R: usize> {
    contacts: Table<T, D, C>,
    rows: Table<T, 1, R>,
    /// Is it known that nothing moved before the next solve?
    rests: bool,
    /// Was a rest disturbed, and internal forces not yet centred since?
    pub(super) is_disturbed: bool,
    /// So many ticks that were solved as they began crept, one after the other.
    crept: u8,
}

impl<T: Real, const D: usize, const C: usize, const R: usize> WarmStart<T, D, C, R> {
    /// Nothing solved yet.
    pub(crate) const fn cold() -> Self {
        Self {
            contacts: Table::empty(),
            rows: Table::empty(),
            rests: false,
            is_disturbed: false,
            crept: 0,
        }
    }

    /// Counts a tick that is solved as it begins. Is it the last of so many that crept that it is time to ask whether the body can stay?
    pub(super) fn has_crept(&mut self, creeps: bool) -> bool {
        self.crept = if creeps { self.crept + 1 } else { 0 };
        if self.crept < PATIENCE {
            return false;
        }
        self.crept = 0;
        true
    }

    /// Forgets the last solve for impulses that are given, each with the key of its contact or joint row.
    pub(crate) fn set(
        &mut self,
        contacts: &[(u32, SVector<T, D>)],
        rows: &[(u32, T)],
    ) -> Result<(), Error> {
        let fits = |given: usize, list: List, capacity: usize| {
            let full = Error::ListFull { list, capacity };
            (given <= capacity).then_some(()).ok_or(full)
        };
        fits(contacts.len(), List::InitialImpulses, C)?;
        fits(rows.len(), List::InitialRowImpulses, R)?;
        for (contact, (_, r)) in contacts.iter().enumerate() {
            check_finite(r, Input::InitialImpulse { contact })?;
        }
        for (row, &(_, r)) in rows.iter().enumerate() {
            check_finite(&SVector::from([r]), Input::InitialRowImpulse { row })?;
        }
        self.contacts
            .set(contacts.iter().map(|&(key, r)| (key, r.into())));
        self.rows.set(rows.iter().map(|&(key, r)| (key, [r])));
        Ok(())
    }

    /// Nothing moved before the next solve.
    pub(crate) fn presume_rest(&mut self) {
        self.rests = true;
    }

    /// Is nothing known?
    fn is_cold(&self) -> bool {
        self.contacts.known().next().is_none() && self.rows.known().next().is_none()
    }

    /// Goes over to the contacts and joint rows of the next solve. Returns their old places if any has changed its place.
    pub(crate) fn follow<const N: usize, const S: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, R, S>,
    ) -> Option<EarlierIndices<C, R>> {
        let contacts = || scene.contacts().iter().map(|contact| contact.key);
        let rows = || scene.rows().iter().map(|row| row.key);
        let moved = self.contacts.is_out_of_order(contacts());
        let rows_moved = self.rows.is_out_of_order(rows());
        if self.is_cold() || !moved && !rows_moved {
            return None;
        }
        let mut places = EarlierIndices {
            contacts: from_fn(|i| i),
            rows: from_fn(|j| j),
        };
        if moved {
            places.contacts = self.contacts.reorder(contacts());
        }
        if rows_moved {
            places.rows = self.rows.reorder(rows());
        }
        Some(places)
    }

    /// Keeps `ũ` and `r` of a solve, in scaled rows, or in place of those that the last call left.
    pub(crate) fn keep<const N: usize, const S: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, R, S>,
        u: &Stacked<T, D, C, R>,
        r: &Stacked<T, D, C, R>,
        replaces: bool,
    ) {
        self.rests = false;
        let values = u.contacts.iter().zip(&r.contacts);
        for (i, (contact, (&u, &r))) in scene.contacts().iter().zip(values).enumerate() {
            let (u, r) = (scene.unscale(i, u), scene.scale(i, r));
            self.contacts.keep(i, contact.key, u, r, replaces);
        }
        let values = u.rows.iter().zip(&r.rows);
        for (j, (row, (&u, &r))) in scene.rows().iter().zip(values).enumerate() {
            self.rows.keep(j, row.key, [u], [r], replaces);
        }
    }

    /// Did a joint row with this key push in the last solve?
    pub(crate) fn has_pushed(&self, key: u32) -> bool {
        let mut rows = self.rows.known();
        rows.any(|entry| entry.key == key && entry.r != [T::ZERO])
    }

    /// `ũ` and `r` of the last solve, in scaled rows; zeros of what was not there.
    #[inline]
    fn recall<const N: usize, const S: usize>(
        &self,
        scene: &Scene<T, N, D, C, R, S>,
        u: &mut Stacked<T, D, C, R>,
        r: &mut Stacked<T, D, C, R>,
    ) {
        let places = u.contacts.iter_mut().zip(&mut r.contacts);
        for (i, ((u, r), entry)) in places.zip(&self.contacts.entries).enumerate() {
            let known = entry
                .as_ref()
                .map(|entry| (scene.scale(i, entry.u), scene.unscale(i, entry.r)));
            (*u, *r) = known.unwrap_or(([T::ZERO; D], [T::ZERO; D]));
        }
        let places = u.rows.iter_mut().zip(&mut r.rows);
        for ((u, r), entry) in places.zip(&self.rows.entries) {
            let known = entry.as_ref().map(|&Entry { u: [u], r: [r], .. }| (u, r));
            (*u, *r) = known.unwrap_or((T::ZERO, T::ZERO));
        }
    }

    /// `ũ` and `r` of the last solve for ADMM, impulses projected into their sets.
    pub(crate) fn last<const N: usize, const S: usize>(
        &mut self,
        problem: &Problem<'_, T, N, D, C, R, S>,
    ) -> [Stacked<T, D, C, R>; 2] {
        let _ = self.follow(problem.scene);
        let [mut u, mut r] = [Stacked::zero(); 2];
        self.recall(problem.scene, &mut u, &mut r);
        problem.sets.project(&mut r);
        [u, r]
    }

    /// Where a solve starts, for what was followed: at the last solution, if its error now is less than that
    /// of zero impulses. (The error is relative: impulses of a glitch, far beyond what is expected, do not count.)
    ///
    /// Unique impulses are extrapolated if the solve is to go `onwards` from one tick to the next. Hyperstatic ones can change
    /// without effect, and would be carried to the boundaries of the cones: they stay as they were.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn start<P: Phases, const N: usize, const S: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C, R, S>,
        (tolerance, onwards): (T, bool),
        _: P,
        point: &mut NewtonPoint<T, D, C, R>,
    ) -> WarmStartKind {
        point.set_zero_impulse(problem);
        let rest = point.estimate;
        if !self.is_cold() && rest > tolerance {
            self.impulses(problem, false, &mut point.r);
            let unique =
                problem.can_be_swept() && !problem.is_redundant(problem.sets.free_rows(&point.r));
            if unique && onwards {
                self.extrapolate(problem, tolerance, point);
            } else if unique || !P::NEWTON {
                point.estimate = problem.velocities_and_estimate(&point.r, &mut point.u);
            } else {
                self.stay(problem, tolerance, point);
            }
            let ratio = T::literal(MAX_IMPULSE_RATIO);
            if point.estimate < rest && !problem.exceeds(&point.r, ratio) {
                return if unique {
                    WarmStartKind::Isostatic
                } else {
                    WarmStartKind::Hyperstatic
                };
            }
            point.set_zero_impulse(problem);
        }
        WarmStartKind::None
    }

    /// Extrapolates the impulses of a point; but if both the extrapolated and the last impulses are within tolerance, keeps the
    /// last: a body at rest must not drift with the errors of its impulses.
    #[cfg_attr(target_os = "none", inline(never))]
    fn extrapolate<const N: usize, const S: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C, R, S>,
        tolerance: T,
        point: &mut NewtonPoint<T, D, C, R>,
    ) {
        let (r, mut u) = (point.r, Stacked::zero());
        self.impulses(problem, true, &mut point.r);
        point.estimate = problem.velocities_and_estimate(&point.r, &mut point.u);
        if point.estimate <= tolerance {
            let last = problem.velocities_and_estimate(&r, &mut u);
            if last <= tolerance {
                (point.r, point.u, point.estimate) = (r, u, last);
            }
        }
    }

    /// The last impulses, or the extrapolated ones if `onwards`, projected into their sets.
    #[cfg_attr(target_os = "none", inline(never))]
    fn impulses<const N: usize, const S: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C, R, S>,
        onwards: bool,
        r: &mut Stacked<T, D, C, R>,
    ) {
        for (i, (r, entry)) in r
            .contacts
            .iter_mut()
            .zip(&self.contacts.entries)
            .enumerate()
        {
            if let Some(entry) = entry {
                *r = problem.scene.unscale(i, entry.impulse(onwards));
            }
        }
        for (r, entry) in r.rows.iter_mut().zip(&self.rows.entries) {
            if let Some(entry) = entry {
                [*r] = entry.impulse(onwards);
            }
        }
        problem.sets.project(r);
    }

    /// Moves a point from the last impulses to the last solution.
    ///
    /// Candidates: `z = û - r / alpha_i` with the last impulse and the velocity that it causes now, and the last `z`. The one
    /// with the least error is taken. (The energy is a poor judge: if a heavy body stands on a light one, it sees only the
    /// light one.)
    #[cfg_attr(target_os = "none", inline(never))]
    fn stay<const N: usize, const S: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C, R, S>,
        tolerance: T,
        point: &mut NewtonPoint<T, D, C, R>,
    ) {
        let (r, mut u) = (point.r, Stacked::zero());
        let last = problem.velocities_and_estimate(&r, &mut u);
        let mut as_it_was = None;
        if last > tolerance && self.is_a_solution() {
            self.move_back(problem, point);
            as_it_was = Some(point.estimate);
        }
        if as_it_was.is_none_or(|error| error * T::literal(3.0) > last) {
            (point.r, point.u, point.estimate) = (r, u, last);
            problem.sets.augment(&u, &mut point.p);
            if let Some(error) = as_it_was {
                point.rebuild(problem);
                if error < point.estimate {
                    self.move_back(problem, point);
                }
            }
        }
    }

    /// Did nothing that pushes slide in the last solution, as far as a tolerance tells?
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn is_at_rest<const N: usize, const S: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C, R, S>,
        tolerance: T,
    ) -> bool {
        let [mut u, mut r] = [Stacked::zero(); 2];
        self.recall(problem.scene, &mut u, &mut r);
        let mut known = self.contacts.known();
        let pushed = known.any(|entry| entry.solves > 0 && entry.r != [T::ZERO; D]);
        let share = tolerance * T::literal(8.0);
        problem.model == Model::Coulomb
            && (self.rests || pushed && !problem.moves_what_pushes(&r, &u, share))
    }

    /// Are `ũ` and `r` those of a solve?
    fn is_a_solution(&self) -> bool {
        self.contacts.known().all(|entry| entry.solves > 0)
            && self.rows.known().all(|entry| entry.solves > 0)
    }

    /// Moves a point to `z = ũ - r / alpha_i` as it was.
    #[cfg_attr(target_os = "none", inline(never))]
    fn move_back<const N: usize, const S: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C, R, S>,
        point: &mut NewtonPoint<T, D, C, R>,
    ) {
        self.recall(problem.scene, &mut point.p, &mut point.r);
        point.rebuild(problem);
    }
}

#[cfg(test)]
mod tests;
