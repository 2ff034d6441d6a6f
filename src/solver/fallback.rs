//! What follows a rejected Newton step: sweeps without impulses if there have been none, and then ADMM with penalties that
//! its residuals balance, of other sizes, and now and then from elsewhere.

use crate::Real;
use crate::linalg::blocks::ContactVector;
use crate::solver::monitor::Monitor;
use crate::solver::phases::{Phase, Solve};
use crate::solver::sweeps::Sweeps;
use crate::solver::tuning;
use crate::solver::workspace::Workspace;
use nalgebra::SVector;

/// What has been tried.
#[derive(Clone, Debug)]
pub(crate) struct Fallback<T, const D: usize, const C: usize> {
    /// Iterations of the next ADMM phase.
    pub(super) iterations: usize,
    /// Have sweeps without impulses been tried, or are they of no use?
    pub(super) has_swept: bool,
    /// Has ADMM been tried?
    has_iterated: bool,
    /// `P` and `r` that a side branch was left for.
    pub(super) saved: Option<([SVector<T, D>; C], ContactVector<T, D, C>)>,
    /// The impulses of the last side branch, from which the next one goes on.
    last_sweeps: ContactVector<T, D, C>,
}

/// How to go on.
pub(crate) enum Way {
    Sweeps,
    Admm,
}

impl<T: Real, const D: usize, const C: usize> Fallback<T, D, C> {
    /// No solve yet.
    pub(crate) const fn none() -> Self {
        Self {
            iterations: 0,
            has_swept: false,
            has_iterated: false,
            saved: None,
            last_sweeps: [[T::ZERO; D]; C],
        }
    }

    /// Nothing tried yet; in place, for a copy would take time and stack.
    pub(crate) fn begin(&mut self, can_be_swept: bool) {
        self.iterations = tuning::first_iterations();
        self.has_swept = !can_be_swept;
        self.has_iterated = false;
        self.saved = None;
        self.last_sweeps = [[T::ZERO; D]; C];
    }
}

impl<T: Real, const D: usize, const C: usize> Solve<T, D, C> {
    /// Another attempt: prepares it, and says which.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn fall_back<const N: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C>,
        workspace: &mut Workspace<T, D, C>,
    ) -> Way {
        if !self.fallback.has_iterated && !self.fallback.has_swept {
            self.fallback.has_swept = true;
            return Way::Sweeps;
        }
        let restarted = self.fallback.has_iterated && self.penalty.update(monitor.work());
        self.fallback.has_iterated = true;
        monitor.solution.work.resolvents += 1;
        workspace.resolve(
            monitor.problem.factor,
            &monitor.problem.penalties(self.penalty.scale),
        );
        self.fallback.iterations = tuning::iterations();
        if restarted {
            self.damping.restart();
            self.fallback.iterations = tuning::after_restart();
            // Now and then from elsewhere; if that does not help, back to where it was.
            if let Some(saved) = self.fallback.saved.take() {
                (self.point.p, self.point.r) = saved;
            } else if self.penalty.restarts % 4 == 3 && monitor.problem.can_be_swept() {
                self.fallback.saved = Some((self.point.p, self.point.r));
                self.sweep_aside(monitor);
            }
            self.point.rebuild(monitor.problem, self.penalty.scale);
        }
        if monitor.take_lost() {
            self.point.set_zero_impulse(monitor.problem);
        }
        Way::Admm
    }

    /// Sweeps without impulses, which have to find something far better than what is here.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn begin_side_branch<const N: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C>,
    ) -> Phase {
        let bar = self.point.natural_map * tuning::side_branch();
        self.fallback.saved = Some((self.point.p, self.point.r));
        self.point.set_zero_impulse(monitor.problem);
        let phase = self.begin_sweeps();
        self.sweeps.accept_below = Some(bar);
        phase
    }

    /// Back to where a side branch was left for.
    pub(super) fn leave_side_branch<const N: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C>,
    ) -> Phase {
        if let Some(saved) = self.fallback.saved.take() {
            (self.point.p, self.point.r) = saved;
        }
        self.point.rebuild(monitor.problem, self.penalty.scale);
        Phase::Fallback
    }

    /// Goes where 20 more sweeps lead than the last time.
    #[cfg_attr(target_os = "none", inline(never))]
    fn sweep_aside<const N: usize>(&mut self, monitor: &mut Monitor<'_, '_, T, N, D, C>) {
        self.point.r = self.fallback.last_sweeps;
        monitor
            .problem
            .natural_map(&self.point.r, &mut self.point.u);
        self.sweeps = Sweeps::none();
        for _ in 0..tuning::after_restart() {
            self.sweep_once(monitor);
        }
        self.fallback.last_sweeps = self.point.r;
        self.set_p(monitor);
    }
}
