//! What rests stays at rest where forces can hold it, although Coulomb's law may have another solution in which it slides.
//!
//! A solution in which all that pushes sticks is that of the convex relaxation: De Saxcé's shift of `u_T = 0` is 0. The relaxation's
//! velocities are unique, so whether a body can stay is a convex question. A solve that begins at rest and comes to a solution that is
//! not the relaxation's asks it: the central path solves the relaxation, with impulses inside of their cones.
//!
//! The answer is no as soon as the path proves it. Where `r` is in the cones and `u = W r + q` in their duals, the duality gap `r · u`
//! bounds how far `u` is from the relaxation's velocities: `alpha_i |u_i - u*_i|² <= 2 D (r · u)`.

use crate::cone::split;
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::{norm, square};
use crate::problem::Problem;
use crate::real::Real;
use crate::sets::point::NewtonPoint;
use crate::solution::{Model, Status};
use crate::solver::monitor::Monitor;
use crate::solver::record::{Question, Record, Rest};
use core::mem;
use nalgebra::SVector;

/// A solution leaves a rest if the error of the relaxation exceeds this share of the tolerance.
const LEAVES: f64 = 0.25;

/// Impulses more than so many times as large as expected are those of a glitch, and would make any motion small.
const GLITCH: f64 = 20.0;

/// A body at rest is disturbed if the error of its last solution exceeds this.
pub(super) const DISTURBED: f64 = 0.01;

/// A last solution that is good enough creeps if what pushes moves by so many tolerances.
const CREEPS: f64 = 2.0;

/// An answer is exact enough to end the question at this share of the tolerance.
const ANSWERED: f64 = 0.125;

/// The relaxation is solved for certain at this share of the tolerance.
const EXACT: f64 = 1.0 / 64.0;

impl<T: Real, const D: usize, const C: usize, const R: usize> Record<T, D, C, R> {
    /// Is it being asked whether all can stay at rest?
    pub(super) fn asks_for_rest(&self) -> bool {
        self.knows_answer() || self.rest == Rest::AskedFirst
    }

