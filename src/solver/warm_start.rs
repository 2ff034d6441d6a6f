//! What survives between solves: the warm start.

use crate::admm::Iterate;
use crate::laws::{Coulomb, Laws, Room};
use crate::linalg::hints::rolled;
use crate::problem::Problem;
use crate::scene::check_finite;
use crate::solution::zeros;
use crate::solver::doubt::LOST;
use crate::solver::point::Point;
use crate::solver::row_keys::RowKeys;
use crate::{Contact, Error, Factor, Input, Real, Scene};
use core::mem;
use nalgebra::SVector;

mod state;

pub(super) use state::ContactState;

/// What is known where a solve starts.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Known {
    /// Nothing: it starts without impulses.
    Nothing,
    /// The last solution, which sweeps may go on from, because impulses are unique.
    Isostatic,
    /// The last solution, where they are not.
    Hyperstatic,
}

/// `ũ` and `r` of the last solve and `r` of the one before, in the order of the last one's contacts.
#[derive(Clone, Debug)]
pub(crate) struct WarmStart<T: Real, const D: usize, const C: usize, L: Laws = Coulomb> {
    /// `None` for a contact that was not in the last solve, and behind the contacts in use.
    pub(super) contacts: [Option<ContactState<T, D>>; C],
    /// Of slots of joint rows: the keys of the rows.
    pub(super) rows: [L::Room<Option<RowKeys<D>>>; C],
}

impl<T: Real, const D: usize, const C: usize, L: Laws> WarmStart<T, D, C, L> {
    /// Nothing solved yet.
    pub(crate) const fn cold() -> Self {
        Self {
            contacts: [None; C],
            rows: [const { L::Room::EMPTY }; C],
        }
    }

    /// Forgets the last solve for impulses that are given, each with the key of its contact.
    pub(crate) fn set(&mut self, impulses: &[(u32, SVector<T, D>)]) -> Result<(), Error> {
        if impulses.len() > C {
            return Err(Error::ContactListFull { capacity: C });
        }
        for (contact, (_, r)) in impulses.iter().enumerate() {
            check_finite(r, Input::InitialImpulse { contact })?;
        }
        *self = Self::cold();
        for (state, &(key, r)) in self.contacts.iter_mut().zip(impulses) {
            *state = Some(ContactState {
                key,
                u: zeros(),
                r,
                before: zeros(),
                solves: 0,
            });
        }
        Ok(())
    }

