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
    /// that the last impulse has now, and none of it. The first is taken if it is so good,
    /// otherwise the one with the least energy.
    #[inline(never)]
    pub(crate) fn point<const N: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C>,
        scale: T,
        point: &mut Point<T, D, C>,
    ) -> bool {
        // Without velocities and impulses, u = q is all of the residual.
        let rest = problem.energy_at_rest();
        let contacts = point.velocity.iter_mut();
        let contacts = contacts.zip(&mut point.impulse);
        let sources = problem.laws().iter().zip(&self.contacts);
        for ((velocity, impulse), (law, contact)) in contacts.zip(sources) {
            if let Some(ContactState { u, r }) = contact {
                *velocity = *u;
                *impulse = law.cone.project(r).into();
            }
        }
        point.rebuild(problem, scale);
        if self.contacts.iter().all(Option::is_none) {
            return false;
        }
        let good = rest * T::literal(0.01);
        if point.energy < good {
            return true;
        }
        let mut now = point.clone();
        let velocities = now.velocity.iter_mut();
        let velocities = velocities.zip(&point.relative);
        for ((velocity, &relative), law) in velocities.zip(problem.laws()) {
            *velocity = relative.into();
            add_to_normal(velocity, law.lift(&relative.into()));
        }
        now.rebuild(problem, scale);
        if now.energy < point.energy {
            *point = now;
        }
        if point.energy < rest {
            return point.energy < good;
        }
        point.z = [zeros(); C];
        point.update(problem, scale);
        false
    }
}
