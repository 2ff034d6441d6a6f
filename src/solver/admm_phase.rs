//! Algorithm 2's part of the method.

use crate::Real;
use crate::admm::{Iterate, SlipUpdate};
use crate::linalg::hints::rolled;
use crate::solver::monitor::Monitor;
use crate::solver::phases::{Phase, Solve};
use crate::solver::workspace::Workspace;

impl<T: Real, const D: usize, const C: usize> Solve<T, D, C> {
    /// Algorithm 2 from the `P` and `r` of the point.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn begin_admm<const N: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C>,
        workspace: &mut Workspace<T, D, C>,
    ) -> Phase {
        let factor = monitor.problem.factor;
        // Of a factor that has a resolvent or not, the next solve shall find the same.
        workspace.forget_jacobian();
        let resolvent = workspace.resolvent(factor);
        let penalties = resolvent.map_or([factor.penalty(); C], |resolvent| resolvent.penalties);
        let sources = self.point.p.iter().zip(&self.point.r).zip(penalties);
        for (iterate, ((p, &r), penalty)) in self.iterates.iter_mut().zip(sources) {
            rolled();
            *iterate = Iterate::at(*p, r.into(), penalty);
        }
        self.momentum.start();
        Phase::Admm {
            left: self.fallback.iterations,
        }
    }

    /// One iteration; false if there is no resolvent.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn iterate<const N: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C>,
        workspace: &mut Workspace<T, D, C>,
    ) -> bool {
        let factor = monitor.problem.factor;
        if workspace.resolvent(factor).is_none() {
            monitor.solution.work.resolvents += 1;
            workspace.resolve(factor, &[factor.penalty(); C]);
        }
        let Some(resolvent) = workspace.resolvent(factor) else {
            return false;
        };
        let (iterates, momentum) = (&mut self.iterates, &mut self.momentum);
        let change = monitor.iterate(resolvent, iterates, momentum, SlipUpdate::EveryIteration);
        self.penalty.observe(&change);
        true
    }

    /// From the last iterates to a point.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn take_iterates<const N: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C>,
    ) {
        let targets = self.point.p.iter_mut().zip(&mut self.point.r);
        for ((p, r), iterate) in targets.zip(&self.iterates) {
            rolled();
            *p = iterate.u;
            *r = iterate.impulse().into();
        }
        self.point.rebuild(monitor.problem, self.penalty.scale);
        self.consider(monitor);
    }
}
