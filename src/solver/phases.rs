//! The method: sweep; where sweeps crawl, Algorithm 2; then Newton's method; where that fails, the fallback.
//!
//! ```text
//! begin ─┬─ last solution, or all contacts sticking ──────────► Newton ◄─────────┐
//!        ├─ impulses nearly unique ──► Sweeps ── near the end ──►   │            │
//!        │                               └─ slow ──► Admm ──────────┤            │
//!        └─ impulses not unique ───────────────────► Admm ──────► Newton         │
//!                                                                   │ rejected   │
//!        cold start ◄── it began at the last solution or a guess ◄──┤            │
//!                                                                   └─► Fallback ┘ (by way of Sweeps or Admm)
//! ```
//!
//! A phase does one piece of work at a time and says what came of it; what is next is decided in [`Solve::advance`], and
//! nowhere else. A last solution whose impulses are nearly unique is swept too, if no Jacobian was kept. Nothing but
//! [`Solve`], the [`Workspace`] and the monitor's record is carried from one piece to the next: a solve can stop after any
//! of them and go on later with the same bits.

use crate::admm::{Iterate, Restart};
use crate::linalg::hints::rolled;
use crate::solver::damping::Damping;
use crate::solver::fallback::{Fallback, Way};
use crate::solver::interior_point::InteriorPoint;
use crate::solver::monitor::Monitor;
use crate::solver::newton::{Newton, Outcome, Start};
use crate::solver::outlook::Outlook;
use crate::solver::penalty::Penalty;
use crate::solver::point::Point;
use crate::solver::sweeps::{Pace, Sweeps};
use crate::solver::warm_start::{Known, WarmStart};
use crate::solver::workspace::Workspace;
use crate::{Factor, Real};
use nalgebra::SVector;

/// What comes next.
#[derive(Clone, Copy, Debug)]
#[repr(u8)] // so that `Idle` is zero, and a new solver takes no flash
pub(crate) enum Phase {
    /// Nothing: no solve was begun.
    Idle,
    /// So many more iterations of Algorithm 2.
    Admm { left: usize },
    /// A Gauss-Seidel sweep.
    Sweeps,
    /// A step of Newton's method.
    Newton(Newton),
    /// What follows a rejected Newton step: a step along the central path.
    InteriorPoint,
    /// What followed.
    Fallback,
}

/// The state of a solve by the default method.
#[derive(Clone, Debug)]
pub(crate) struct Solve<T, const D: usize, const C: usize> {
    pub(super) phase: Phase,
    pub(super) point: Point<T, D, C>,
    pub(super) sweeps: Sweeps<T, C>,
    pub(super) iterates: [Iterate<T, D>; C],
    pub(super) acceleration: Restart<T>,
    pub(super) damping: Damping<T>,
    pub(super) penalty: Penalty<T>,
    pub(super) fallback: Fallback<T, D, C>,
    pub(super) path: InteriorPoint<T, D, C>,
}

impl<T: Real, const D: usize, const C: usize> Solve<T, D, C> {
    /// No solve yet.
    pub(crate) const fn none() -> Self {
        Self {
            phase: Phase::Idle,
            point: Point::none(),
            sweeps: Sweeps::none(),
            iterates: [const { Iterate::none() }; C],
            acceleration: Restart::none(),
            damping: Damping::none(),
            penalty: Penalty::none(),
            fallback: Fallback::none(),
            path: InteriorPoint::none(),
        }
    }

