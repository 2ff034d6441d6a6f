//! Warm start: the velocities and impulses of the last solve, by key, and the start of the next solve from them
//! ([`crate::guide::method`]).
//!
//! `ũ` is the augmented velocity at the end of the last solve: the `P` of Newton's method, which lies in the dual cones.

use crate::error::{Error, Input, List};
use crate::linalg::stacked::Stacked;
use crate::linalg::zip::{zip3, zip4};
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
mod words;

/// Impulses more than this many times the expected size are no start.
const MAX_IMPULSE_RATIO: f64 = 1e8;

/// Number of creeping ticks in a row after which a body asks the [rest question](super::rest).
const CREEPING_TICKS: u8 = 4;

/// The kind of start of a solve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum WarmStartKind {
    /// Cold: without impulses.
    None,
    /// At the last solution. Its impulses are unique, so sweeps may continue from it.
    Isostatic,
    /// At the last solution. Its impulses are not unique.
    Hyperstatic,
}

/// Where the next solve starts: velocities and impulses of the last solve by key, and the impulses of the solve before.
///
/// A solver that is given it ([`crate::Solver::set_warm_start`]) goes on as the one that it comes from.
///
/// ```
/// # use stiction::{Kernel, WarmStart};
/// let kernel = Kernel::<f32, 6, 3, 4>::new();
/// let words = kernel.solver().warm_start().words().collect::<Vec<u64>>(); // for a file, or another process
/// let mut other = Kernel::<f32, 6, 3, 4>::new();
/// other.solver_mut().set_warm_start(WarmStart::from_words(words).expect("of the same sizes"));
/// ```
#[derive(Clone, Debug)]
pub struct WarmStart<T, const D: usize, const C: usize, const R: usize> {
    contacts: Table<T, D, C>,
    rows: Table<T, 1, R>,
    /// Was the last solve solved?
    pub(super) is_solved: bool,
    /// Did the caller declare that nothing moved before the next solve?
    presumes_rest: bool,
    /// Was a rest disturbed, and were the internal forces not centred since?
    pub(super) is_disturbed: bool,
    /// Number of creeping ticks in a row.
    creeping_ticks: u8,
}

impl<T: Real, const D: usize, const C: usize, const R: usize> WarmStart<T, D, C, R> {
    /// The warm start before any solve.
    pub(crate) const fn cold() -> Self {
        Self {
            contacts: Table::empty(),
            rows: Table::empty(),
            is_solved: false,
            presumes_rest: false,
            is_disturbed: false,
            creeping_ticks: 0,
        }
    }

    /// Counts creeping ticks in a row, among the ticks that are solved at their start. Returns true in the last of
    /// [`CREEPING_TICKS`].
    pub(super) fn has_crept(&mut self, creeps: bool) -> bool {
        self.creeping_ticks = if creeps { self.creeping_ticks + 1 } else { 0 };
        if self.creeping_ticks < CREEPING_TICKS {
            return false;
        }
        self.creeping_ticks = 0;
        true
    }

    /// Replaces the last solve by given impulses, each with the key of its contact or joint row.
    pub(crate) fn set(&mut self, contacts: &[(u32, SVector<T, D>)], rows: &[(u32, T)]) -> Result<(), Error> {
        let fits = |given: usize, list: List, capacity: usize| {
            let full = Error::ListFull { list, capacity };
            (given <= capacity).then_some(()).ok_or(full)
        };
        fits(contacts.len(), List::InitialImpulses, C)?;
        fits(rows.len(), List::InitialRowImpulses, R)?;
        for (contact, r) in contacts.iter().map(|(_, r)| r).enumerate() {
            check_finite(r, Input::InitialImpulse { contact })?;
        }
        for (row, &r) in rows.iter().map(|(_, r)| r).enumerate() {
            check_finite(&SVector::from([r]), Input::InitialRowImpulse { row })?;
        }
        self.is_solved = false;
        self.contacts.set(contacts.iter().map(|&(key, r)| (key, r.into())));
        self.rows.set(rows.iter().map(|&(key, r)| (key, [r])));
        Ok(())
    }

