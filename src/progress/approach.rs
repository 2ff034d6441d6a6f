//! Algorithm 2's part of the default method.

use crate::admm::{Acceleration, Iterate, Restart};
use crate::cholesky::rolled;
use crate::progress::{Phase, Progress};
use crate::refinement::Refinement;
use crate::search::Search;
use crate::workspace::Workspace;
use crate::{Factor, Real};

impl<T: Real, const D: usize, const C: usize> Progress<T, D, C> {
    /// Starts Algorithm 2 at the point.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn approach<const N: usize>(
        &mut self,
        factor: &Factor<T, N, D, C>,
        workspace: &mut Workspace<T, D, C>,
    ) {
        // Of a factor that has a resolvent or not, the next solve shall find the same.
        workspace.forget();
        let mut penalties = [factor.penalty(); C];
        if self.has_own {
            penalties = workspace.resolvent.penalties;
        }
        let pairs = self.point.velocity.iter().zip(&self.point.impulse);
        let pairs = pairs.zip(penalties);
        for (iterate, ((velocity, &impulse), penalty)) in self.iterates.iter_mut().zip(pairs) {
            rolled();
            *iterate = Iterate::at(*velocity, impulse.into(), penalty);
        }
        self.acceleration = Restart::START;
        self.phase = Phase::Approach { left: self.length };
    }

    /// From the last iterates of Algorithm 2 to a point.
    #[cfg_attr(target_os = "none", inline(never))]
    fn arrive<const N: usize>(&mut self, search: &mut Search<'_, '_, T, N, D, C>) {
        let targets = self.point.velocity.iter_mut();
        let targets = targets.zip(&mut self.point.impulse);
        for ((velocity, impulse), iterate) in targets.zip(&self.iterates) {
            rolled();
            *velocity = iterate.u;
            *impulse = iterate.impulse().into();
        }
        self.point.rebuild(search.problem, self.balance.scale);
        self.consider(search);
        self.phase = if self.caution.allows(&self.point) {
            Phase::Refine(Refinement::new())
        } else {
            Phase::Recover
        };
    }

    /// One iteration of Algorithm 2, `left` of which are left.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn iterate<const N: usize>(
        &mut self,
        search: &mut Search<'_, '_, T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        workspace: &mut Workspace<T, D, C>,
        left: usize,
    ) {
        if workspace.resolvent(self.has_own, factor).is_none() {
            self.resolve(search, factor, workspace, &[factor.penalty(); C]);
        }
        let Some(resolvent) = workspace.resolvent(self.has_own, factor) else {
            // Masses are spread too wide for one penalty.
            self.settle(search, Refinement::new());
            return;
        };
        let (iterates, acceleration) = (&mut self.iterates, &mut self.acceleration);
        let change = search.iterate(resolvent, iterates, acceleration);
        self.balance.observe(&change);
        if left > 1 || search.is_over() {
            self.phase = Phase::Approach {
                left: left.saturating_sub(1),
            };
        } else {
            self.arrive(search);
        }
    }

    /// Computes a resolvent of this solve's own, in the place of the last linearisation.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn resolve<const N: usize>(
        &mut self,
        search: &mut Search<'_, '_, T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        workspace: &mut Workspace<T, D, C>,
        penalties: &[T; C],
    ) {
        let (delassus, contacts) = (factor.delassus(), factor.contacts());
        let computed = workspace.resolvent.compute(delassus, contacts, penalties);
        self.has_own = computed.is_ok();
        search.solution.factorizations += 1;
    }
}