    /// Begins a solve at the last solution, or without impulses.
    pub(crate) fn begin<const N: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        workspace: &mut Workspace<T, D, C>,
        warm_start: &mut WarmStart<T, D, C>,
    ) {
        let can_be_swept = monitor.problem.can_be_swept();
        self.penalty = Penalty::new();
        self.damping = Damping::new();
        self.fallback.begin(can_be_swept);
        workspace.begin();
        if let Some(places) = warm_start.follow(monitor.problem.scene.contacts()) {
            workspace.jacobian.follow(&places);
        }
        let (scale, tolerance) = (self.penalty.scale, monitor.tolerance());
        let known = warm_start.start(monitor.problem, scale, tolerance, &mut self.point);
        self.consider(monitor);
        // Good enough for contact space, but not once its velocity was known?
        let corrected = self.point.natural_map <= tolerance && !monitor.is_over();
        let newton = Newton::warm(known == Known::Isostatic);
        self.phase = match known {
            Known::Nothing if !corrected => self.begin_cold(monitor, factor, workspace, true),
            Known::Isostatic if !corrected && !workspace.holds_jacobian() => self.begin_sweeps(),
            Known::Nothing | Known::Isostatic => self.begin_newton(monitor, newton),
            Known::Hyperstatic => {
                self.damping = Damping::warm();
                if corrected {
                    self.point.rebuild(monitor.problem, scale);
                }
                Phase::Newton(newton)
            }
        };
    }

    /// One piece of work, and what comes after it.
    pub(crate) fn advance<const N: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        workspace: &mut Workspace<T, D, C>,
    ) {
        self.phase = match self.phase {
            Phase::Idle => Phase::Idle,
            Phase::Sweeps => match self.sweep(monitor) {
                Pace::Continue => Phase::Sweeps,
                Pace::Enough => self.begin_newton(monitor, self.sweeps.then()),
                Pace::Slow => {
                    self.point.set_zero_impulse(monitor.problem);
                    self.begin_admm(factor, workspace)
                }
                Pace::Better => {
                    self.fallback.saved = None;
                    self.begin_newton(monitor, Newton::new())
                }
                Pace::NoBetter => self.leave_side_branch(monitor),
            },
            Phase::Admm { left } => {
                if !self.iterate(monitor, factor, workspace) {
                    // Masses are spread too wide for one penalty.
                    self.begin_newton(monitor, Newton::new())
                } else if left > 1 || monitor.is_over() {
                    Phase::Admm {
                        left: left.saturating_sub(1),
                    }
                } else {
                    self.take_iterates(monitor);
                    Phase::Newton(Newton::new())
                }
            }
            Phase::Newton(newton) => match self.step(monitor, workspace, newton) {
                Outcome::Accepted(newton) => Phase::Newton(newton),
                Outcome::NoJacobian => {
                    workspace.forget();
                    self.begin_sweeps()
                }
                Outcome::Rejected => match newton.start() {
                    Start::Near => self.begin_interior(monitor),
                    Start::Interior => {
                        self.place(monitor);
                        Phase::InteriorPoint
                    }
                    Start::Last | Start::Guess => {
                        self.damping = Damping::new();
                        self.point.set_zero_impulse(monitor.problem);
                        self.begin_cold(monitor, factor, workspace, false)
                    }
                },
            },
            Phase::InteriorPoint => self.follow_path(monitor, workspace),
            Phase::Fallback => match self.fall_back(monitor, factor, workspace) {
                Way::Sweeps => self.begin_side_branch(monitor),
                Way::Admm => self.begin_admm(factor, workspace),
            },
        };
    }

    /// A cold start, by what is to be expected of the impulses.
    fn begin_cold<const N: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        workspace: &mut Workspace<T, D, C>,
        may_guess: bool,
    ) -> Phase {
        match monitor.problem.outlook() {
            Outlook::Isostatic if monitor.problem.can_be_swept() => {
                self.fallback.has_swept = true;
                self.begin_sweeps()
            }
            Outlook::Sticking if may_guess => {
                monitor.problem.all_sticking(&mut self.point.z);
                self.point.update(monitor.problem, self.penalty.scale);
                Phase::Newton(Newton::guessed())
            }
            _ => self.begin_admm(factor, workspace),
        }
    }

    /// Newton's method from the impulses and `u` of the point.
    #[cfg_attr(target_os = "none", inline(never))]
    fn begin_newton<const N: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C>,
        newton: Newton,
    ) -> Phase {
        self.set_p(monitor);
        self.point.rebuild(monitor.problem, self.penalty.scale);
        Phase::Newton(newton)
    }

    /// Takes `û` for `P`.
    pub(super) fn set_p<const N: usize>(&mut self, monitor: &Monitor<'_, '_, T, N, D, C>) {
        let Point { u, p, .. } = &mut self.point;
        monitor.problem.augmented_velocity(u, p);
    }

    /// Shows the point to the monitor.
    pub(super) fn consider<const N: usize>(&self, monitor: &mut Monitor<'_, '_, T, N, D, C>) {
        let Point {
            r, u, natural_map, ..
        } = &self.point;
        monitor.consider(r, u, *natural_map);
    }

    /// Is there no solve to go on with?
    pub(crate) fn is_idle(&self) -> bool {
        matches!(self.phase, Phase::Idle)
    }

    /// Leaves the solve.
    pub(crate) fn stop(&mut self) {
        self.phase = Phase::Idle;
    }

    /// `ũ` and `r` of each contact as they stand.
    pub(crate) fn contacts(&self) -> impl Iterator<Item = (SVector<T, D>, SVector<T, D>)> {
        let point = &self.point;
        let points = point.p.iter().zip(&point.r);
        let contacts = points.zip(&point.u).zip(&self.iterates);
        contacts.map(|(((&p, &r), &u), iterate)| match self.phase {
            Phase::Admm { .. } => (iterate.u, iterate.impulse()),
            Phase::Sweeps | Phase::InteriorPoint => (u.into(), r.into()),
            _ => (p, r.into()),
        })
    }

    /// Ends a call.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn finish<const N: usize>(&self, monitor: &mut Monitor<'_, '_, T, N, D, C>) {
        let mut present = [[T::ZERO; D]; C];
        for (present, (_, r)) in present.iter_mut().zip(self.contacts()) {
            rolled();
            *present = r.into();
        }
        monitor.finish(&present);
        monitor.doubt();
    }
}
