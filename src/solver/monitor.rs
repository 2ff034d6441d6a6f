//! The monitor of a solve: it keeps the best impulses so far, counts the work, and decides when the solve is over.
//!
//! Two numbers measure impulses. The *estimate* is the larger of the parts of contacts and joint rows in the error
//! ([`crate::guide::error`]), computed in contact space from `u = W r + q`, without bounds on rounding. The *error* is that of
//! the solution as it is written, with its velocity. It costs more, so it is computed only where the estimate is within the
//! tolerance.

use crate::linalg::stacked::Stacked;
use crate::problem::Problem;
use crate::real::Real;
use crate::solution::{Model, Settings, Solution, Status, Work};
use crate::solver::phases::Phases;
use crate::solver::record::{Call, Check, Measure, Milestone, Record};
use crate::solver::tuning;

/// Work that an error takes from the budget if it is computed to compare impulses.
const PLAIN_ERROR: usize = 6;

/// The monitor of one call that works on a solve.
pub(crate) struct Monitor<
    's,
    'a,
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize,
    const S: usize,
> {
    pub(crate) problem: &'s mut Problem<'a, T, N, D, C, R, S>,
    pub(crate) solution: &'s mut Solution<T, N, D, C, R>,
    pub(super) record: &'s mut Record<T, D, C, R>,
    pub(super) settings: &'s Settings<T>,
    /// Total work of the solve at which the call ends.
    pub(super) work_limit: usize,
    /// Has the solution the best impulses so far, with their plain error?
    pub(super) holds_best: bool,
    pub(super) call: Call,
}

impl<'s, 'a, T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Monitor<'s, 'a, T, N, D, C, R, S>
{
    /// The monitor of a call. If the call resumes a solve, the problem takes over the corrections that the record keeps.
    pub(crate) fn new(
        problem: &'s mut Problem<'a, T, N, D, C, R, S>,
        settings: &'s Settings<T>,
        solution: &'s mut Solution<T, N, D, C, R>,
        record: &'s mut Record<T, D, C, R>,
        call: Call,
    ) -> Self {
        solution.certificate.clear();
        solution.row_certificate.clear();
        if call == Call::Resume {
            problem.sets.set_bases(&record.bases);
            if record.counts_stopping {
                problem.count_stopping();
            }
            if record.solves_relaxation() {
                problem.set_law(Model::ConvexRelaxation);
            }
        }
        if call == Call::Begin {
            solution.work = Work::none();
        }
        let work_limit = solution.work.total().saturating_add(settings.budget);
        Self { problem, solution, record, settings, work_limit, holds_best: false, call }
    }

    /// The tolerance of the call.
    pub(crate) fn tolerance(&self) -> T {
        self.settings.tolerance
    }

    /// The budget of the call.
    pub(super) fn budget(&self) -> usize {
        self.settings.budget
    }

    /// Is this the first call of its tick?
    pub(crate) fn is_first_call(&self) -> bool {
        self.call == Call::Begin
    }

    /// Is the solve under way, with some of the budget to spend?
    pub(crate) fn is_running(&self) -> bool {
        !self.is_over() && self.solution.work.total() < self.work_limit
    }

    /// Does a phase have to return now, because the solve is over or a check of the error is due?
    pub(crate) fn must_return(&self) -> bool {
        self.is_over() || self.is_check_due()
    }

    /// Is a check of the error due?
    pub(crate) fn is_check_due(&self) -> bool {
        self.record.check != Check::None
    }

    /// Is a check of the error due that takes nothing from the budget?
    pub(crate) fn is_free_check_due(&self) -> bool {
        !self.is_over() && self.record.check == Check::Error
    }

    /// Is the solve over?
    pub(crate) fn is_over(&self) -> bool {
        self.record.is_over()
    }

    /// Ends the solve.
    pub(crate) fn stop(&mut self, status: Status) {
        self.record.status = status;
    }

    /// Includes `|stop|` in the expected size of the impulses from now on ([`crate::guide::error`]). That changes all estimates.
    pub(crate) fn count_stopping(&mut self) {
        self.problem.count_stopping();
        self.record.counts_stopping = true;
        self.estimate_best();
    }

    /// Computes the estimate of the best impulses again, by the natural map. One within the tolerance is not kept: their error was above it.
    pub(super) fn estimate_best(&mut self) {
        if let Some(best) = self.best() {
            let estimate = self.problem.velocities_and_estimate(best, &mut Stacked::zero());
            if estimate > self.settings.tolerance {
                self.record.best_estimate = Some(estimate);
            }
        }
    }

