//! Gauss-Seidel sweeps, and their number ([`crate::guide::method`]).
//!
//! The error after a sweep is estimated from the slip multipliers of the contacts, without roots. The natural map is computed only if this
//! estimate is within the tolerance.
//!
//! Eight sweeps are made at least: a Newton step takes as long as five, and with a short budget its result is often of no use. They continue
//! while eight more at the present rate reach the tolerance.

use crate::linalg::vector::quotient;
use crate::problem::Problem;
use crate::real::Real;
use crate::sets::sweep;
use crate::solution::Model;
use crate::solver::phases::Phases;
use crate::solver::record::Measure;
use crate::solver::solve::Solve;
use crate::solver::tuning;
use core::mem;

/// Share of the tolerance up to which the estimate of a sweep needs no natural map to confirm it.
const CLEAR: f64 = 0.5;

/// The outcome of a sweep.
pub(crate) enum Pace {
    /// Another sweep pays, or the phase has to return.
    Continue,
    /// Another sweep does not pay: the next phase follows.
    Enough,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize, P: Phases>
    Solve<'_, '_, T, N, D, C, R, S, P>
{
    /// Begins sweeps after a rejected Newton step: a few, and twice as many each next time.
    pub(super) fn sweep_for_longer(&mut self) {
        let first = u16::try_from(tuning::sweeps_at_jam()).unwrap_or(u16::MAX);
        self.state.sweeps.at_least = self.state.sweeps.at_least.saturating_mul(2).max(first);
        self.state.sweeps.done = 0;
    }

    /// Computes the velocities again if a check of the error may have corrected their constant terms.
    pub(super) fn apply_correction(&mut self) {
        if self.state.point.estimate <= self.monitor.tolerance() {
            self.evaluate_impulses();
        }
    }

    /// Makes one sweep, and counts its work.
    pub(super) fn sweep_once(&mut self) {
        self.monitor.solution.work.sweeps += 1;
        let (r, u) = (&mut self.state.point.r, &mut self.state.point.u);
        let Problem { sets, factor, model, .. } = &*self.monitor.problem;
        sweep::sweep(sets, factor, *model, r, u, &mut self.state.sweeps.multipliers);
    }

    /// Estimate of the error after a sweep: from the slip multipliers, or from the natural map in the relaxation and in scenes with joint
    /// rows or surfaces.
    fn estimate_after_sweep(&self) -> T {
        let problem = &*self.monitor.problem;
        let (r, u) = (&self.state.point.r, &self.state.point.u);
        if problem.scene.is_mixed() || problem.model == Model::ConvexRelaxation {
            return problem.error_estimate(r, u);
        }
        let residual = sweep::residual_square(&problem.sets, r, u, &self.state.sweeps.multipliers);
        let reference = problem.expected_size;
        let size = problem.sets.contact_square(r).max(reference * reference);
        quotient(residual, size).square_root()
    }

    /// Makes one sweep, and decides whether another one pays.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn sweep(&mut self) -> Pace {
        self.sweep_once();
        let tolerance = self.monitor.tolerance();
        let mut estimate = self.estimate_after_sweep();
        if estimate > tolerance && self.monitor.problem.may_be_within(estimate, tolerance) {
            self.monitor.count_stopping();
            estimate = self.estimate_after_sweep();
        }
        let last = mem::replace(&mut self.state.point.estimate, estimate);
        if estimate <= tolerance {
            if estimate > tolerance * T::literal(CLEAR) {
                let (r, u) = (&self.state.point.r, &self.state.point.u);
                self.state.point.estimate = self.monitor.problem.error_estimate(r, u);
            }
            // No rest question is open: its phases are Newton's method and the central path.
            self.monitor.consider(&self.state.point.r, &self.state.point.u, self.state.point.estimate);
            if self.monitor.must_return() {
                return Pace::Continue;
            }
            estimate = estimate.max(self.state.point.estimate);
        } else {
            self.monitor.keep(&self.state.point.r, &self.state.point.u, (estimate, Measure::Estimate));
        }
        let sweeps = &mut self.state.sweeps;
        sweeps.done = sweeps.done.saturating_add(1);
        let (rate, least) = (estimate / last, tuning::sweeps());
        let after_as_many = (0..least).fold(estimate, |estimate, _| estimate * rate);
        let done = usize::from(sweeps.done);
        if estimate > tolerance
            && (done < least.max(usize::from(sweeps.at_least)) || after_as_many <= tolerance)
        {
            return Pace::Continue;
        }
        Pace::Enough
    }

    /// Compares the point after sweeps with the best impulses by the natural map, as later points are.
    pub(super) fn end_sweeps(&mut self) {
        self.monitor.estimate_best();
        let (r, u) = (&self.state.point.r, &self.state.point.u);
        let estimate = self.monitor.problem.error_estimate(r, u);
        if estimate > self.monitor.tolerance() {
            self.monitor.keep(r, u, (estimate, Measure::Estimate));
        }
    }
}

#[cfg(test)]
mod tests;
