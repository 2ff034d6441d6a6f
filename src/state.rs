//! What survives between solves: the warm start.

use crate::Real;
use crate::admm::Iterate;
use crate::cone::add_to_normal;
use crate::newton::Point;
use crate::problem::Problem;
use crate::solution::zeros;
use nalgebra::SVector;

/// `ũ` and `r` of the last solve, for the contacts that have them.
#[derive(Clone, Debug)]
pub(crate) struct State<T, const D: usize, const C: usize> {
    contacts: [Option<ContactState<T, D>>; C],
}

#[derive(Clone, Copy, Debug)]
struct ContactState<T, const D: usize> {
    u: SVector<T, D>,
    r: SVector<T, D>,
}

impl<T: Real, const D: usize, const C: usize> State<T, D, C> {
    /// Nothing solved yet.
    pub(crate) const fn cold() -> Self {
        Self {
            contacts: [None; C],
        }
    }

    /// Contact `i` of the next solve was contact `previous[i]` of the last.
    pub(crate) fn carry_over(&mut self, previous: &[Option<usize>]) {
        let last = self.contacts;
        self.contacts = [None; C];
        for (contact, index) in self.contacts.iter_mut().zip(previous) {
            *contact = index.and_then(|index| last.get(index).copied().flatten());
        }
    }

    /// Remembers `ũ` and `r` of the contacts in use.
    pub(crate) fn keep(&mut self, contacts: impl Iterator<Item = (SVector<T, D>, SVector<T, D>)>) {
        for (state, (u, r)) in self.contacts.iter_mut().zip(contacts) {
            *state = Some(ContactState { u, r });
        }
    }

    /// The first iterates of ADMM: the last ones, or at rest without impulse.
    pub(crate) fn iterates<const N: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C>,
        penalty: T,
    ) -> [Iterate<T, D>; C] {
        let mut iterates = [Iterate::at(zeros(), zeros(), penalty); C];
        let pairs = problem.laws().iter().zip(&self.contacts);
        for (iterate, (law, contact)) in iterates.iter_mut().zip(pairs) {
            if let Some(ContactState { u, r }) = contact {
                *iterate = Iterate::at(*u, law.cone.project(r), penalty);
            }
        }
        iterates
    }

    /// The first point of Newton's method with `rho_i = scale alpha_i`, and whether it is so good
    /// that no iteration has to come before a step.
    ///
    /// Three candidates: `z = ũ - r / rho_i` as the last solve left it, the same with the velocity
    /// that the last impulse has now, and none of it. The one with the least energy is taken.
    pub(crate) fn point<const N: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C>,
        scale: T,
    ) -> (Point<T, D, C>, bool) {
        let cold = Point::at(problem, scale, &[zeros(); C]);
        if self.contacts.iter().all(Option::is_none) {
            return (cold, false);
        }
        let mut impulse = [[T::ZERO; D]; C];
        let mut relative = [[T::ZERO; D]; C];
        let pairs = problem.laws().iter().zip(&self.contacts);
        for (impulse, (law, contact)) in impulse.iter_mut().zip(pairs) {
            if let Some(ContactState { r, .. }) = contact {
                *impulse = law.cone.project(r).into();
            }
        }
        problem.natural_map(&impulse, &mut relative);
        let (mut then, mut now) = ([zeros(); C], [zeros(); C]);
        let sources = problem.laws().iter().zip(&self.contacts).zip(relative);
        for ((then, now), ((law, contact), relative)) in then.iter_mut().zip(&mut now).zip(sources)
        {
            *now = relative.into();
            add_to_normal(now, law.lift(&relative.into()));
            *then = contact.map_or(*now, |ContactState { u, .. }| u);
        }
        let then = Point::of(problem, scale, &then, &impulse);
        let now = Point::of(problem, scale, &now, &impulse);
        let warm = if then.energy <= now.energy { then } else { now };
        if warm.energy < cold.energy {
            let eager = warm.energy < cold.energy * T::literal(0.01);
            (warm, eager)
        } else {
            (cold, false)
        }
    }
}
