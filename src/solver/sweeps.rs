//! Gauss-Seidel sweeps, and their number ([`crate::guide::method`]).
//!
//! The error after a sweep is estimated from the slip multipliers of the contacts, without roots. The natural map is computed only if this
//! estimate is within the tolerance.
//!
//! A Newton step costs as much as five sweeps. Sweeps continue while they are fast, or while five more at the present rate reach the
//! tolerance. After a rejected Newton step more sweeps pay, because the central path takes ten times as long.

use crate::linalg::vector::quotient;
use crate::problem::Problem;
use crate::real::Real;
use crate::sets::sweep;
use crate::solution::Model;
use crate::solver::monitor::Monitor;
use crate::solver::newton::Newton;
use crate::solver::state::{State, Sweeps};
use crate::solver::tuning;
use core::mem;

/// Share of the tolerance up to which the estimate of a sweep needs no natural map to confirm it.
const CLEAR: f64 = 0.5;

/// Least number of sweeps before the central path: fewer do not tell their rate.
const LEAST_BEFORE_PATH: usize = 3;

/// The outcome of a sweep.
pub(crate) enum Pace {
    /// Another sweep pays, or the phase has to return.
    Continue,
    /// Another sweep does not pay: the next phase follows.
    Enough,
}

impl<T: Real, const D: usize, const C: usize, const R: usize> State<T, D, C, R> {
    /// Begins sweeps at the impulses and `u` of the point.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn begin_sweeps<const N: usize, const S: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
    ) {
        self.sweeps = Sweeps { is_cold: monitor.problem.sets.are_least(&self.point.r), ..Sweeps::none() };
    }

    /// Newton's method as it follows the sweeps.
    pub(super) fn newton_after_sweeps(&self) -> Newton {
        if self.sweeps.is_cold { Newton::new() } else { Newton::warm(false) }
    }

    /// Begins sweeps after a rejected Newton step: a few, and twice as many each next time.
    pub(super) fn sweep_for_longer(&mut self) {
        let first = u16::try_from(tuning::sweeps_at_jam()).unwrap_or(u16::MAX);
        self.sweeps.at_least = self.sweeps.at_least.saturating_mul(2).max(first);
        self.sweeps.done = 0;
        self.sweeps.is_cold = true; // so that the next rejected step leads here, too
    }

    /// Begins sweeps that the central path follows.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn sweep_before_path(&mut self) {
        self.sweeps = Sweeps { lead_to_path: true, ..Sweeps::none() };
    }

    /// Computes the velocities again if a check of the error may have corrected their constant terms.
    pub(super) fn apply_correction<const N: usize, const S: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
    ) {
        if self.point.estimate <= monitor.tolerance() {
            self.point.evaluate_impulses(monitor.problem);
        }
    }

    /// Makes one sweep, and counts its work.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn sweep_once<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) {
        monitor.solution.work.sweeps += 1;
        let (r, u) = (&mut self.point.r, &mut self.point.u);
        let Problem { sets, factor, model, .. } = &*monitor.problem;
        sweep::sweep(sets, factor, *model, r, u, &mut self.sweeps.multipliers);
    }

    /// Estimate of the error after a sweep: from the slip multipliers, or from the natural map in the relaxation and in scenes with joint
    /// rows or surfaces.
    fn estimate_after_sweep<const N: usize, const S: usize>(
        &self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
    ) -> T {
        let problem = &*monitor.problem;
        let (r, u) = (&self.point.r, &self.point.u);
        if problem.scene.is_mixed() || problem.model == Model::ConvexRelaxation {
            return problem.error_estimate(r, u);
        }
        let residual = sweep::residual_square(&problem.sets, r, u, &self.sweeps.multipliers);
        let reference = problem.expected_size;
        let size = r.contact_square().max(reference * reference);
        quotient(residual, size).square_root()
    }

    /// Makes one sweep, and decides whether another one pays.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn sweep<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) -> Pace {
        self.sweep_once(monitor);
        let tolerance = monitor.tolerance();
        let mut estimate = self.estimate_after_sweep(monitor);
        if estimate > tolerance && monitor.problem.may_be_within(estimate, tolerance) {
            monitor.count_stopping();
            estimate = self.estimate_after_sweep(monitor);
        }
        let last = mem::replace(&mut self.point.estimate, estimate);
        if estimate <= tolerance {
            if estimate > tolerance * T::literal(CLEAR) {
                let (r, u) = (&self.point.r, &self.point.u);
                self.point.estimate = monitor.problem.error_estimate(r, u);
            }
            self.consider(monitor);
            if monitor.must_return() {
                return Pace::Continue;
            }
            estimate = estimate.max(self.point.estimate);
        }
        let sweeps = &mut self.sweeps;
        sweeps.done = sweeps.done.saturating_add(1);
        // The estimate of zero impulses tells no rate.
        let first = sweeps.is_cold && sweeps.done == 1;
        let rate = if first { T::ZERO } else { estimate / last };
        let is_fast = rate < tuning::sweep_rate();
        let after_five = estimate * rate * rate * rate * rate * rate;
        let done = usize::from(sweeps.done);
        let pays = if sweeps.lead_to_path {
            let most = tuning::sweeps_before_path();
            let at_the_end = (done..most).fold(estimate, |estimate, _| estimate * rate);
            done < LEAST_BEFORE_PATH || done < most && at_the_end <= tolerance
        } else {
            is_fast && done < tuning::fast_sweeps()
                || after_five <= tolerance
                || sweeps.done < sweeps.at_least
        };
        if estimate > tolerance && pays { Pace::Continue } else { Pace::Enough }
    }
}

#[cfg(test)]
mod tests;
