//! What survives between solves: the warm start.

use crate::Real;
use crate::admm::Iterate;
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

    /// Remembers the iterates of the contacts in use, for the penalty they belong to.
    pub(crate) fn keep<const N: usize>(
        &mut self,
        problem: &Problem<'_, T, N, D, C>,
        iterates: &[Iterate<T, D>; C],
        penalty: T,
    ) {
        let pairs = self.contacts.iter_mut().zip(iterates);
        for (contact, iterate) in pairs.take(problem.laws().len()) {
            *contact = Some(ContactState {
                u: iterate.u,
                r: iterate.zeta * -penalty,
            });
        }
    }

    /// The first iterate of a solve: the last one, or at rest without impulse.
    pub(crate) fn start<const N: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C>,
        penalty: T,
    ) -> [Iterate<T, D>; C] {
        let mut iterates = [Iterate::at(zeros(), zeros()); C];
        let pairs = problem.laws().iter().zip(&self.contacts);
        for (iterate, (law, contact)) in iterates.iter_mut().zip(pairs) {
            if let Some(ContactState { u, r }) = contact {
                let r = law.cone.project(r);
                *iterate = Iterate::at(*u, r / -penalty);
            }
        }
        iterates
    }
}
