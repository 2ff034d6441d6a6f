//! Gauss-Seidel's part of the method: the number of sweeps.
//!
//! What a sweep leaves is read off the contacts; the natural map, which takes roots, is computed where that is within the tolerance.
//! A Newton step costs as much as five sweeps. Sweeps go on while they are fast, or while five more at the present rate
//! reach the tolerance (`after_five`). Where a Newton step was rejected more of them pay: the central path takes ten times as long.

use crate::linalg::vector::quotient;
use crate::problem::Problem;
use crate::real::Real;
use crate::sets::sweep;
use crate::solution::Model;
use crate::solver::monitor::Monitor;
use crate::solver::newton::Newton;
use crate::solver::point::NewtonPoint;
use crate::solver::state::{State, Sweeps};
use crate::solver::tuning;
use core::mem;

/// The share of the tolerance up to which the natural map is left to the judge.
const CLEAR: f64 = 0.5;

/// Sweeps before the central path, at least: so many tell their rate.
const LEAST_BEFORE_PATH: usize = 3;

/// How sweeps get on.
pub(crate) enum Pace {
    /// Another one pays, or the solve is over.
    Continue,
    /// Newton's method is to go on from where they have led.
    Enough,
}

impl<T: Real, const D: usize, const C: usize, const R: usize> State<T, D, C, R> {
    /// Sweeps from the impulses and `u` of the point.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn begin_sweeps<const N: usize, const S: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
    ) {
        self.sweeps = Sweeps {
            is_cold: monitor.problem.sets.are_at_rest(&self.point.r),
            ..Sweeps::none()
        };
    }

    /// The Newton steps that are to follow the sweeps.
    pub(super) fn newton_after_sweeps(&self) -> Newton {
        if self.sweeps.is_cold {
            Newton::new()
        } else {
            Newton::warm(false)
        }
    }

    /// Sweeps where Newton's method has failed, and twice as many where it fails again: from rest it would fail once more.
    pub(super) fn sweep_for_longer(&mut self) {
        let first = u16::try_from(tuning::sweeps_at_jam()).unwrap_or(u16::MAX);
        self.sweeps.at_least = self.sweeps.at_least.saturating_mul(2).max(first);
        self.sweeps.done = 0;
        self.sweeps.is_cold = true; // so that a rejected step leads here again
    }

    /// Sweeps before the central path, as long as they pay.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn sweep_before_path(&mut self) {
        self.sweeps = Sweeps {
            lead_to_path: true,
            ..Sweeps::none()
        };
    }

    /// Goes on where Newton's method would: with velocities that know of a correction, if there was one.
    pub(super) fn go_on_sweeping<const N: usize, const S: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
    ) {
        let NewtonPoint { r, u, estimate, .. } = &mut self.point;
        if *estimate <= monitor.tolerance() {
            *estimate = monitor.problem.velocities_and_estimate(r, u);
        }
    }

    /// One sweep, and its work.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn sweep_once<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) {
        monitor.solution.work.sweeps += 1;
        let (r, u) = (&mut self.point.r, &mut self.point.u);
        let Problem {
            sets,
            factor,
            model,
            ..
        } = &*monitor.problem;
        sweep::sweep(sets, factor, *model, r, u, &mut self.sweeps.multipliers);
    }

    /// What a sweep has left, as an error: of contacts alone that Coulomb's law rules what each has asked for tells it.
    fn left_by_sweep<const N: usize, const S: usize>(
        &self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
    ) -> T {
        let problem = &*monitor.problem;
        let (r, u) = (&self.point.r, &self.point.u);
        if problem.scene.is_mixed() || problem.model == Model::ConvexRelaxation {
            return problem.error_estimate(r, u);
        }
        let left = sweep::residual_square(&problem.sets, r, u, &self.sweeps.multipliers);
        let reference = problem.reference_impulse;
        let size = r.contact_square().max(reference * reference);
        quotient(left, size).square_root()
    }

    /// One sweep, and how they get on.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn sweep<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) -> Pace {
        self.sweep_once(monitor);
        let tolerance = monitor.tolerance();
        let mut here = self.left_by_sweep(monitor);
        if here > tolerance && monitor.problem.may_be_within(here, tolerance) {
            monitor.count_stopping();
            here = self.left_by_sweep(monitor);
        }
        let last = mem::replace(&mut self.point.estimate, here);
        if here <= tolerance {
            if here > tolerance * T::literal(CLEAR) {
                let (r, u) = (&self.point.r, &self.point.u);
                self.point.estimate = monitor.problem.error_estimate(r, u);
            }
            self.consider(monitor);
            if monitor.waits() {
                return Pace::Continue;
            }
            here = here.max(self.point.estimate);
        }
        let sweeps = &mut self.sweeps;
        sweeps.done = sweeps.done.saturating_add(1);
        // Of zero impulses the natural map says nothing.
        let first = sweeps.is_cold && sweeps.done == 1;
        let rate = if first { T::ZERO } else { here / last };
        let is_fast = rate < tuning::sweep_rate();
        let after_five = here * rate * rate * rate * rate * rate;
        let done = usize::from(sweeps.done);
        let pays = if sweeps.lead_to_path {
            let most = tuning::sweeps_before_path();
            let at_the_end = (done..most).fold(here, |left, _| left * rate);
            done < LEAST_BEFORE_PATH || done < most && at_the_end <= tolerance
        } else {
            is_fast && done < tuning::fast_sweeps()
                || after_five <= tolerance
                || sweeps.done < sweeps.at_least
        };
        if here > tolerance && pays {
            Pace::Continue
        } else {
            Pace::Enough
        }
    }
}

#[cfg(test)]
mod tests;