    /// Declares that nothing moved before the next solve.
    pub(crate) fn presume_rest(&mut self) {
        self.presumes_rest = true;
    }

    /// Is there no last solve?
    fn is_cold(&self) -> bool {
        self.contacts.known().next().is_none() && self.rows.known().next().is_none()
    }

    /// Sorts the tables into the order of the next scene. Returns the old indices of its contacts and joint rows if any index has changed.
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
        let mut earlier_indices = EarlierIndices { contacts: from_fn(|i| i), rows: from_fn(|j| j) };
        if moved {
            earlier_indices.contacts = self.contacts.reorder(contacts());
        }
        if rows_moved {
            earlier_indices.rows = self.rows.reorder(rows());
        }
        Some(earlier_indices)
    }

    /// Keeps `ũ` and `r` of a solve, given in scaled rows. If it `replaces` the last call, that call belongs to the same solve.
    pub(crate) fn keep<const N: usize, const S: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, R, S>,
        u: &Stacked<T, D, C, R>,
        r: &Stacked<T, D, C, R>,
        replaces: bool,
    ) {
        self.presumes_rest = false;
        for (i, contact, &u, &r) in zip4(0..C, scene.contacts(), &u.contacts, &r.contacts) {
            let (u, r) = (scene.physical_velocity(i, u), scene.physical_impulse(i, r));
            self.contacts.keep(i, contact.key, u, r, replaces);
        }
        for (j, row, &u, &r) in zip4(0..R, scene.rows(), &u.rows, &r.rows) {
            self.rows.keep(j, row.key, [u], [r], replaces);
        }
    }

    /// The keys of the joint rows of the last solve, in their order.
    pub(crate) fn row_keys(&self) -> impl Iterator<Item = u32> {
        self.rows.known().map(|entry| entry.key)
    }

    /// Did a joint row with this key push in the last solve?
    pub(crate) fn has_pushed(&self, key: u32) -> bool {
        let mut rows = self.rows.known();
        rows.any(|entry| entry.key == key && entry.r != [T::ZERO])
    }

    /// Fills `u` with `ũ` and `r` with the impulses of the last solve, in scaled rows. A new contact or joint row gets zeros.
    #[inline]
    fn recall<const N: usize, const S: usize>(
        &self,
        scene: &Scene<T, N, D, C, R, S>,
        u: &mut Stacked<T, D, C, R>,
        r: &mut Stacked<T, D, C, R>,
    ) {
        for (i, u, r, entry) in zip4(0..C, &mut u.contacts, &mut r.contacts, &self.contacts.entries) {
            let known = entry
                .as_ref()
                .map(|entry| (scene.scaled_velocity(i, entry.u), scene.scaled_impulse(i, entry.r)));
            (*u, *r) = known.unwrap_or(([T::ZERO; D], [T::ZERO; D]));
        }
        for (u, r, entry) in zip3(&mut u.rows, &mut r.rows, &self.rows.entries) {
            let known = entry.as_ref().map(|&Entry { u: [u], r: [r], .. }| (u, r));
            (*u, *r) = known.unwrap_or((T::ZERO, T::ZERO));
        }
    }

    /// `ũ` and `r` of the last solve in the order of the scene, for ADMM. Impulses are projected onto their cones and intervals.
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

    /// Moves the point to the start of a solve: to the last solution if its estimate now is less than that of zero impulses, otherwise to
    /// zero impulses. [`Self::follow`] comes before. (Estimates are relative to the impulses, so huge impulses are no start.)
    ///
    /// Unique impulses are extrapolated if the solve goes `onwards` to the next tick. Hyperstatic impulses are not: they can change without
    /// moving a body, and would reach the boundaries of their cones tick by tick.
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
                problem.can_be_swept() && !problem.is_hyperstatic(&point.r, problem.sets.free_rows(&point.r));
            if unique && onwards {
                self.extrapolate(problem, tolerance, point);
            } else if unique || !P::NEWTON {
                point.evaluate_impulses(problem);
            } else {
                self.choose_hyperstatic(problem, tolerance, point);
            }
            let ratio = T::literal(MAX_IMPULSE_RATIO);
            if point.estimate < rest && !problem.exceeds(&point.r, ratio) {
                return if unique { WarmStartKind::Isostatic } else { WarmStartKind::Hyperstatic };
            }
            point.set_zero_impulse(problem);
        }
        WarmStartKind::None
    }

    /// Extrapolates the impulses of the point. If the estimates of the extrapolated and of the last impulses are both within the tolerance,
    /// keeps the last: a body at rest must not drift with the errors of its impulses.
    #[cfg_attr(target_os = "none", inline(never))]
    fn extrapolate<const N: usize, const S: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C, R, S>,
        tolerance: T,
        point: &mut NewtonPoint<T, D, C, R>,
    ) {
        let (r, mut u) = (point.r, Stacked::zero());
        self.impulses(problem, true, &mut point.r);
        point.evaluate_impulses(problem);
        if point.estimate <= tolerance {
            let last = problem.velocities_and_estimate(&r, &mut u);
            if last <= tolerance {
                (point.r, point.u, point.estimate) = (r, u, last);
            }
        }
    }

    /// Fills `r` with the last impulses, or the extrapolated ones if `onwards`, projected onto their cones and intervals.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn impulses<const N: usize, const S: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C, R, S>,
        onwards: bool,
        r: &mut Stacked<T, D, C, R>,
    ) {
        for (i, r, entry) in zip3(0..C, &mut r.contacts, &self.contacts.entries) {
            if let Some(entry) = entry {
                *r = problem.scene.scaled_impulse(i, entry.impulse(onwards));
            }
        }
        for (r, entry) in r.rows.iter_mut().zip(&self.rows.entries) {
            if let Some(entry) = entry {
                [*r] = entry.impulse(onwards);
            }
        }
        problem.sets.project(r);
    }

    /// Moves the point from the last impulses to the better of two `z`: `û - r / alpha` with the last impulses and the velocities that they
    /// cause now, or the last `z`.
    ///
    /// The estimate decides. (The merit is a poor measure: if a heavy body stands on a light one, it sees only the light one.)
    #[cfg_attr(target_os = "none", inline(never))]
    fn choose_hyperstatic<const N: usize, const S: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C, R, S>,
        tolerance: T,
        point: &mut NewtonPoint<T, D, C, R>,
    ) {
        let (r, mut u) = (point.r, Stacked::zero());
        let last = problem.velocities_and_estimate(&r, &mut u);
        let mut of_last_z = None;
        if last > tolerance && self.is_a_solution() {
            self.move_to_last_z(problem, point);
            of_last_z = Some(point.estimate);
        }
        if of_last_z.is_none_or(|estimate| estimate * T::literal(3.0) > last) {
            (point.r, point.u, point.estimate) = (r, u, last);
            problem.sets.augment(&u, &mut point.p);
            if let Some(estimate) = of_last_z {
                point.rebuild(problem);
                if estimate < point.estimate {
                    self.move_to_last_z(problem, point);
                }
            }
        }
    }

    /// Was the last solution at rest: did its loaded contacts move by at most 8 tolerances?
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
            && (self.presumes_rest || pushed && !problem.loaded_contacts_move(&r, &u, share))
    }

    /// Do all `ũ` and `r` come from a solve? (Given impulses have no `ũ`.)
    fn is_a_solution(&self) -> bool {
        self.contacts.known().all(|entry| entry.solves > 0) && self.rows.known().all(|entry| entry.solves > 0)
    }

    /// Moves the point to the last `z = ũ - r / alpha`.
    #[cfg_attr(target_os = "none", inline(never))]
    fn move_to_last_z<const N: usize, const S: usize>(
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
