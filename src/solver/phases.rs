//! The method: sweep or guess; then Newton's method; if that fails, the interior point.
//!
//! The whole diagram and a table of the transitions stand in [`crate::guide::method`]; in short:
//!
//! ```text
//! Sweeps ── enough ──► Newton ── rejected ──► InteriorPoint ── jam ──► InteriorPoint (another path)
//! Newton ── rejected, began at the last solution or at a guess ──► cold start, without a guess
//! InteriorPoint ── near the end, also after a jam ──► Newton
//! Sweeps or Newton ── impulses too large, or rejected ──► search for a proof, once in a solve
//! ```
//!
//! A phase does one piece of work at a time and says what came of it. [`Solve::advance`] alone decides what is next. A last
//! solution whose impulses are nearly unique is swept too, if no Jacobian was kept. Only [`Solve`], the [`Workspace`] and
//! the monitor's record are carried from one piece to the next: a solve can pause after any of them and continue later with
//! the same bits.

use crate::Real;
use crate::laws::{Coulomb, Laws};
use crate::problem::Problem;
use crate::solver::interior_point::{InteriorPoint, Progress};
use crate::solver::monitor::Monitor;
use crate::solver::newton::{Newton, Outcome, Start};
use crate::solver::point::Point;
use crate::solver::sweeps::{Pace, Sweeps};
use crate::solver::warm_start::{Known, WarmStart};
use crate::solver::workspace::Workspace;
use nalgebra::SVector;

/// What comes next.
#[derive(Clone, Copy, Debug)]
#[repr(u8)] // so that `Idle` is zero, and a new solver takes no flash
pub(crate) enum Phase {
    /// Nothing: no solve was begun.
    Idle,
    /// A Gauss-Seidel sweep.
    Sweeps,
    /// A step of Newton's method.
    Newton(Newton),
    /// A step of the interior-point method.
    InteriorPoint,
}

/// The state of a solve by the default method.
#[derive(Clone, Debug)]
pub(crate) struct Solve<T: Real, const D: usize, const C: usize, L: Laws = Coulomb> {
    pub(super) phase: Phase,
    pub(super) point: Point<T, D, C>,
    pub(super) sweeps: Sweeps<T, C>,
    pub(super) interior: InteriorPoint<T, D, C, L>,
}

impl<T: Real, const D: usize, const C: usize, L: Laws> Solve<T, D, C, L> {
    /// No solve yet.
    pub(crate) const fn none() -> Self {
        Self {
            phase: Phase::Idle,
            point: Point::none(),
            sweeps: Sweeps::none(),
            interior: InteriorPoint::none(),
        }
    }

    /// Begins a solve at the last solution, or without impulses.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn begin<const N: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, L>,
        workspace: &mut Workspace<T, D, C, L>,
        warm_start: &mut WarmStart<T, D, C, L>,
    ) {
        if let Some(places) = warm_start.follow(monitor.problem.scene) {
            workspace.jacobian.follow(&places);
        }
        let tolerance = monitor.tolerance();
        let onwards = monitor.is_first_call();
        let known = warm_start.start(monitor.problem, (tolerance, onwards), &mut self.point);
        self.consider(monitor);
        // Good enough for contact space, but not once its velocity was known?
        let corrected = self.point.natural_map <= tolerance && !monitor.is_over();
        let newton = Newton::warm(known == Known::Isostatic);
        self.phase = match known {
            Known::Nothing if !corrected => self.begin_cold(monitor, true),
            Known::Isostatic if !corrected && !workspace.holds_jacobian() => self.begin_sweeps(),
            Known::Nothing | Known::Isostatic => self.begin_newton(monitor, newton),
            Known::Hyperstatic => {
                if corrected {
                    self.point.rebuild(monitor.problem);
                }
                Phase::Newton(newton)
            }
        };
    }

    /// One piece of work, and what comes after it.
    pub(crate) fn advance<const N: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, L>,
        workspace: &mut Workspace<T, D, C, L>,
    ) {
        self.phase = match self.phase {
            Phase::Idle => Phase::Idle,
            Phase::Sweeps => match self.sweep(monitor) {
                Pace::Continue => Phase::Sweeps,
                Pace::Enough => {
                    monitor.suspect(&self.point.r);
                    self.begin_newton(monitor, self.sweeps.then())
                }
            },
            Phase::Newton(newton) => match self.step(monitor, workspace, newton) {
                Outcome::Accepted(newton) => Phase::Newton(newton),
                Outcome::NoJacobian => {
                    workspace.forget();
                    self.begin_sweeps()
                }
                Outcome::Rejected => match newton.start() {
                    Start::Near => self.begin_interior(monitor),
                    Start::Interior => {
                        self.back_to_path(monitor);
                        Phase::InteriorPoint
                    }
                    Start::Last | Start::Guess => {
                        monitor.look_for_proof();
                        self.point.set_zero_impulse(monitor.problem);
                        self.begin_cold(monitor, false)
                    }
                },
            },
            Phase::InteriorPoint => match self.step_inside(monitor, workspace) {
                Progress::Far => Phase::InteriorPoint,
                Progress::Near => Phase::Newton(Newton::finish()),
                Progress::Jammed => {
                    if self.leave_jam(monitor) {
                        Phase::Newton(Newton::finish())
                    } else {
                        self.back_to_path(monitor);
                        Phase::InteriorPoint
                    }
                }
            },
        };
    }

    /// A cold start: a guess, sweeps, or Newton's method from rest.
    fn begin_cold<const N: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, L>,
        may_guess: bool,
    ) -> Phase {
        if may_guess && monitor.problem.is_likely_to_stick() {
            monitor.problem.all_sticking(&mut self.point.z);
            self.point.update(monitor.problem);
            Phase::Newton(Newton::guessed())
        } else if monitor.problem.begins_with_sweeps() {
            self.begin_sweeps()
        } else {
            self.begin_newton(monitor, Newton::new())
        }
    }

    /// Newton's method from the impulses and `u` of the point.
    #[cfg_attr(target_os = "none", inline(never))]
    fn begin_newton<const N: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, L>,
        newton: Newton,
    ) -> Phase {
        self.point.rebuild_from_velocity(monitor.problem);
        Phase::Newton(newton)
    }

    /// Shows the point to the monitor.
    pub(super) fn consider<const N: usize>(&self, monitor: &mut Monitor<'_, '_, T, N, D, C, L>) {
        let Point {
            r, u, natural_map, ..
        } = &self.point;
        monitor.consider(r, u, *natural_map);
    }

    /// `ũ` and `r` of each contact as they stand.
    pub(crate) fn contacts<const N: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C, L>,
    ) -> impl Iterator<Item = (SVector<T, D>, SVector<T, D>)> {
        let point = &self.point;
        let points = point.p.iter().zip(&point.r).zip(&point.u);
        let contacts = points.zip(problem.laws());
        contacts.map(|(((&p, &r), &u), law)| match self.phase {
            Phase::Sweeps | Phase::InteriorPoint => (law.augmented(&u.into()), r.into()),
            _ => (p, r.into()),
        })
    }
}
