//! The search for a solution: the best impulse so far, what it has cost, and when to stop.

use crate::linalg::stacked::Stacked;
use crate::problem::Problem;
use crate::real::Real;
use crate::solution::{Settings, Solution, Status, Work};
use crate::solver::record::{Call, Question, Record};
use crate::solver::tuning;
use core::mem;
use nalgebra::SVector;

/// How often `q` is corrected (iterative refinement) before the number type is to blame.
const CORRECTIONS: u8 = 4;

/// An error with twice the digits takes as much of a budget as so much work.
const EXACT_ERROR: usize = 20;

/// Impulses above this many times the expected size make a solution doubtful. (A tenth of it would search solved impacts for
/// a proof; five times as much would call slow walls solved.)
pub(super) const DOUBTFUL_IMPULSE_RATIO: f64 = 20.0;

/// One call that works on a solve.
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
    settings: &'s Settings<T>,
    /// The work at which the call ends.
    limit: usize,
    call: Call,
}

impl<
    's,
    'a,
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize,
    const S: usize,
> Monitor<'s, 'a, T, N, D, C, R, S>
{
    /// A solve that begins, of which there is no record yet, or one that goes on.
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
            if record.asks_for_rest() {
                problem.set_shift(false);
            }
        }
        if call == Call::Begin {
            solution.work = Work::none();
        }
        let limit = solution.work.total().saturating_add(settings.budget);
        Self {
            problem,
            solution,
            record,
            settings,
            limit,
            call,
        }
    }

    /// The tolerance asked for.
    pub(crate) fn tolerance(&self) -> T {
        self.settings.tolerance
    }

    /// The work that the call may do.
    pub(super) fn budget(&self) -> usize {
        self.settings.budget
    }

    /// Is it the first call for its tick?
    pub(crate) fn is_first_call(&self) -> bool {
        self.call == Call::Begin
    }

    /// Does it go on?
    pub(crate) fn is_running(&self) -> bool {
        !self.is_over() && self.solution.work.total() < self.limit
    }

    /// Is there to be an answer about the point, or an end, before the search goes on?
    pub(crate) fn waits(&self) -> bool {
        self.is_over() || self.record.question != Question::Nothing
    }

    /// Is the error of the point asked for? To compute it takes nothing of the budget.
    pub(crate) fn asks_for_error(&self) -> bool {
        !self.is_over() && self.record.question == Question::Error
    }

    /// Has it ended?
    pub(crate) fn is_over(&self) -> bool {
        self.record.is_over()
    }

    /// Ends it.
    pub(crate) fn stop(&mut self, status: Status) {
        self.record.status = status;
    }

    /// Counts `|stop|` from now on; the best impulse has to be measured again.
    pub(crate) fn count_stopping(&mut self) {
        self.problem.count_stopping();
        self.record.counts_stopping = true;
        self.record.estimate = None;
    }

    /// Keeps an impulse if it is the best so far. If it is good enough in contact space, its error is [asked for](Self::judge).
    pub(crate) fn consider(
        &mut self,
        r: &Stacked<T, D, C, R>,
        u: &Stacked<T, D, C, R>,
        mut estimate: T,
    ) {
        let tolerance = self.settings.tolerance;
        if estimate <= tolerance && self.problem.has_unexpected_impulse(r) {
            self.count_stopping();
            estimate = self.problem.error_estimate(r, u);
        }
        if estimate > tolerance && self.problem.may_be_within(estimate, tolerance) {
            self.count_stopping();
            estimate = self.problem.error_estimate(r, u);
        }
        if self.record.estimate.is_some_and(|best| estimate >= best) {
            return;
        }
        self.record.best = *r;
        self.record.estimate = Some(estimate);
        if estimate <= tolerance {
            self.record.question = Question::Error;
        }
    }

    /// Answers what is asked about the best impulse, which was [considered](Self::consider) last, and stops if it solves the problem.
    ///
    /// `u = W r + q`. If the error exceeds the tolerance, it is asked for with twice the digits. If that exceeds it, too, `H v + w` and
    /// `W r + q` differ by rounding: the difference is added to `q`, and the search continues (iterative refinement).
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn judge(&mut self) {
        let (r, mut u) = (self.record.best, Stacked::zero());
        let mut is_solved = self.is_within(&r);
        if !is_solved && !self.problem.counts_stopping {
            self.count_stopping();
            self.record.estimate = Some(self.problem.velocities_and_estimate(&r, &mut u));
            is_solved = self.is_within(&r);
        }
        let question = mem::replace(&mut self.record.question, Question::Nothing);
        if is_solved {
            let is_finite = self.solution.has_numbers() && r.contact_square().is_finite();
            self.stop(if is_finite {
                Status::Solved
            } else {
                Status::PrecisionLimit // squares overflow
            });
        } else if question == Question::Error {
            // What a sweep leaves is not the natural map.
            let estimate = self.problem.velocities_and_estimate(&r, &mut u);
            self.record.estimate = Some(estimate);
            if estimate <= self.settings.tolerance {
                self.record.question = Question::ExactError;
            }
        } else if self.record.corrections < CORRECTIONS {
            self.record.corrections += 1;
            self.record.estimate = Some(self.solution.error);
            self.problem.velocities(&r, &mut u);
            self.correct_velocities(&u);
        } else {
            self.stop(Status::PrecisionLimit);
        }
    }

    /// Is the error of an impulse, which becomes the solution, within the tolerance? It is computed as exactly as is asked.
    pub(super) fn is_within(&mut self, r: &Stacked<T, D, C, R>) -> bool {
        let tolerance = self.settings.tolerance;
        let exactly = self.record.question == Question::ExactError;
        if exactly {
            self.limit = self.limit.saturating_sub(EXACT_ERROR);
        }
        let wanted = (tolerance, exactly);
        self.problem.evaluate(r, wanted, self.solution);
        self.solution.error <= tolerance
    }

    /// Adds to what is added to `W r` by how much that is not `H v + w`.
    fn correct_velocities(&mut self, u: &Stacked<T, D, C, R>) {
        let scene = self.problem.scene;
        let sets = self.problem.sets.contacts_mut().iter_mut().enumerate();
        for ((i, set), (contact, &u)) in sets.zip(self.solution.contacts.iter().zip(&u.contacts)) {
            let velocity = SVector::from(scene.scale(i, contact.velocity.into()));
            set.base += velocity - SVector::from(u);
        }
        let sets = self.problem.sets.rows_mut().iter_mut();
        for (set, (row, &u)) in sets.zip(self.solution.rows.iter().zip(&u.rows)) {
            set.base += row.velocity - u;
        }
    }

    /// The impulses with the least natural map so far.
    pub(crate) fn best(&self) -> Option<Stacked<T, D, C, R>> {
        self.record.estimate.map(|_| self.record.best)
    }

    /// Notes that a Newton step was rejected, or that the interior point has jammed. If the error is near rounding and has not
    /// halved for long, rounding is to blame, and the solve ends. Otherwise it continues until its budget ends.
    pub(crate) fn note_failure(&mut self) {
        let Some(best) = self.record.estimate else {
            return;
        };
        let work = self.solution.work.on_solution();
        let two = T::ONE + T::ONE;
        match self.record.milestone {
            Some((then, since)) if two * best >= then => {
                let is_near = best < T::EPSILON * T::literal(1024.0);
                if is_near && work - since > tuning::patience() {
                    self.stop(Status::PrecisionLimit);
                }
            }
            _ => self.record.milestone = Some((best, work)),
        }
    }

    /// Writes the best impulses so far; a paused search itself is not changed.
    ///
    /// If it may go on, its present impulses and those that the last call wrote are candidates, too.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn finish(&mut self, present: &Stacked<T, D, C, R>) {
        let shown = self.call == Call::Resume
            && matches!(self.solution.status, Status::OutOfBudget | Status::Jammed);
        self.solution.status = match self.record.status {
            Status::Unsolved => Status::OutOfBudget,
            status => status,
        };
        if self.record.status == Status::Solved {
            return;
        }
        let mut r = self.record.best;
        if self.record.status == Status::Unsolved {
            let mut least = self.record.estimate;
            // The solution may be what the last call for the same solve has found.
            let shown = shown.then(|| self.shown());
            for other in [Some(*present), shown].into_iter().flatten() {
                let mut u = Stacked::zero();
                let estimate = self.problem.velocities_and_estimate(&other, &mut u);
                if least.is_none_or(|least| estimate < least) {
                    (r, least) = (other, Some(estimate));
                }
            }
            self.problem.sets.copy_bases(&mut self.record.bases);
        }
        self.problem.count_stopping();
        if self.problem.throws(&r, T::literal(DOUBTFUL_IMPULSE_RATIO)) {
            r = Stacked::zero();
        }
        // What goes on may know it more exactly later.
        let exactly = self.record.status == Status::PrecisionLimit;
        let wanted = (self.settings.tolerance, exactly);
        self.problem.evaluate(&r, wanted, self.solution);
        if !self.solution.has_numbers() {
            // Squares overflow, and no impulse is known.
            let none = Stacked::zero();
            self.problem
                .evaluate(&none, (T::ZERO, false), self.solution);
        }
    }

    /// Leaves the search for a later call, without a solution.
    pub(crate) fn pause(&mut self) {
        self.problem.sets.copy_bases(&mut self.record.bases);
        self.solution.disown();
    }

    /// The impulses that are written down.
    pub(super) fn shown(&self) -> Stacked<T, D, C, R> {
        let mut shown = Stacked::zero();
        let contacts = shown.contacts.iter_mut().zip(&self.solution.contacts);
        for (i, (shown, contact)) in contacts.enumerate() {
            *shown = self.problem.scene.unscale(i, contact.impulse.into());
        }
        for (shown, row) in shown.rows.iter_mut().zip(&self.solution.rows) {
            *shown = row.impulse;
        }
        shown
    }
}

#[cfg(test)]
mod tests;
