//! The state machine of a solve: sweeps or a guess, then Newton's method, then the central path if Newton's method fails.
//!
//! [`crate::guide::method`] explains the phases and has a table of all transitions. In short:
//!
//! ```text
//! Sweeps ── enough ──► Newton ── rejected ──► CentralPath ── jam ──► CentralPath (another one)
//! Newton ── rejected, began without sweeps, at the last solution or at a guess ──► Sweeps, from the best impulses
//! CentralPath ── near the end, also after a jam ──► Newton ── rejected ──► CentralPath, where it was
//! ```
//!
//! A phase does one piece of work (a sweep, a step), which leads to another phase or to a [`Failure`]. Before the method recovers from that,
//! others may end the solve or choose another phase: [`super::solve`] asks them.

use crate::real::Real;
use crate::solver::newton::Outcome;
use crate::solver::phases::Phases;
use crate::solver::solve::Solve;
use crate::solver::state::{Failure, Newton, Next, Origin, Phase, Sweeps};
use crate::solver::sweeps::Pace;
use crate::solver::warm_start::WarmStartKind;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize, P: Phases>
    Solve<'_, '_, T, N, D, C, R, S, P>
{
    /// Begins a solve at the last solution, or without impulses.
    pub(super) fn begin(&mut self) -> Phase {
        let kind = self.go_to_start();
        self.consider();
        Phase::Start(kind)
    }

    /// The phase after a piece of work or a check.
    pub(super) fn next_phase(&mut self, next: Next) -> Phase {
        match next {
            Ok(Phase::Start(kind)) => self.start(kind),
            Ok(phase) => phase,
            Err(failure) => self.recover(failure),
        }
    }

    /// The first phase of a solve.
    fn start(&mut self, kind: WarmStartKind) -> Phase {
        // The estimate was within the tolerance, but the error was not.
        let corrected = self.state.point.estimate <= self.monitor.tolerance();
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

    /// What follows a check. If it found the error above the tolerance, it may have corrected the velocities.
    pub(super) fn after_check(&mut self) -> Next {
        match self.state.phase {
            phase if self.monitor.must_return() => Ok(phase),
            Phase::Sweeps => Ok(self.after_sweeps()),
            Phase::CentralPath if P::CENTRAL_PATH => self.progress(),
            Phase::Newton(newton) if P::NEWTON && newton.is_spent() => Err(Failure::Rejected(newton.origin)),
            phase => Ok(phase),
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

    /// Does one piece of work of the present phase.
    pub(super) fn work(&mut self) -> Next {
        match self.state.phase {
            Phase::Sweeps => Ok(match self.sweep() {
                Pace::Continue => Phase::Sweeps,
                Pace::Enough => self.after_sweeps(),
            }),
            Phase::Newton(newton) if P::NEWTON => match self.step(newton) {
                Outcome::Accepted(newton) => Ok(Phase::Newton(newton)),
                Outcome::NoJacobian => {
                    self.state.forget();
                    Ok(self.begin_sweeps())
                }
                Outcome::Rejected => Err(Failure::Rejected(newton.origin)),
            },
            Phase::CentralPath if P::CENTRAL_PATH => self.path_step(),
            phase => Ok(phase), // the start; nothing begins a phase that is left out
        }
    }

    /// The phase after a failure.
    fn recover(&mut self, failure: Failure) -> Phase {
        let origin = match failure {
            Failure::Rejected(origin) => origin,
            Failure::Jammed if P::CENTRAL_PATH => return self.leave_jam(),
            Failure::Jammed => return Phase::Sweeps, // nothing begins a path that is left out
        };
        match origin {
            Origin::Cold if P::CENTRAL_PATH => {
                self.go_to_best();
                if self.monitor.problem.can_be_swept() && self.monitor.solution.work.sweeps == 0 {
                    return self.begin_sweeps();
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
    pub(super) fn begin_newton(&mut self, newton: Newton) -> Phase {
        self.rebuild_from_velocity();
        Phase::Newton(newton)
    }
}
