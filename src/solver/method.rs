//! The state machine of a solve: sweeps or a guess, then Newton's method, then the central path if Newton's method fails.
//!
//! [`crate::guide::method`] explains the phases and has a table of all transitions. In short:
//!
//! ```text
//! Sweeps ── enough ──► Newton ── rejected ──► CentralPath ── jam ──► CentralPath (another one)
//! Newton ── rejected, began without sweeps, at the last solution or at a guess ──► Sweeps, from the best impulses
//! CentralPath ── near the end, also after a jam ──► Newton ── rejected ──► CentralPath, where it was
//! Newton ── rejected, did not begin on the path ──► search for a proof of infeasibility, once in a solve
//! ```
//!
//! Where bodies were at rest, [the rest question](crate::solver::rest) may choose another phase: at the start, after a piece of work, after a
//! failure, and at the end of a call.
//!
//! A phase does one piece of work (a sweep, a step) and returns its outcome. [`Solve::advance`] alone chooses the next phase. If the
//! estimate of a point is within the tolerance, the monitor checks its error before the next piece ([`crate::solver::monitor`]).
//!
//! The [state](super::state), the record and the solution hold all that lasts between two pieces. So a solve can pause after any piece and
//! continue later with the same bits.

use crate::real::Real;
use crate::solver::central_path::Progress;
use crate::solver::newton::Outcome;
use crate::solver::phases::Phases;
use crate::solver::solve::Solve;
use crate::solver::state::{Newton, Origin, Phase, Sweeps};
use crate::solver::sweeps::Pace;
use crate::solver::warm_start::WarmStartKind;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize, P: Phases>
    Solve<'_, '_, T, N, D, C, R, S, P>
{
    /// Begins a solve at the last solution, or without impulses.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn begin(&mut self) {
        let kind = self.go_to_start();
        self.consider();
        self.state.phase = if self.monitor.must_return() { Phase::Start(kind) } else { self.start(kind) };
    }

    /// The first phase of a solve.
    #[cfg_attr(target_os = "none", inline(never))]
    fn start(&mut self, kind: WarmStartKind) -> Phase {
        if P::CENTRAL_PATH
            && let Some(phase) = self.ask_at_start()
        {
            return phase;
        }
        // The estimate was within the tolerance, but the error was not.
        let corrected = self.state.point.estimate <= self.monitor.tolerance() && !self.monitor.is_over();
        let newton = Newton::warm(kind == WarmStartKind::Isostatic);
        match kind {
            _ if !P::NEWTON => {
                self.apply_correction();
                self.begin_sweeps()
            }
            WarmStartKind::None if !corrected => self.begin_cold(true),
            WarmStartKind::Isostatic if !corrected && !self.state.holds_jacobian => self.begin_sweeps(),
            WarmStartKind::None | WarmStartKind::Isostatic => self.begin_newton(newton),
            WarmStartKind::Hyperstatic => {
                if corrected {
                    self.rebuild();
                }
                Phase::Newton(newton)
            }
        }
    }

    /// Does one piece of work, and chooses the next one.
    pub(super) fn advance(&mut self) {
        if self.monitor.must_return() {
            self.check();
            if self.monitor.is_check_due() {
                return;
            }
            if let Phase::Start(kind) = self.state.phase {
                self.state.phase = self.start(kind);
                return;
            }
            if !self.monitor.is_over() {
                self.state.phase = self.after_failed_check();
            }
        } else {
            self.state.phase = self.work();
        }
        if P::CENTRAL_PATH && !self.monitor.is_check_due() {
            self.ask_after_piece();
        }
    }

    /// The phase after a check that found the error above the tolerance. (The check may have corrected the velocities.)
    #[cfg_attr(target_os = "none", inline(never))]
    fn after_failed_check(&mut self) -> Phase {
        match self.state.phase {
            Phase::Sweeps => self.after_sweeps(),
            Phase::CentralPath if P::CENTRAL_PATH => {
                let progress = self.progress();
                self.after_path_step(progress)
            }
            Phase::Newton(newton) if P::NEWTON && newton.is_spent() => self.after_rejection(newton.origin),
            phase => phase,
        }
    }

    /// The phase after a step along the central path.
    fn after_path_step(&mut self, progress: Progress) -> Phase {
        match progress {
            Progress::Far => Phase::CentralPath,
            Progress::Near => Phase::Newton(Newton::finish()),
            Progress::Jammed => {
                if let Some(phase) = self.ask_after_failure(None) {
                    phase
                } else if self.leave_jam() {
                    Phase::Newton(Newton::finish())
                } else {
                    self.back_to_path();
                    Phase::CentralPath
                }
            }
        }
    }

    /// The phase after the last sweep.
    fn after_sweeps(&mut self) -> Phase {
        if P::NEWTON {
            self.end_sweeps();
            return self.begin_newton(Newton::after_sweeps());
        }
        self.apply_correction();
        Phase::Sweeps
    }

    /// Does one piece of work of the present phase, and returns the next phase.
    fn work(&mut self) -> Phase {
        match self.state.phase {
            Phase::Idle | Phase::Start(_) => Phase::Idle,
            Phase::Sweeps => match self.sweep() {
                Pace::Continue => Phase::Sweeps,
                Pace::Enough => self.after_sweeps(),
            },
            Phase::Newton(newton) if P::NEWTON => match self.step(newton) {
                Outcome::Accepted(newton) => Phase::Newton(newton),
                Outcome::NoJacobian => {
                    self.state.forget();
                    self.begin_sweeps()
                }
                Outcome::Rejected => self.after_rejection(newton.origin),
            },
            Phase::CentralPath if P::CENTRAL_PATH => {
                let progress = self.path_step();
                self.after_path_step(progress)
            }
            // Nothing begins a phase that is left out.
            Phase::Newton(_) | Phase::CentralPath => Phase::Sweeps,
        }
    }

    /// The phase after a rejected Newton step.
    fn after_rejection(&mut self, origin: Origin) -> Phase {
        if P::CENTRAL_PATH {
            if let Some(phase) = self.ask_after_failure(Some(origin)) {
                return phase;
            }
            if !matches!(origin, Origin::Path) {
                self.monitor.look_for_proof();
            }
        }
        match origin {
            Origin::Cold if P::CENTRAL_PATH => {
                self.go_to_best();
                if self.monitor.problem.can_be_swept() && self.monitor.solution.work.sweeps == 0 {
                    return self.begin_sweeps();
                }
                self.monitor.check_best();
                if self.monitor.is_over() {
                    return Phase::Sweeps; // the solve is over: of the point `r` and `u` are read
                }
                self.begin_path()
            }
            Origin::Path if P::CENTRAL_PATH => {
                self.back_to_path();
                Phase::CentralPath
            }
            Origin::Cold | Origin::Path => {
                self.sweep_for_longer();
                Phase::Sweeps
            }
            Origin::LastSolution | Origin::Guess => {
                if self.monitor.problem.can_be_swept() {
                    self.go_to_best();
                    return self.begin_sweeps();
                }
                self.set_zero_impulse();
                self.begin_newton(Newton::new())
            }
        }
    }

    /// Begins a cold start: at a guess, with sweeps, or with Newton's method from zero impulses.
    pub(super) fn begin_cold(&mut self, may_guess: bool) -> Phase {
        if may_guess && self.monitor.problem.is_likely_to_stick() {
            self.begin_guess(Newton::guessed())
        } else if self.monitor.problem.begins_with_sweeps() {
            self.begin_sweeps()
        } else {
            self.begin_newton(Newton::new())
        }
    }

    /// Begins Newton's method at the guess that all contacts stick.
    pub(super) fn begin_guess(&mut self, newton: Newton) -> Phase {
        self.monitor.problem.all_sticking(&mut self.state.point.z);
        self.evaluate_z();
        Phase::Newton(newton)
    }

    /// Begins sweeps at the impulses and `u` of the point.
    fn begin_sweeps(&mut self) -> Phase {
        self.state.sweeps = Sweeps::none();
        Phase::Sweeps
    }

    /// Begins Newton's method at the impulses and `u` of the point.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn begin_newton(&mut self, newton: Newton) -> Phase {
        self.rebuild_from_velocity();
        Phase::Newton(newton)
    }
}