    /// Is something asked to which the best impulses so far are an answer?
    pub(super) fn knows_answer(&self) -> bool {
        matches!(self.rest, Rest::Asked | Rest::Centred)
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Problem<'_, T, N, D, C, R, S>
{
    /// Does what pushes move by more than a share of the impulses?
    pub(super) fn moves_what_pushes(
        &self,
        r: &Stacked<T, D, C, R>,
        u: &Stacked<T, D, C, R>,
        share: T,
    ) -> bool {
        let [moved, expected, size] = self.motion(r, u, true);
        moved > share * share * size.min(expected * T::literal(GLITCH * GLITCH))
    }

    /// Squares: how far contacts move, or only those that push, in N·s, and the expected size of impulses and theirs.
    #[cfg_attr(target_os = "none", inline(never))]
    fn motion(
        &self,
        r: &Stacked<T, D, C, R>,
        u: &Stacked<T, D, C, R>,
        only_pushing: bool,
    ) -> [T; 3] {
        let mut moved = T::ZERO;
        let values = r.contacts.iter().zip(&u.contacts);
        for (set, (r, u)) in self.sets.contacts().iter().zip(values) {
            if !only_pushing || *r != [T::ZERO; D] {
                moved += set.alpha * set.alpha * square(u);
            }
        }
        let expected = self.reference_impulse * self.reference_impulse;
        [moved, expected, r.contact_square().max(expected)]
    }

    /// Takes De Saxcé's shift away, or puts it back.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn set_shift(&mut self, on: bool) {
        if self.model == Model::Coulomb {
            for set in self.sets.contacts_mut() {
                set.shift_factor = if on { set.cone.friction() } else { T::ZERO };
            }
        }
    }

    /// Is the error of the relaxation less than `most` for certain, because hardly anything moves? What impulses in their cones leave of a
    /// natural map is no longer than `alpha u`.
    fn stays(&self, point: &NewtonPoint<T, D, C, R>, most: T) -> bool {
        let [moved, expected, size] = self.motion(&point.r, &point.u, false);
        let four = T::literal(4.0);
        !self.scene.is_mixed() && four * moved < expected.min(most * most * size)
    }

    /// How far impulses are inside of their cones: the least `mu r_N - |r_T|`.
    #[cfg_attr(target_os = "none", inline(never))]
    fn margin(&self, r: &Stacked<T, D, C, R>) -> T {
        let mut least = T::INFINITY;
        for (set, r) in self.sets.contacts().iter().zip(&r.contacts) {
            let r = SVector::from(*r);
            let (normal, tangent) = split(&r);
            least = least.min(set.cone.friction() * normal - norm(tangent));
        }
        least
    }

    /// Does the duality gap of the relaxation tell that something slides in its solution?
    #[inline(never)]
    fn must_slide(&self, r: &Stacked<T, D, C, R>, u: &Stacked<T, D, C, R>) -> bool {
        let mut gap = T::ZERO;
        let contacts = || {
            let values = r.contacts.iter().zip(&u.contacts);
            self.sets.contacts().iter().zip(values)
        };
        let margin = |mu: T, u: &[T; D]| {
            let u = SVector::from(*u);
            let (normal, tangent) = split(&u);
            normal - mu * norm(tangent)
        };
        for (set, (r, u)) in contacts() {
            if margin(set.cone.friction(), u) < T::ZERO {
                return false;
            }
            for (&r, &u) in r.iter().zip(u) {
                gap += r * u;
            }
        }
        for (set, (&r, &u)) in self.sets.rows().iter().zip(r.rows.iter().zip(&u.rows)) {
            gap += set.duality_gap(r, u);
        }
        let bound = gap * T::count(2 * D);
        contacts().any(|(set, (_, u))| {
            let left = margin(set.cone.friction(), u);
            // It moves for sure, and perhaps not by letting go.
            set.alpha * square(u) > T::literal(16.0) * bound && set.alpha * left * left < bound
        })
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Monitor<'_, '_, T, N, D, C, R, S>
{
    /// Begins to ask; `known` if there is a solution to go back to.
    pub(super) fn ask_for_rest(&mut self, known: bool) {
        self.record.rest = if known { Rest::Asked } else { Rest::AskedFirst };
        self.problem.set_shift(false);
    }

    /// Is the last solution good enough, and would the body creep with it?
    pub(super) fn creeps(&self, point: &NewtonPoint<T, D, C, R>) -> bool {
        let share = self.tolerance() * T::literal(CREEPS);
        self.record.status == Status::Solved
            && self.problem.moves_what_pushes(&point.r, &point.u, share)
    }

    /// Was all at rest, and is the solution that was found not that of the relaxation? Then it has to be asked.
    pub(super) fn leaves_rest(&mut self, point: &NewtonPoint<T, D, C, R>) -> bool {
        if self.record.rest != Rest::Before || self.record.status != Status::Solved {
            return false;
        }
        self.record.rest = Rest::Known;
        let most = self.tolerance() * T::literal(LEAVES);
        if self.problem.stays(point, most) {
            return false;
        }
        self.problem.set_shift(false);
        let relaxed = self.problem.error_estimate(&point.r, &point.u);
        self.problem.set_shift(true);
        let leaves = relaxed > most;
        if leaves {
            self.record.status = Status::Unsolved;
            self.ask_for_rest(true);
        }
        leaves
    }

    /// Impulses that solve the relaxation: if contact space says that they solve Coulomb's law, too, their error is
    /// [asked for](Self::judge_rest).
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn consider_rest(
        &mut self,
        r: &Stacked<T, D, C, R>,
        u: &Stacked<T, D, C, R>,
        estimate: T,
    ) {
        let tolerance = self.tolerance();
        let centred = self.record.rest == Rest::Centred;
        let margin = || self.problem.margin(r) > self.problem.margin(&self.record.best);
        if estimate > tolerance || centred && !margin() {
            return;
        }
        if self.coulomb_error(r, u) <= tolerance {
            self.record.question = Question::Error;
        }
    }

    /// What contact space says of the error by Coulomb's law, while the relaxation is solved.
    fn coulomb_error(&mut self, r: &Stacked<T, D, C, R>, u: &Stacked<T, D, C, R>) -> T {
        self.problem.set_shift(true);
        let error = self.problem.error_estimate(r, u);
        self.problem.set_shift(false);
        error
    }

    /// Keeps impulses that were [considered](Self::consider_rest) if they solve Coulomb's law, too. Stops if they are far more exact than was
    /// asked, or as exact as can be: at its limit a body is not to be carried beyond by the error of a tick.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn judge_rest(
        &mut self,
        r: &Stacked<T, D, C, R>,
        u: &Stacked<T, D, C, R>,
        estimate: T,
    ) {
        let error = self.coulomb_error(r, u);
        self.problem.set_shift(true);
        let is_solved = self.is_within(r) && self.solution.has_numbers();
        let question = mem::replace(&mut self.record.question, Question::Nothing);
        if is_solved {
            self.record.best = *r;
            self.record.estimate = Some(error);
            let centred = self.record.rest == Rest::Centred;
            if !centred {
                self.record.rest = Rest::Asked;
            }
            if error <= self.tolerance() * T::literal(ANSWERED) || self.is_exact(estimate) {
                self.record.rest = Rest::Known;
                self.stop(Status::Solved);
                return;
            }
        } else if question == Question::Error {
            self.record.question = Question::ExactError;
        }
        self.problem.set_shift(false);
    }

    /// Asks for impulses farther inside of the cones than those of the last solution, which is good enough.
    pub(super) fn ask_for_centre(&mut self) {
        self.record.status = Status::Unsolved;
        self.record.rest = Rest::Centred;
        self.problem.set_shift(false);
    }

    /// Is the relaxation solved to far less than the tolerance?
    fn is_exact(&self, estimate: T) -> bool {
        estimate <= self.tolerance() * T::literal(EXACT)
    }

    /// Is it known that not all can stay? The relaxation is solved to far less than the tolerance, and that is not Coulomb's law; or the
    /// duality gap tells before.
    pub(super) fn cannot_rest(&self, point: &NewtonPoint<T, D, C, R>) -> bool {
        self.is_exact(point.estimate) || self.problem.must_slide(&point.r, &point.u)
    }

    /// Asks no longer. Returns the impulses of the solution that slides, if it is known.
    pub(super) fn give_up_rest(&mut self) -> Option<Stacked<T, D, C, R>> {
        let known = self.record.knows_answer();
        self.record.rest = Rest::Known;
        self.record.question = Question::Nothing;
        self.problem.set_shift(true);
        if known {
            let (best, tolerance) = (self.record.best, self.tolerance());
            self.problem
                .evaluate(&best, (tolerance, true), self.solution);
            self.stop(Status::Solved);
        }
        known.then_some(self.record.best)
    }
}