    /// Reorders the state for the contacts of the next solve: the first contact of a key takes what the first of that
    /// key left, the second what the second left. What nobody takes is forgotten.
    ///
    /// Returns the old place of each contact if any has changed its place; `C` for a new contact.
    pub(crate) fn follow<const N: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, L>,
    ) -> Option<[usize; C]> {
        let contacts = scene.contacts();
        let last = self.contacts.iter().map_while(Option::as_ref);
        let mut last = last.map(|last| last.key).peekable();
        let keys = contacts.iter().map(|contact| contact.key);
        let mut moved = last.peek().is_some() && !last.eq(keys);
        if L::MIXED {
            moved |= self.contacts.iter().any(Option::is_some) && !self.has_rows_of(scene);
            return moved.then(|| self.reorder_slots(scene));
        }
        moved.then(|| self.reorder(contacts))
    }

    #[cfg_attr(target_os = "none", inline(never))]
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

    /// Keeps `ũ` and `r` of the contacts of a solve, or in place of those that the last call left.
    pub(crate) fn keep<const N: usize>(
        &mut self,
        (scene, factor): (&Scene<T, N, D, C, L>, &Factor<T, N, D, C, L>),
        values: impl Iterator<Item = (SVector<T, D>, SVector<T, D>)>,
        replaces: bool,
    ) {
        let pairs = scene.contacts().iter().zip(values).enumerate();
        for (state, (i, (&Contact { key, .. }, (u, r)))) in self.contacts.iter_mut().zip(pairs) {
            rolled();
            // Physical ones: the scales of joint rows change with `M`.
            let (u, r) = (factor.unscaled(i, u), factor.scaled(i, r));
            let (before, solves) = match state {
                Some(last) if replaces => (last.before, last.solves),
                Some(last) => (last.r, last.solves.saturating_add(1)),
                None => (zeros(), 1),
            };
            *state = Some(ContactState {
                key,
                u,
                r,
                before,
                solves,
            });
        }
        if L::MIXED {
            self.keep_keys(scene);
        }
    }

    /// The first iterates of ADMM: the last ones, or at rest without impulse.
    pub(crate) fn iterates<const N: usize>(
        &mut self,
        problem: &Problem<'_, T, N, D, C, L>,
        penalty: T,
    ) -> [Iterate<T, D>; C] {
        let _ = self.follow(problem.scene);
        let mut iterates = [Iterate::at(zeros(), zeros(), penalty); C];
        let pairs = problem.laws().iter().zip(&self.contacts);
        for (iterate, (law, contact)) in iterates.iter_mut().zip(pairs) {
            if let Some(ContactState { u, r, .. }) = contact {
                *iterate = Iterate::at(*u, law.cone.nearest(r), penalty);
            }
        }
        iterates
    }

    /// Where a solve starts, for the contacts that were followed: at the last solution, if its error now is less than that
    /// of zero impulses. (The error is relative: impulses of a glitch, far beyond what is expected, do not count.)
    ///
    /// Unique impulses are extrapolated if the solve is to go `onwards` from one tick to the next. Hyperstatic ones can change without effect, and would be carried to the boundaries of
    /// the cones: they stay as they were.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn start<const N: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C, L>,
        (tolerance, onwards): (T, bool),
        point: &mut Point<T, D, C>,
    ) -> Known {
        point.set_zero_impulse(problem);
        let rest = point.natural_map;
        if self.contacts.iter().any(Option::is_some) && rest > tolerance {
            self.impulses(problem, false, &mut point.r);
            let unique = problem.can_be_swept() && !problem.is_hyperstatic(&point.r);
            if unique && onwards {
                self.go_on(problem, tolerance, point);
            } else if unique {
                point.natural_map = problem.natural_map(&point.r, &mut point.u);
            } else {
                self.stay(problem, tolerance, point);
            }
            if point.natural_map < rest && !problem.exceeds(&point.r, T::literal(LOST)) {
                return if unique {
                    Known::Isostatic
                } else {
                    Known::Hyperstatic
                };
            }
            point.set_zero_impulse(problem);
        }
        Known::Nothing
    }

    /// Extrapolates the impulses of a point; but if both the extrapolated and the last impulses are within tolerance, keeps the
    /// last: a body at rest must not drift with the errors of its impulses.
    #[cfg_attr(target_os = "none", inline(never))]
    fn go_on<const N: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C, L>,
        tolerance: T,
        point: &mut Point<T, D, C>,
    ) {
        let (r, mut u) = (point.r, [[T::ZERO; D]; C]);
        self.impulses(problem, true, &mut point.r);
        point.natural_map = problem.natural_map(&point.r, &mut point.u);
        if point.natural_map <= tolerance {
            let last = problem.natural_map(&r, &mut u);
            if last <= tolerance {
                (point.r, point.u, point.natural_map) = (r, u, last);
            }
        }
    }

    /// The last impulses, or the extrapolated ones if `onwards`.
    #[cfg_attr(target_os = "none", inline(never))]
    fn impulses<const N: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C, L>,
        onwards: bool,
        r: &mut [[T; D]; C],
    ) {
        let pairs = problem.laws().iter().zip(&self.contacts).enumerate();
        for (r, (i, (law, contact))) in r.iter_mut().zip(pairs) {
            rolled();
            if let Some(contact) = contact {
                let push = if onwards { contact.ahead() } else { contact.r };
                let push = problem.factor.unscaled(i, push);
                *r = law.project(&push).into();
            }
        }
    }

    /// Moves a point from the last impulses to the last solution.
    ///
    /// Candidates: `z = û - r / rho_i` with the last impulse and the velocity that it causes now, and the last `z`. The one
    /// with the least error is taken. (The energy is a poor judge: if a heavy body stands on a light one, it sees only the
    /// light one.)
    #[cfg_attr(target_os = "none", inline(never))]
    fn stay<const N: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C, L>,
        tolerance: T,
        point: &mut Point<T, D, C>,
    ) {
        let (r, mut u) = (point.r, [[T::ZERO; D]; C]);
        let last = problem.natural_map(&r, &mut u);
        let mut as_it_was = None;
        if last > tolerance && self.is_a_solution() {
            self.look_back(problem, point);
            as_it_was = Some(point.natural_map);
        }
        if as_it_was.is_none_or(|error| error * T::literal(3.0) > last) {
            (point.r, point.u, point.natural_map) = (r, u, last);
            problem.augmented_velocity(&u, &mut point.p);
            if let Some(error) = as_it_was {
                point.rebuild(problem);
                if error < point.natural_map {
                    self.look_back(problem, point);
                }
            }
        }
    }

    /// Are `ũ` and `r` those of a solve?
    fn is_a_solution(&self) -> bool {
        let mut contacts = self.contacts.iter().flatten();
        contacts.all(|contact| contact.solves > 0)
    }

    /// Moves a point to `z = ũ - r / rho_i` as it was.
    #[cfg_attr(target_os = "none", inline(never))]
    fn look_back<const N: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C, L>,
        point: &mut Point<T, D, C>,
    ) {
        let pairs = point.p.iter_mut().zip(&mut point.r);
        for (i, ((velocity, impulse), contact)) in pairs.zip(&self.contacts).enumerate() {
            rolled();
            let known = contact.as_ref().map(|contact| {
                let (u, r) = (contact.u, contact.r);
                let factor = problem.factor;
                (factor.scaled(i, u), factor.unscaled(i, r).into())
            });
            (*velocity, *impulse) = known.unwrap_or((zeros(), [T::ZERO; D]));
        }
        point.rebuild(problem);
    }
}

#[cfg(test)]
mod tests;
