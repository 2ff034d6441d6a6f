//! A solve under way in one call: the problem, the state of the method, and the monitor.
//!
//! [`Solve::run`] works on it until it ends or the budget does. After each piece of work it asks, in this order: does the point solve the
//! scene ([`super::check`])? If a step was rejected, is the scene solved or infeasible all the same ([`super::infeasible`])? Can
//! a body stay at rest ([`super::rest`])? And at last: which phase follows ([`super::method`])?
//!
//! The [state](super::state), the record and the solution hold all that lasts between two pieces. So a solve can pause after any piece and
//! continue later with the same bits.

use crate::linalg::stacked::Stacked;
use crate::real::Real;
use crate::solution::Status;
use crate::solver::monitor::Monitor;
use crate::solver::phases::Phases;
use crate::solver::record::Call;
use crate::solver::state::{Next, Phase, State};
use crate::solver::warm_start::{WarmStart, WarmStartKind};
use core::marker::PhantomData;

/// A solve under way in one call.
pub(super) struct Solve<
    's,
    'a,
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize,
    const S: usize,
    P,
> {
    /// The problem, the best impulses so far, the work, and the end of the solve.
    pub(super) monitor: Monitor<'s, 'a, T, N, D, C, R, S>,
    /// The point of the search, and what the phases keep.
    pub(super) state: &'s mut State<T, D, C, R>,
    pub(super) warm_start: &'s mut WarmStart<T, D, C, R>,
    pub(super) phases: PhantomData<P>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize, P: Phases>
    Solve<'_, '_, T, N, D, C, R, S, P>
{
    /// Moves the point to the best impulses so far.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn go_to_best(&mut self) {
        self.set_best_impulses();
        self.evaluate_impulses();
    }

    /// Sets the impulses of the point to the best so far, if there are any.
    pub(super) fn set_best_impulses(&mut self) {
        if let Some(best) = self.monitor.best() {
            self.state.point.r.copy_from(best);
        }
    }

    /// Shows the point to the monitor, as a solution or as an answer to the rest question.
    pub(super) fn consider(&mut self) {
        let point = &self.state.point;
        if self.monitor.problem.is_relaxed() {
            self.monitor.consider_rest(point);
        } else {
            self.monitor.consider(&point.r, &point.u, point.estimate);
        }
    }

    /// Makes the check of the error that is due.
    pub(super) fn check(&mut self) {
        let point = &self.state.point;
        if P::CENTRAL_PATH && self.monitor.problem.is_relaxed() {
            self.monitor.check_rest(point);
        } else {
            self.monitor.check::<P>(&point.r, &point.u);
        }
    }

    /// Works until the end of the solve or of the budget. Writes the solution at the end of the solve, with `writes` also at the end of the
    /// budget, and keeps the impulses for the next start.
    pub(super) fn run(&mut self, writes: bool) {
        let call = self.monitor.call;
        if call != Call::Resume {
            let start = self.begin();
            self.go_on(Ok(start));
        }
        // A check that costs nothing may find that the scene is solved.
        while self.monitor.is_running() || writes && self.monitor.is_free_check_due() {
            self.advance();
        }
        let scene = self.monitor.problem.scene;
        let written = if writes || self.monitor.is_over() {
            self.finish()
        } else {
            self.monitor.pause();
            None
        };
        if let Some([u, r]) = &written {
            // The present point of a search may be far worse than the best.
            let mut augmented = Stacked::zero();
            self.monitor.problem.sets.augment(u, &mut augmented);
            self.warm_start.keep(scene, &augmented, r, call != Call::Begin);
        } else {
            self.complete_point();
            let point = &self.state.point;
            self.warm_start.keep(scene, &point.p, &point.r, call != Call::Begin);
        }
        self.warm_start.is_solved = self.monitor.record.status == Status::Solved;
    }

    /// Does one piece of work, or the check that is due.
    fn advance(&mut self) {
        let next = if self.monitor.must_return() {
            self.check();
            self.after_check()
        } else {
            self.work()
        };
        self.go_on(next);
    }

    /// Asks whether a rejection or a rest ends the solve or changes what follows, and moves on to the next phase. If a check is due, that comes
    /// first.
    fn go_on(&mut self, mut next: Next) {
        if P::CENTRAL_PATH && !self.monitor.is_check_due() {
            if let Err(failure) = next {
                self.examine_failure(failure);
            }
            next = self.ask_rest_question(next);
        }
        let present = self.state.phase;
        self.state.phase =
            if self.monitor.must_return() { next.unwrap_or(present) } else { self.next_phase(next) };
    }

    /// Writes the solution. Unless the solve has ended, returns the velocities and impulses that are written.
    fn finish(&mut self) -> Option<[Stacked<T, D, C, R>; 2]> {
        if P::CENTRAL_PATH {
            self.end_rest_question();
        }
        let written = self.monitor.finish::<P>();
        // A search for a proof costs work.
        if P::CENTRAL_PATH && self.monitor.budget() > 0 {
            self.check_infeasibility();
        }
        written
    }

    /// Computes `P` of the point from `u`, where the last piece of work has updated only `r` and `u`: a sweep, or a step along the central path.
    pub(super) fn complete_point(&mut self) {
        match self.state.phase {
            Phase::Newton(_) | Phase::Idle => {}
            Phase::Start(WarmStartKind::Hyperstatic) if P::NEWTON => {}
            Phase::Start(_) | Phase::Sweeps | Phase::CentralPath => {
                let (problem, point) = self.problem_and_point();
                problem.sets.augment(&point.u, &mut point.p);
            }
        }
    }
}
