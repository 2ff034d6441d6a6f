//! What survives between solves: the warm start.

use crate::admm::Iterate;
use crate::cholesky::rolled;
use crate::newton::Point;
use crate::problem::{Problem, is_hyperstatic};
use crate::solution::zeros;
use crate::{Contact, Real};
use core::mem;
use nalgebra::SVector;

/// `ũ` and `r` of the last solve and of the one before, in the order of the last one's contacts.
#[derive(Clone, Debug)]
pub(crate) struct State<T, const D: usize, const C: usize> {
    /// `None` for a contact that was not in the last solve, and behind the contacts in use.
    contacts: [Option<ContactState<T, D>>; C],
}

#[derive(Clone, Copy, Debug)]
struct ContactState<T, const D: usize> {
    key: u32,
    u: SVector<T, D>,
    r: SVector<T, D>,
    /// The same of the solve before, if `solves > 1`. (An option in an option would not be all
    /// zeros.)
    before: (SVector<T, D>, SVector<T, D>),
    /// How many solves have had the contact.
    solves: u32,
}

impl<T: Real, const D: usize> ContactState<T, D> {
    /// `z = ũ - r / rho` as it was, or if both go on as they did `onwards`; an open contact stays open
    /// and a sticking one stuck.
    fn ahead(&self, penalty: T, onwards: bool) -> SVector<T, D> {
        let nought = |x: &SVector<T, D>| x.iter().all(|&x| x == T::ZERO);
        let (u, r) = if self.solves > 1 && onwards {
            self.before
        } else {
            (self.u, self.r)
        };
        let mut z = zeros();
        if !nought(&self.u) {
            z += self.u + (self.u - u);
        }
        if !nought(&self.r) && penalty > T::ZERO {
            z -= (self.r + (self.r - r)) / penalty;
        }
        z
    }
}

impl<T: Real, const D: usize, const C: usize> State<T, D, C> {
    /// Nothing solved yet.
    pub(crate) const fn cold() -> Self {
        Self {
            contacts: [None; C],
        }
    }

    /// Goes over to the contacts of the next solve: the first of a key takes what the first of that
    /// key left, the second what the second left. What nobody takes is forgotten.
    ///
    /// Tells where each contact was, if it is not where it was; `C` for one that is new.
    pub(crate) fn follow<const N: usize>(
        &mut self,
        contacts: &[Contact<T, N, D>],
    ) -> Option<[usize; C]> {
        let last = self.contacts.iter().map_while(Option::as_ref);
        let mut last = last.map(|last| last.key).peekable();
        let keys = contacts.iter().map(|contact| contact.key);
        let moved = last.peek().is_some() && !last.eq(keys);
        moved.then(|| self.reorder(contacts))
    }

    #[inline(never)]
    fn reorder<const N: usize>(&mut self, contacts: &[Contact<T, N, D>]) -> [usize; C] {
        let mut last = mem::replace(&mut self.contacts, [None; C]);
        let mut places = [C; C];
        let states = self.contacts.iter_mut().zip(&mut places);
        for ((state, place), contact) in states.zip(contacts) {
            rolled();
            let same = |left: &Option<ContactState<T, D>>| {
                left.is_some_and(|left| left.key == contact.key)
            };
            if let Some(found) = last.iter().position(same) {
                *place = found;
                *state = last.get_mut(found).and_then(Option::take);
            }
        }
        places
    }

    /// Remembers `ũ` and `r` of the contacts of a solve, instead of what an earlier part of the same
    /// solve left if it was `resumed`.
    pub(crate) fn keep<const N: usize>(
        &mut self,
        contacts: &[Contact<T, N, D>],
        values: impl Iterator<Item = (SVector<T, D>, SVector<T, D>)>,
        resumed: bool,
    ) {
        let pairs = contacts.iter().zip(values);
        for (state, (&Contact { key, .. }, (u, r))) in self.contacts.iter_mut().zip(pairs) {
            rolled();
            let (before, solves) = match state {
                Some(last) if resumed => (last.before, last.solves),
                Some(last) => ((last.u, last.r), last.solves.saturating_add(1)),
                None => ((zeros(), zeros()), 1),
            };
            *state = Some(ContactState {
                key,
                u,
                r,
                before,
                solves,
            });
        }
    }

    /// The first iterates of ADMM: the last ones, or at rest without impulse.
    pub(crate) fn iterates<const N: usize>(
        &mut self,
        problem: &Problem<'_, T, N, D, C>,
        penalty: T,
    ) -> [Iterate<T, D>; C] {
        let _ = self.follow(problem.scene.contacts());
        let mut iterates = [Iterate::at(zeros(), zeros(), penalty); C];
        let pairs = problem.laws().iter().zip(&self.contacts);
        for (iterate, (law, contact)) in iterates.iter_mut().zip(pairs) {
            if let Some(ContactState { u, r, .. }) = contact {
                *iterate = Iterate::at(*u, law.cone.project(r), penalty);
            }
        }
        iterates
    }

    /// The first point of Newton's method with `rho_i = scale alpha_i` for the contacts that were
    /// followed, and whether it is so good that no iteration has to come before a step.
    ///
    /// Candidates: `z = û - r / rho_i` with the last impulse and the velocity that it has now, and
    /// `z` as the last solves left it if it goes on to change as it did. (Hyperstatic impulses
    /// may change without effect, and would be carried to the edges of the cones: they stay as they
    /// were.) The one with the least
    /// error is taken if it is far better than none. (The energy is a poor judge: where a heavy
    /// body stands on a light one it sees only the light one.)
    #[inline(never)]
    pub(crate) fn point<const N: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C>,
        scale: T,
        tolerance: T,
        point: &mut Point<T, D, C>,
    ) -> bool {
        point.rest(problem);
        let rest = point.natural_map;
        if self.contacts.iter().all(Option::is_none) || rest <= tolerance {
            return false;
        }
        let (mut r, mut u) = ([[T::ZERO; D]; C], [[T::ZERO; D]; C]);
        let pairs = problem.laws().iter().zip(&self.contacts);
        for (r, (law, contact)) in r.iter_mut().zip(pairs) {
            rolled();
            if let Some(contact) = contact {
                *r = law.cone.project(&contact.r).into();
            }
        }
        let last = problem.natural_map(&r, &mut u);
        let onwards = !is_hyperstatic::<T, N, D, C>(&r);
        let mut ahead = None;
        if last > tolerance {
            self.look_ahead(problem, scale, onwards, point);
            ahead = Some(point.natural_map);
        }
        if ahead.is_none_or(|ahead| ahead * T::literal(3.0) > last) {
            (point.impulse, point.relative, point.natural_map) = (r, u, last);
            problem.lift(&u, &mut point.velocity);
            if let Some(ahead) = ahead {
                point.rebuild(problem, scale);
                if ahead < point.natural_map {
                    self.look_ahead(problem, scale, onwards, point);
                }
            }
        }
        let eager = point.natural_map < rest * T::literal(0.25);
        if !eager {
            point.rest(problem);
        }
        eager
    }

    /// Moves a point to the `z` that [`ContactState::ahead`] says.
    fn look_ahead<const N: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C>,
        scale: T,
        onwards: bool,
        point: &mut Point<T, D, C>,
    ) {
        let pairs = problem.laws().iter().zip(&self.contacts);
        for (z, (law, contact)) in point.z.iter_mut().zip(pairs) {
            rolled();
            *z = match contact {
                Some(contact) => contact.ahead(scale * law.step, onwards),
                None => zeros(),
            };
        }
        point.update(problem, scale);
    }
}

#[cfg(test)]
mod tests;
