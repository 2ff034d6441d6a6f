//! The search for a solution: the best impulse so far, what it has cost, and when to stop.

use crate::admm::{Acceleration, Change, Iterate, iterate};
use crate::contact_space::ContactVector;
use crate::problem::Problem;
use crate::residual::quotient;
use crate::resolvent::Resolvent;
use crate::{Real, Settings, SlipUpdate, Solution, Status};
use core::mem;
use nalgebra::SVector;

/// One solve under way.
pub(crate) struct Search<'a, T, const N: usize, const D: usize, const C: usize> {
    pub(crate) problem: Problem<'a, T, N, D, C>,
    pub(crate) solution: &'a mut Solution<T, N, D, C>,
    settings: &'a Settings<T>,
    /// How it ended, once it has.
    status: Option<Status>,
    /// The best impulse so far, and the first part of its error as contact space sees it.
    best: ContactVector<T, D, C>,
    natural_map: Option<T>,
    /// The error of an iterate is looked at when the square of its cheap estimate is below this.
    gate: T,
    /// Corrections of `q`, see [`Self::consider`].
    corrections: usize,
    /// The best natural map when it last halved, and the failures since.
    milestone: Option<T>,
    failures: usize,
    /// The impulses have run away.
    lost: bool,
}

impl<'a, T: Real, const N: usize, const D: usize, const C: usize> Search<'a, T, N, D, C> {
    pub(crate) fn new(
        problem: Problem<'a, T, N, D, C>,
        settings: &'a Settings<T>,
        solution: &'a mut Solution<T, N, D, C>,
    ) -> Self {
        solution.iterations = 0;
        solution.newton_steps = 0;
        solution.factorizations = 0;
        solution.certificate.clear();
        Self {
            problem,
            solution,
            settings,
            status: None,
            best: [[T::ZERO; D]; C],
            natural_map: None,
            gate: settings.tolerance * settings.tolerance * T::literal(4.0),
            corrections: 0,
            milestone: None,
            failures: 0,
            lost: false,
        }
    }

    /// Work done, in iterations.
    pub(crate) fn cost(&self) -> usize {
        self.solution.iterations + 10 * self.solution.newton_steps
    }

    /// Does it go on?
    pub(crate) fn is_running(&self) -> bool {
        self.status.is_none() && self.cost() < self.settings.max_iterations
    }

    /// Is this a claim that [`Self::finish`] will make?
    pub(crate) fn is_solved(&self) -> bool {
        self.status == Some(Status::Solved)
    }

    /// Size of the impulses, in units of what the velocities to be changed explain.
    fn impulse(&self) -> T {
        let contacts = self.solution.contacts.iter();
        let square = contacts.fold(T::ZERO, |sum, contact| sum + contact.impulse.norm_squared());
        quotient(square.square_root(), self.problem.size)
    }

    /// Are the impulses much larger than the velocities to be changed explain? Where walls close
    /// on a body they grow without bound, and an error relative to them says nothing.
    pub(crate) fn impulse_is_excessive(&self) -> bool {
        self.impulse() > T::literal(4.0)
    }

    /// Is the error small only because the impulses run away? Then it is not small beside the
    /// velocities to be changed.
    fn runs_away(&self) -> bool {
        let impulse = self.impulse();
        impulse > T::literal(1e8) && impulse * self.solution.error > T::literal(0.1)
    }

    /// Have the impulses run away since this was last asked?
    pub(crate) fn take_lost(&mut self) -> bool {
        mem::take(&mut self.lost)
    }

    /// Ends it.
    pub(crate) fn stop(&mut self, status: Status) {
        self.status = Some(status);
    }

    /// One ADMM iteration.
    #[inline]
    pub(crate) fn iterate<A: Acceleration<T>>(
        &mut self,
        resolvent: &Resolvent<T, D, C>,
        iterates: &mut [Iterate<T, D>; C],
        acceleration: &mut A,
    ) -> Change<T> {
        self.solution.iterations += 1;
        let change = iterate(&self.problem, resolvent, iterates, acceleration);
        // Squares, of which it is enough to be compared.
        let size = self.problem.size * self.problem.size;
        let estimate = quotient(change.error, size.max(change.impulse));
        let tolerance = self.settings.tolerance * self.settings.tolerance;
        if self.problem.slip == SlipUpdate::OuterLoop && estimate <= tolerance {
            iterates.iter_mut().for_each(Iterate::update_slip);
            *acceleration = A::START;
        }
        let last = self.cost() >= self.settings.max_iterations;
        if estimate <= self.gate || last {
            self.gate = estimate * T::literal(0.25);
            self.consider_iterates(iterates);
        }
        change
    }

    /// [`Self::consider`] for `r = -rho ζ`.
    pub(crate) fn consider_iterates(&mut self, iterates: &[Iterate<T, D>; C]) {
        let (mut r, mut u) = ([[T::ZERO; D]; C], [[T::ZERO; D]; C]);
        for (r, iterate) in r.iter_mut().zip(iterates) {
            *r = iterate.impulse().into();
        }
        let natural_map = self.problem.natural_map(&r, &mut u);
        self.consider(&r, &u, natural_map);
    }

    /// Keeps an impulse if it is the best so far, and stops if it solves the problem.
    ///
    /// `u = W r + q`. Only an impulse that contact space finds good enough is worth its velocity
    /// and its error. Where rounding makes `H v + w` another velocity than `W r + q`, `q` takes
    /// the difference, and the search goes on with what counts (iterative refinement).
    pub(crate) fn consider(
        &mut self,
        r: &ContactVector<T, D, C>,
        u: &ContactVector<T, D, C>,
        natural_map: T,
    ) {
        if self.natural_map.is_some_and(|best| natural_map >= best) {
            return;
        }
        self.best = *r;
        self.natural_map = Some(natural_map);
        if natural_map > self.settings.tolerance {
            return;
        }
        self.problem.evaluate(r, self.solution);
        if self.runs_away() {
            self.lost = true;
            self.natural_map = None;
        } else if self.solution.error <= self.settings.tolerance {
            self.stop(Status::Solved);
        } else if self.corrections < 4 {
            self.corrections += 1;
            self.natural_map = Some(self.solution.error);
            for (i, (contact, u)) in self.solution.contacts.iter().zip(u).enumerate() {
                self.problem
                    .correct(i, contact.velocity - SVector::from(*u));
            }
        } else {
            self.stop(Status::PrecisionLimit);
        }
    }

    /// A Newton step was rejected: near the limit of the number type, ten in a row are enough.
    pub(crate) fn fail(&mut self) {
        let Some(best) = self.natural_map else { return };
        let two = T::ONE + T::ONE;
        if self
            .milestone
            .is_none_or(|milestone| two * best < milestone)
        {
            self.milestone = Some(best);
            self.failures = 0;
        }
        self.failures += 1;
        if self.failures > 10 && best < T::literal(256.0) * T::EPSILON {
            self.stop(Status::PrecisionLimit);
        }
    }

    /// Writes down the best that was found.
    pub(crate) fn finish(self) {
        self.solution.status = self.status.unwrap_or(Status::MaxIterations);
        if !self.is_solved() {
            self.problem.evaluate(&self.best, self.solution);
        }
    }
}
