//! The method: sweep or guess; then Newton's method; if that fails, the central path.
//!
//! The whole diagram and a table of the transitions stand in [`crate::guide::method`]; in short:
//!
//! ```text
//! Sweeps ── enough ──► Newton ── rejected ──► Sweeps ── slow ──► CentralPath ── jam ──► CentralPath (another one)
//! Newton ── rejected, began at the last solution or at a guess ──► cold start, without a guess
//! CentralPath ── near the end, also after a jam ──► Newton
//! Newton ── rejected ──► search for a proof, once in a solve
//! solved, but a rest is left ──► CentralPath of the relaxation: can all stay?
//! ```
//!
//! A phase does one piece of work at a time and says what came of it. [`Method::advance`] alone decides what is next. Where a point is good
//! enough in contact space, its error is asked for, and answered before the next piece. A last
//! solution whose impulses are nearly unique is swept too, if no Jacobian was kept. Only [`Method`], the
//! monitor's record and the solution (its work, the impulses shown) are carried from one piece to the next: a solve can pause after
//! any of them and continue later with the same bits.

use crate::linalg::stacked::Stacked;
use crate::problem::Problem;
use crate::real::Real;
use crate::solver::central_path::Progress;
use crate::solver::monitor::Monitor;
use crate::solver::newton::{Newton, Origin, Outcome};
use crate::solver::phases::Phases;
use crate::solver::point::NewtonPoint;
use crate::solver::record::{Question, Rest};
use crate::solver::rest::DISTURBED;
use crate::solver::state::State;
use crate::solver::sweeps::Pace;
use crate::solver::warm_start::{WarmStart, WarmStartKind};

/// What comes next.
#[derive(Clone, Copy, Debug)]
#[repr(u8)] // so that `Idle` is zero, and a new solver takes no flash
pub(crate) enum Phase {
    /// Nothing: no solve was begun.
    Idle,
    /// The start, once it is known how good the last solution is.
    Start(WarmStartKind),
    /// A Gauss-Seidel sweep.
    Sweeps,
    /// A step of Newton's method.
    Newton(Newton),
    /// A step along the central path.
    CentralPath,
}

/// The state of a solve, and what comes next.
#[derive(Clone, Debug)]
pub(crate) struct Method<T: Real, const D: usize, const C: usize, const R: usize, P> {
    pub(super) phase: Phase,
    pub(super) state: State<T, D, C, R>,
    phases: P,
}

impl<T: Real, const D: usize, const C: usize, const R: usize, P: Phases> Method<T, D, C, R, P> {
    /// No solve yet.
    pub(crate) const fn none(phases: P) -> Self {
        Self {
            phase: Phase::Idle,
            state: State::none(),
            phases,
        }
    }

    /// Forgets the Jacobian that is kept.
    pub(crate) fn forget(&mut self) {
        self.state.forget();
    }

