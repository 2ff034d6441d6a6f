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
//! A phase does one piece of work (a sweep, a step) and returns its outcome. [`Method::advance`] alone chooses the next phase. If the
//! estimate of a point is within the tolerance, the monitor checks its error before the next piece ([`crate::solver::monitor`]).
//!
//! [`Method`], the record and the solution hold all state between two pieces. So a solve can pause after any piece and continue later with
//! the same bits.

use crate::linalg::stacked::Stacked;
use crate::problem::Problem;
use crate::real::Real;
use crate::solver::central_path::Progress;
use crate::solver::monitor::Monitor;
use crate::solver::newton::{Newton, Origin, Outcome};
use crate::solver::phases::Phases;
use crate::solver::point::NewtonPoint;
use crate::solver::state::{State, Sweeps};
use crate::solver::sweeps::Pace;
use crate::solver::warm_start::{WarmStart, WarmStartKind};

/// The next piece of work.
#[derive(Clone, Copy, Debug)]
#[repr(u8)] // so that `Idle` is zero, and a new solver takes no flash
pub(crate) enum Phase {
    /// No work: no solve was begun, or the solve is over.
    Idle,
    /// The choice of the first phase, once the error of the start is checked.
    Start(WarmStartKind),
    /// A Gauss-Seidel sweep.
    Sweeps,
    /// A step of Newton's method.
    Newton(Newton),
    /// A step along the central path.
    CentralPath,
}

/// The state of a solve, and its next piece of work.
#[derive(Clone, Debug)]
pub(crate) struct Method<T: Real, const D: usize, const C: usize, const R: usize, P> {
    pub(super) phase: Phase,
    pub(super) state: State<T, D, C, R>,
    phases: P,
}

impl<T: Real, const D: usize, const C: usize, const R: usize, P: Phases> Method<T, D, C, R, P> {
    /// The state before any solve.
    pub(crate) const fn none(phases: P) -> Self {
        Self { phase: Phase::Idle, state: State::none(), phases }
    }

    /// Forgets the kept Jacobian.
    pub(crate) fn forget(&mut self) {
        self.state.forget();
    }

    /// The present impulses.
    pub(crate) const fn impulses(&self) -> &Stacked<T, D, C, R> {
        &self.state.point.r
    }