    /// Keeps impulses if their estimate is the least so far. If it is within the tolerance, a [check](Self::check) of their error is due, and
    /// decides whether they are kept.
    pub(crate) fn consider(&mut self, r: &Stacked<T, D, C, R>, u: &Stacked<T, D, C, R>, mut estimate: T) {
        let tolerance = self.settings.tolerance;
        if estimate <= tolerance && self.problem.has_unexpected_impulse(r) {
            self.count_stopping();
            estimate = self.problem.error_estimate(r, u);
        }
        if estimate > tolerance && self.problem.may_be_within(estimate, tolerance) {
            self.count_stopping();
            estimate = self.problem.error_estimate(r, u);
        }
        if estimate > tolerance {
            self.keep(r, u, (estimate, Measure::Estimate));
        } else if self.record.best_estimate.is_none_or(|best| estimate < best) {
            self.record.check = Check::Error;
        }
    }

    /// Keeps impulses with the velocities `u` if their estimate is the least so far, unless they are absurd. Once the best are known by their
    /// error, others count by theirs.
    pub(crate) fn keep(
        &mut self,
        r: &Stacked<T, D, C, R>,
        u: &Stacked<T, D, C, R>,
        (mut estimate, mut measure): (T, Measure),
    ) {
        let best = self.record.best_estimate;
        let is_more = |estimate: T| best.is_some_and(|best| estimate >= best && best.is_finite());
        let differ = (self.record.measure, measure) == (Measure::Error, Measure::Estimate);
        let measures = differ && !is_more(estimate);
        if measures {
            self.charge(PLAIN_ERROR);
            self.evaluate(r, false);
            (estimate, measure) = (self.solution.error, Measure::Error);
        }
        if is_more(estimate) {
            return;
        }
        if best.is_some() && self.is_absurd(r, u) {
            self.record.has_doubted = true;
            return;
        }
        self.holds_best = measures;
        self.record.best = *r;
        self.record.best_estimate = Some(estimate);
        self.record.measure = measure;
    }

    /// The impulses with the least estimate so far.
    pub(crate) fn best(&self) -> Option<&Stacked<T, D, C, R>> {
        self.record.best_estimate.map(|_| &self.record.best)
    }

    /// Notes that a Newton step was rejected, or that the central path has jammed.
    ///
    /// If the least estimate is near rounding and has not halved for long, rounding is to blame, and the solve ends. Otherwise it continues
    /// until its budget is used up.
    pub(crate) fn note_failure(&mut self) {
        let Some(estimate) = self.record.best_estimate else {
            return;
        };
        let work = self.solution.work.on_solution();
        let two = T::ONE + T::ONE;
        match self.record.milestone {
            Some(last) if two * estimate >= last.estimate => {
                let is_near = estimate < T::EPSILON * T::literal(1024.0);
                if is_near && work - last.work > tuning::patience() {
                    self.stop(Status::PrecisionLimit);
                }
            }
            _ => self.record.milestone = Some(Milestone { estimate, work }),
        }
    }

    /// Writes the solution of the best impulses so far. The search may continue as if they had not been written. Unless the solve has ended,
    /// returns the velocities and impulses that are written.
    pub(crate) fn finish<P: Phases>(&mut self) -> Option<[Stacked<T, D, C, R>; 2]> {
        self.solution.status = match self.record.status {
            Status::Unsolved => Status::OutOfBudget,
            status => status,
        };
        if self.record.status == Status::Solved {
            return None;
        }
        let is_unsolved = self.record.status == Status::Unsolved;
        if is_unsolved {
            self.problem.sets.copy_bases(&mut self.record.bases);
        }
        self.problem.count_stopping();
        let (mut r, mut u) = (self.record.best, Stacked::zero());
        self.problem.velocities(&r, &mut u);
        let is_absurd = self.is_absurd(&r, &u);
        if is_absurd {
            r = Stacked::zero();
        }
        // A solve that continues may compute it more exactly later.
        let exactly = P::EXACT_ERRORS && self.record.status == Status::PrecisionLimit;
        if is_absurd || exactly || !self.holds_best {
            let wanted = (self.settings.tolerance, exactly);
            self.problem.evaluate(&r, wanted, self.solution);
        }
        let overflows = !self.solution.has_numbers(); // of squares: zero impulses are written
        if overflows {
            r = Stacked::zero();
            self.problem.evaluate(&r, (T::ZERO, false), self.solution);
        }
        if is_absurd || overflows {
            self.problem.velocities(&r, &mut u);
        }
        let is_within = self.solution.error <= self.settings.tolerance && self.has_numbers(&r);
        if is_unsolved && is_within && !(self.is_doubtful(&r) && self.problem.squeezes(&r, self.solution)) {
            // The estimate was that of rounding.
            self.stop(Status::Solved);
            self.solution.status = Status::Solved;
        }
        is_unsolved.then_some([u, r])
    }

    /// Pauses the search for a later call, and writes no solution.
    pub(crate) fn pause(&mut self) {
        self.problem.sets.copy_bases(&mut self.record.bases);
        self.solution.invalidate();
    }
}

#[cfg(test)]
mod tests;