    /// The impulses as they stand.
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
        if let Some(places) = warm_start.follow(monitor.problem.scene) {
            self.state.jacobian.follow(&places);
        }
        let start = (monitor.tolerance(), monitor.is_first_call());
        let (problem, point) = (&*monitor.problem, &mut self.state.point);
        let known = warm_start.start(problem, start, self.phases, point);
        self.state.consider(monitor);
        self.phase = if monitor.waits() {
            Phase::Start(known)
        } else {
            self.start(monitor, warm_start, known)
        };
    }

    /// Where a solve begins.
    #[cfg_attr(target_os = "none", inline(never))]
    fn start<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
        warm_start: &mut WarmStart<T, D, C, R>,
        known: WarmStartKind,
    ) -> Phase {
        let tolerance = monitor.tolerance();
        if P::CENTRAL_PATH
            && monitor.problem.may_be_redundant()
            && (!monitor.is_over() || warm_start.has_crept(monitor.creeps(&self.state.point)))
            && warm_start.is_at_rest(monitor.problem, tolerance)
        {
            monitor.record.rest = Rest::Before;
            if monitor.leaves_rest(&self.state.point) {
                return self.begin_path(monitor);
            }
            warm_start.is_disturbed |= self.state.point.estimate > T::literal(DISTURBED);
        }
        if P::CENTRAL_PATH && warm_start.is_disturbed && monitor.is_over() {
            warm_start.is_disturbed = false;
            if monitor.problem.is_likely_to_stick()
                && warm_start.is_at_rest(monitor.problem, tolerance)
            {
                monitor.ask_for_centre();
                return self.begin_guess(monitor, Newton::centring());
            }
        }
        // Good enough for contact space, but not once its velocity was known?
        let corrected = self.state.point.estimate <= tolerance && !monitor.is_over();
        let newton = Newton::warm(known == WarmStartKind::Isostatic);
        match known {
            _ if !P::NEWTON => {
                self.state.go_on_sweeping(monitor);
                self.begin_sweeps(monitor)
            }
            WarmStartKind::None if !corrected => self.begin_cold(monitor, true),
            WarmStartKind::Isostatic if !corrected && !self.state.holds_jacobian => {
                self.begin_sweeps(monitor)
            }
            WarmStartKind::None | WarmStartKind::Isostatic => self.begin_newton(monitor, newton),
            WarmStartKind::Hyperstatic => {
                if corrected {
                    self.state.point.rebuild(monitor.problem);
                }
                Phase::Newton(newton)
            }
        }
    }

    /// One piece of work, and what comes after it.
    pub(crate) fn advance<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
        warm_start: &mut WarmStart<T, D, C, R>,
    ) {
        if monitor.waits() {
            self.state.judge(monitor);
            if monitor.record.question != Question::Nothing {
                return;
            }
            if let Phase::Start(known) = self.phase {
                self.phase = self.start(monitor, warm_start, known);
                return;
            }
            if !monitor.is_over() {
                self.phase = self.after_correction(monitor);
            }
        } else {
            self.phase = self.work(monitor);
        }
        let waits = monitor.record.question != Question::Nothing;
        if P::CENTRAL_PATH && monitor.record.rest != Rest::Known && !waits {
            self.keep_rest(monitor);
        }
    }

    /// What comes after a point that was not good enough, of which the velocities may have been corrected.
    #[cfg_attr(target_os = "none", inline(never))]
    fn after_correction<const N: usize, const S: usize>(
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
                self.after_rejection(monitor, newton.origin())
            }
            phase => phase,
        }
    }

    /// What comes after a step along the central path.
    fn after_path_step<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
        progress: Progress,
    ) -> Phase {
        match progress {
            Progress::Far => Phase::CentralPath,
            Progress::Near => Phase::Newton(Newton::finish()),
            Progress::Jammed if monitor.record.asks_for_rest() => self.after_question(monitor),
            Progress::Jammed => {
                if self.state.leave_jam(monitor) {
                    Phase::Newton(Newton::finish())
                } else {
                    self.state.back_to_path(monitor);
                    Phase::CentralPath
                }
            }
        }
    }

    /// What comes after sweeps that were enough.
    fn after_sweeps<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) -> Phase {
        if P::CENTRAL_PATH && self.state.sweeps.lead_to_path {
            return self.begin_path(monitor);
        }
        if P::NEWTON {
            return self.begin_newton(monitor, self.state.newton_after_sweeps());
        }
        self.state.go_on_sweeping(monitor);
        Phase::Sweeps
    }

    /// The next piece of the phase, and what comes after it.
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
                    self.begin_sweeps(monitor)
                }
                Outcome::Rejected => self.after_rejection(monitor, newton.origin()),
            },
            Phase::CentralPath if P::CENTRAL_PATH => {
                let progress = self.state.path_step(monitor);
                self.after_path_step(monitor, progress)
            }
            // A phase that is left out is not begun.
            Phase::Newton(_) | Phase::CentralPath => Phase::Sweeps,
        }
    }

    /// Asks whether all can stay at rest if a solution was found that slides, and ends that question once it is answered.
    #[cfg_attr(target_os = "none", inline(never))]
    fn keep_rest<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) {
        if monitor.leaves_rest(&self.state.point) {
            self.phase = self.begin_path(monitor);
        } else if monitor.record.asks_for_rest() && monitor.cannot_rest(&self.state.point) {
            self.phase = self.after_question(monitor);
        }
    }

    /// Not all can stay, or nobody knows: what slides is the solution, or is looked for.
    #[cfg_attr(target_os = "none", inline(never))]
    fn after_question<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) -> Phase {
        if let Some(known) = monitor.give_up_rest() {
            let point = &mut self.state.point;
            point.r = known; // where the next solve starts
            point.estimate = monitor
                .problem
                .velocities_and_estimate(&point.r, &mut point.u);
            point.rebuild_from_velocity(monitor.problem);
            return Phase::Idle;
        }
        monitor.look_for_proof();
        self.state.point.set_zero_impulse(monitor.problem);
        self.begin_cold(monitor, false)
    }

    /// If a call ends while it is asked whether all can stay, the solution that slides is the answer. What is written obeys Coulomb's law.
    pub(crate) fn end_question<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) {
        if monitor.record.knows_answer() && !monitor.is_over() {
            self.phase = self.after_question(monitor);
        } else if monitor.record.asks_for_rest() {
            monitor.problem.set_shift(true);
        }
    }

    /// What comes after a Newton step that was rejected.
    fn after_rejection<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
        origin: Origin,
    ) -> Phase {
        match origin {
            _ if P::CENTRAL_PATH && monitor.record.rest == Rest::Centred => {
                self.after_question(monitor)
            }
            Origin::Cold if P::CENTRAL_PATH => {
                monitor.look_for_proof();
                if monitor.problem.can_be_swept() && !monitor.record.asks_for_rest() {
                    self.state.sweep_before_path();
                    return Phase::Sweeps;
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
            Origin::Last if P::CENTRAL_PATH && monitor.record.rest == Rest::Before => {
                monitor.ask_for_rest(false);
                self.begin_newton(monitor, Newton::new())
            }
            Origin::Last | Origin::Guess => {
                if P::CENTRAL_PATH {
                    monitor.look_for_proof();
                }
                self.state.point.set_zero_impulse(monitor.problem);
                self.begin_cold(monitor, false)
            }
        }
    }

    /// A cold start: a guess, sweeps, or Newton's method from rest.
    fn begin_cold<const N: usize, const S: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
        may_guess: bool,
    ) -> Phase {
        if may_guess && monitor.problem.is_likely_to_stick() {
            self.begin_guess(monitor, Newton::guessed())
        } else if monitor.problem.begins_with_sweeps() {
            self.begin_sweeps(monitor)
        } else {
            self.begin_newton(monitor, Newton::new())
        }
    }

    /// Newton's method from the guess that all contacts stick.
    fn begin_guess<const N: usize, const S: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
        newton: Newton,
    ) -> Phase {
        monitor.problem.all_sticking(&mut self.state.point.z);
        self.state.point.update(monitor.problem);
        Phase::Newton(newton)
    }

    /// Sweeps from the impulses and `u` of the point.
    fn begin_sweeps<const N: usize, const S: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
    ) -> Phase {
        self.state.begin_sweeps(monitor);
        Phase::Sweeps
    }

    /// The central path from the impulses of the point.
    fn begin_path<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) -> Phase {
        self.state.begin_path(monitor);
        Phase::CentralPath
    }

    /// Newton's method from the impulses and `u` of the point.
    #[cfg_attr(target_os = "none", inline(never))]
    fn begin_newton<const N: usize, const S: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
        newton: Newton,
    ) -> Phase {
        self.state.point.rebuild_from_velocity(monitor.problem);
        Phase::Newton(newton)
    }

    /// `P` and `r` as they stand. (After a sweep and after a step along the central path only `u` is current: `P` follows from it.)
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
