//! The search for a solution: the best impulse so far, what it has cost, and when to stop.

use crate::admm::{Acceleration, Change, Iterate, iterate};
use crate::contact_space::ContactVector;
use crate::problem::Problem;
use crate::residual::quotient;
use crate::resolvent::Resolvent;
use crate::{Real, Settings, SlipUpdate, Solution, Status};

/// One solve under way.
pub(crate) struct Search<'a, T, const N: usize, const D: usize, const C: usize> {
    pub(crate) problem: &'a Problem<'a, T, N, D, C>,
    settings: &'a Settings<T>,
    solution: &'a mut Solution<T, N, D, C>,
    /// The best impulse so far, and the first part of its error as contact space sees it.
    best: ContactVector<T, D, C>,
    natural_map: Option<T>,
    /// The error of an iterate is looked at when its cheap estimate is below this.
    gate: T,
}

impl<'a, T: Real, const N: usize, const D: usize, const C: usize> Search<'a, T, N, D, C> {
    pub(crate) fn new(
        problem: &'a Problem<'a, T, N, D, C>,
        settings: &'a Settings<T>,
        solution: &'a mut Solution<T, N, D, C>,
    ) -> Self {
        solution.iterations = 0;
        solution.newton_steps = 0;
        solution.factorizations = 0;
        Self {
            problem,
            settings,
            solution,
            best: [[T::ZERO; D]; C],
            natural_map: None,
            gate: settings.tolerance + settings.tolerance,
        }
    }

    /// Work done, in iterations.
    pub(crate) fn cost(&self) -> usize {
        self.solution.iterations + 10 * self.solution.newton_steps
    }

    /// May it go on?
    pub(crate) fn has_budget(&self) -> bool {
        self.cost() < self.settings.max_iterations
    }

    /// One more Newton step was made.
    pub(crate) fn count_newton_step(&mut self) {
        self.solution.newton_steps += 1;
    }

    /// One more resolvent was computed.
    pub(crate) fn count_factorization(&mut self) {
        self.solution.factorizations += 1;
    }

    /// One ADMM iteration; true in the second place if it solves the problem.
    #[inline]
    pub(crate) fn iterate<A: Acceleration<T>>(
        &mut self,
        resolvent: &Resolvent<T, D, C>,
        iterates: &mut [Iterate<T, D>; C],
        acceleration: &mut A,
    ) -> (Change<T>, bool) {
        self.solution.iterations += 1;
        let change = iterate(self.problem, resolvent, iterates, acceleration);
        let penalty = resolvent.penalty();
        let size = self.problem.size.max(penalty * change.zeta.square_root());
        let estimate = quotient(change.error.square_root(), size);
        let tolerance = self.settings.tolerance;
        if self.problem.slip == SlipUpdate::OuterLoop && estimate <= tolerance {
            iterates.iter_mut().for_each(Iterate::update_slip);
            *acceleration = A::START;
        }
        let last = self.solution.iterations == self.settings.max_iterations;
        if estimate > self.gate && !last {
            return (change, false);
        }
        self.gate = estimate * T::literal(0.5);
        (change, self.consider_iterates(iterates, penalty))
    }

    /// [`Self::consider`] for `r = -rho ζ`.
    pub(crate) fn consider_iterates(&mut self, iterates: &[Iterate<T, D>; C], penalty: T) -> bool {
        let (mut r, mut u) = ([[T::ZERO; D]; C], [[T::ZERO; D]; C]);
        for (r, iterate) in r.iter_mut().zip(iterates) {
            *r = (iterate.zeta * -penalty).into();
        }
        let natural_map = self.problem.natural_map(&r, &mut u);
        self.consider(&r, natural_map)
    }

    /// Keeps an impulse if it is the best so far; true if it solves the problem.
    ///
    /// Only an impulse that contact space finds good enough is worth its velocity and its error.
    pub(crate) fn consider(&mut self, r: &ContactVector<T, D, C>, natural_map: T) -> bool {
        if self.natural_map.is_some_and(|best| natural_map >= best) {
            return false;
        }
        self.best = *r;
        self.natural_map = Some(natural_map);
        if natural_map > self.settings.tolerance {
            return false;
        }
        self.problem.evaluate(r, self.solution);
        self.solution.error <= self.settings.tolerance
    }

    /// Ends the search with the best that was found.
    pub(crate) fn finish(self, solved: bool) {
        self.solution.status = Status::Solved;
        if !solved {
            self.solution.status = Status::MaxIterations;
            self.problem.evaluate(&self.best, self.solution);
        }
    }
}