    /// Begins a solve at the last solution, or without impulses.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn begin<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
        warm_start: &mut WarmStart<T, D, C, R>,
    ) {
        if let Some(earlier_indices) = warm_start.follow(monitor.problem.scene) {
            self.state.jacobian.follow(&earlier_indices);
        }
        let start = (monitor.tolerance(), monitor.is_first_call());
        let (problem, point) = (&*monitor.problem, &mut self.state.point);
        let kind = warm_start.start(problem, start, self.phases, point);
        monitor.consider(&self.state.point.r, &self.state.point.u, self.state.point.estimate);
        self.phase =
            if monitor.must_return() { Phase::Start(kind) } else { self.start(monitor, warm_start, kind) };
    }

    /// The first phase of a solve.
    #[cfg_attr(target_os = "none", inline(never))]
    fn start<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
        warm_start: &mut WarmStart<T, D, C, R>,
        kind: WarmStartKind,
    ) -> Phase {
        if P::CENTRAL_PATH
            && let Some(phase) = self.ask_at_start(monitor, warm_start)
        {
            return phase;
        }
        // The estimate was within the tolerance, but the error was not.
        let corrected = self.state.point.estimate <= monitor.tolerance() && !monitor.is_over();
        let newton = Newton::warm(kind == WarmStartKind::Isostatic);
        match kind {
            _ if !P::NEWTON => {
                self.state.apply_correction(monitor);
                self.begin_sweeps()
            }
            WarmStartKind::None if !corrected => self.begin_cold(monitor, true),
            WarmStartKind::Isostatic if !corrected && !self.state.holds_jacobian => self.begin_sweeps(),
            WarmStartKind::None | WarmStartKind::Isostatic => self.begin_newton(monitor, newton),
            WarmStartKind::Hyperstatic => {
                if corrected {
                    self.state.point.rebuild(monitor.problem);
                }
                Phase::Newton(newton)
            }
        }
    }

    /// Does one piece of work, and chooses the next one.
    pub(crate) fn advance<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
        warm_start: &mut WarmStart<T, D, C, R>,
    ) {
        if monitor.must_return() {
            self.state.check::<P, N, S>(monitor);
            if monitor.is_check_due() {
                return;
            }
            if let Phase::Start(kind) = self.phase {
                self.phase = self.start(monitor, warm_start, kind);
                return;
            }
            if !monitor.is_over() {
                self.phase = self.after_failed_check(monitor);
            }
        } else {
            self.phase = self.work(monitor);
        }
        if P::CENTRAL_PATH && !monitor.is_check_due() {
            self.ask_after_piece(monitor);
        }
    }

    /// The phase after a check that found the error above the tolerance. (The check may have corrected the velocities.)
    #[cfg_attr(target_os = "none", inline(never))]
    fn after_failed_check<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) -> Phase {
        match self.phase {
            Phase::Sweeps => self.after_sweeps(monitor),
            Phase::CentralPath if P::CENTRAL_PATH => {
                let progress = self.state.progress(monitor);
                self.after_path_step(monitor, progress)
            }
            Phase::Newton(newton) if P::NEWTON && newton.is_spent() => {
                self.after_rejection(monitor, newton.origin)
            }
            phase => phase,
        }
    }

    /// The phase after a step along the central path.
    fn after_path_step<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
        progress: Progress,
    ) -> Phase {
        match progress {
            Progress::Far => Phase::CentralPath,
            Progress::Near => Phase::Newton(Newton::finish()),
            Progress::Jammed => {
                if let Some(phase) = self.ask_after_failure(monitor, None) {
                    phase
                } else if self.state.leave_jam(monitor) {
                    Phase::Newton(Newton::finish())
                } else {
                    self.state.back_to_path(monitor);
                    Phase::CentralPath
                }
            }
        }
    }

    /// The phase after the last sweep.
    fn after_sweeps<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) -> Phase {
        if P::NEWTON {
            self.state.end_sweeps(monitor);
            return self.begin_newton(monitor, Newton::after_sweeps());
        }
        self.state.apply_correction(monitor);
        Phase::Sweeps
    }

    /// Does one piece of work of the present phase, and returns the next phase.
    fn work<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) -> Phase {
        match self.phase {
            Phase::Idle | Phase::Start(_) => Phase::Idle,
            Phase::Sweeps => match self.state.sweep(monitor) {
                Pace::Continue => Phase::Sweeps,
                Pace::Enough => self.after_sweeps(monitor),
            },
            Phase::Newton(newton) if P::NEWTON => match self.state.step(monitor, newton) {
                Outcome::Accepted(newton) => Phase::Newton(newton),
                Outcome::NoJacobian => {
                    self.forget();
                    self.begin_sweeps()
                }
                Outcome::Rejected => self.after_rejection(monitor, newton.origin),
            },
            Phase::CentralPath if P::CENTRAL_PATH => {
                let progress = self.state.path_step(monitor);
                self.after_path_step(monitor, progress)
            }
            // Nothing begins a phase that is left out.
            Phase::Newton(_) | Phase::CentralPath => Phase::Sweeps,
        }
    }

    /// The phase after a rejected Newton step.
    fn after_rejection<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
        origin: Origin,
    ) -> Phase {
        if P::CENTRAL_PATH {
            if let Some(phase) = self.ask_after_failure(monitor, Some(origin)) {
                return phase;
            }
            if !matches!(origin, Origin::Path) {
                monitor.look_for_proof();
            }
        }
        match origin {
            Origin::Cold if P::CENTRAL_PATH => {
                self.state.go_to_best(monitor);
                if monitor.problem.can_be_swept() && monitor.solution.work.sweeps == 0 {
                    return self.begin_sweeps();
                }
                monitor.check_best();
                if monitor.is_over() {
                    return Phase::Sweeps; // the solve is over: of the point `r` and `u` are read
                }
                self.begin_path(monitor)
            }
            Origin::Path if P::CENTRAL_PATH => {
                self.state.back_to_path(monitor);
                Phase::CentralPath
            }
            Origin::Cold | Origin::Path => {
                self.state.sweep_for_longer();
                Phase::Sweeps
            }
            Origin::LastSolution | Origin::Guess => {
                if monitor.problem.can_be_swept() {
                    self.state.go_to_best(monitor);
                    return self.begin_sweeps();
                }
                self.state.point.set_zero_impulse(monitor.problem);
                self.begin_newton(monitor, Newton::new())
            }
        }
    }

    /// Begins a cold start: at a guess, with sweeps, or with Newton's method from zero impulses.
    pub(super) fn begin_cold<const N: usize, const S: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
        may_guess: bool,
    ) -> Phase {
        if may_guess && monitor.problem.is_likely_to_stick() {
            self.begin_guess(monitor, Newton::guessed())
        } else if monitor.problem.begins_with_sweeps() {
            self.begin_sweeps()
        } else {
            self.begin_newton(monitor, Newton::new())
        }
    }

    /// Begins Newton's method at the guess that all contacts stick.
    pub(super) fn begin_guess<const N: usize, const S: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
        newton: Newton,
    ) -> Phase {
        monitor.problem.all_sticking(&mut self.state.point.z);
        self.state.point.update(monitor.problem);
        Phase::Newton(newton)
    }

    /// Begins sweeps at the impulses and `u` of the point.
    fn begin_sweeps(&mut self) -> Phase {
        self.state.sweeps = Sweeps::none();
        Phase::Sweeps
    }

    /// Begins the central path near the impulses of the point.
    pub(super) fn begin_path<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) -> Phase {
        self.state.begin_path(monitor);
        Phase::CentralPath
    }

    /// Begins Newton's method at the impulses and `u` of the point.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn begin_newton<const N: usize, const S: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
        newton: Newton,
    ) -> Phase {
        self.state.point.rebuild_from_velocity(monitor.problem);
        Phase::Newton(newton)
    }

    /// The present `P` and `r`. (A sweep and a step along the central path update only `r` and `u`: `P` is then computed from `u`.)
    pub(crate) fn solution<const N: usize, const S: usize>(
        &mut self,
        problem: &Problem<'_, T, N, D, C, R, S>,
    ) -> [&Stacked<T, D, C, R>; 2] {
        let NewtonPoint { p, r, u, .. } = &mut self.state.point;
        match self.phase {
            Phase::Start(WarmStartKind::Hyperstatic) | Phase::Newton(_) | Phase::Idle => {}
            Phase::Start(_) | Phase::Sweeps | Phase::CentralPath => problem.sets.augment(u, p),
        }
        [p, r]
    }
}
