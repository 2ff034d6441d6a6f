//! The rest question: can all bodies stay at rest?
//!
//! Coulomb's law may have two solutions where a body rests: one in which it stays, and one in which it slides. The solver returns the
//! first if there is one ("At rest" in [`crate::guide::error`]).
//!
//! If all loaded contacts stick, their De Saxcé shift `mu |u_T|` is 0. Then the solution also solves the convex relaxation, provided that each
//! contact without load separates with `u_N >= mu |u_T|`. (One that grazes slower makes the answer a false no.) The velocities of the
//! relaxation are unique. So the question is convex: does the solution of the relaxation obey Coulomb's law? A solve that begins at
//! rest opens the question if its solution does not solve the relaxation. The central path then solves the relaxation.
//!
//! The answer may be known early. If every `r_i` lies in its cone and every `u_i` in the dual, with `u = W r + q`, the duality
//! gap `r · u` bounds the distance to the solution `r*`, `u*` of the relaxation: `½ |r - r*|_W² <= r · u`, so
//! `alpha_i |u_i - u*_i|² <= 2 D (r · u)`.

use crate::cone::split;
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::{norm, square};
use crate::linalg::zip::zip3;
use crate::problem::Problem;
use crate::real::Real;
use crate::sets::point::NewtonPoint;
use crate::solution::{Model, Status};
use crate::solver::monitor::{DOUBTFUL_IMPULSE_RATIO, Monitor};
use crate::solver::record::{Check, Record, RestQuestion};
use core::mem;
use nalgebra::SVector;

/// A solution leaves a rest if its estimate by the relaxation exceeds this share of the tolerance.
const LEAVES: f64 = 0.25;

/// A body at rest was disturbed if the estimate of its last solution exceeds this.
pub(super) const DISTURBED: f64 = 0.01;

/// A body creeps if its loaded contacts move by more than this many tolerances.
const CREEPS: f64 = 2.0;

/// A solution at rest closes the question if its estimate is at most this share of the tolerance.
const ANSWERED: f64 = 0.125;

/// The relaxation counts as solved exactly if its estimate is at most this share of the tolerance.
const EXACT: f64 = 1.0 / 64.0;

impl<T: Real, const D: usize, const C: usize, const R: usize> Record<T, D, C, R> {
    /// Is the rest question open, and the relaxation solved in place of Coulomb's law?
    pub(super) fn is_rest_question_open(&self) -> bool {
        self.has_fallback() || self.rest == RestQuestion::Open
    }

    /// Are the best impulses a solution, to fall back on if the rest question is closed without an answer?
    pub(super) fn has_fallback(&self) -> bool {
        matches!(self.rest, RestQuestion::OpenWithSolution | RestQuestion::Centring)
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Problem<'_, T, N, D, C, R, S>
{
    /// Do loaded contacts move by more than a share of the impulses? (Impulses count as doubtful at most: beside larger ones any motion is
    /// small.)
    pub(super) fn loaded_contacts_move(
        &self,
        r: &Stacked<T, D, C, R>,
        u: &Stacked<T, D, C, R>,
        share: T,
    ) -> bool {
        let motion = self.motion(r, u, true);
        let doubtful = T::literal(DOUBTFUL_IMPULSE_RATIO * DOUBTFUL_IMPULSE_RATIO);
        motion.moved > share * share * motion.size.min(motion.expected * doubtful)
    }

    /// The motion of all contacts, or only of the loaded ones.
    #[cfg_attr(target_os = "none", inline(never))]
    fn motion(&self, r: &Stacked<T, D, C, R>, u: &Stacked<T, D, C, R>, only_loaded: bool) -> Motion<T> {
        let mut moved = T::ZERO;
        for (set, r, u) in zip3(self.sets.contacts(), &r.contacts, &u.contacts) {
            if !only_loaded || *r != [T::ZERO; D] {
                moved += set.alpha * set.alpha * square(u);
            }
        }
        let expected = self.expected_size * self.expected_size;
        Motion { moved, expected, size: self.sets.contact_square(r).max(expected) }
    }

    /// Includes De Saxcé's shift in the contact law (Coulomb's law), or leaves it out (the relaxation).
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn set_shift(&mut self, on: bool) {
        if self.model == Model::Coulomb {
            for set in self.sets.contacts_mut() {
                set.shift_factor = if on { set.cone.friction() } else { T::ZERO };
            }
        }
    }

    /// Does so little move that the estimate by the relaxation is surely below `limit`? (If `r` lies in its cone, its natural map is no
    /// longer than `alpha u`.)
    fn hardly_moves(&self, point: &NewtonPoint<T, D, C, R>, limit: T) -> bool {
        let motion = self.motion(&point.r, &point.u, false);
        let four = T::literal(4.0);
        let bound = motion.expected.min(limit * limit * motion.size);
        !self.scene.is_mixed() && four * motion.moved < bound
    }

    /// The least distance `mu r_N - |r_T|` (N·s) of impulses to the boundaries of their cones.
    #[cfg_attr(target_os = "none", inline(never))]
    fn cone_margin(&self, r: &Stacked<T, D, C, R>) -> T {
        let mut least = T::INFINITY;
        for (set, r) in self.sets.contacts().iter().zip(&r.contacts) {
            let r = SVector::from(*r);
            let (normal, tangent) = split(&r);
            least = least.min(set.cone.friction() * normal - norm(tangent));
        }
        least
    }

    /// Does the duality gap prove that a contact moves in the solution of the relaxation, without a proof that it separates?
    #[inline(never)]
    fn must_slide(&self, r: &Stacked<T, D, C, R>, u: &Stacked<T, D, C, R>) -> bool {
        let mut gap = T::ZERO;
        // How far `u` is inside the dual cone.
        let dual_margin = |mu: T, u: &[T; D]| {
            let u = SVector::from(*u);
            let (normal, tangent) = split(&u);
            normal - mu * norm(tangent)
        };
        for (set, r, u) in zip3(self.sets.contacts(), &r.contacts, &u.contacts) {
            if dual_margin(set.cone.friction(), u) < T::ZERO {
                return false;
            }
            for (&r, &u) in r.iter().zip(u) {
                gap += r * u;
            }
        }
        for (set, &r, &u) in zip3(self.sets.rows(), &r.rows, &u.rows) {
            gap += set.duality_gap(r, u);
        }
        let bound = gap * T::count(2 * D);
        self.sets.contacts().iter().zip(&u.contacts).any(|(set, u)| {
            let margin = dual_margin(set.cone.friction(), u);
            // The contact surely moves, and `u*` may lie on the boundary of the dual cone: it need not separate.
            set.alpha * square(u) > T::literal(16.0) * bound && set.alpha * margin * margin < bound
        })
    }
}

/// The motion of contacts, to be compared with impulses. All are squares (N²·s²).
struct Motion<T> {
    /// `Σ |alpha_i u_i|²`
    moved: T,
    /// The expected size of the impulses.
    expected: T,
    /// The size of the impulses, at least the expected one.
    size: T,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Monitor<'_, '_, T, N, D, C, R, S>
{
    /// Opens the rest question as `question`: the relaxation is solved from now on.
    pub(super) fn open_rest_question(&mut self, question: RestQuestion) {
        self.record.rest = question;
        self.problem.set_shift(false);
    }

    /// Does the last solution solve the scene, but move loaded contacts?
    pub(super) fn creeps(&self, point: &NewtonPoint<T, D, C, R>) -> bool {
        let share = self.tolerance() * T::literal(CREEPS);
        self.record.status == Status::Solved && self.problem.loaded_contacts_move(&point.r, &point.u, share)
    }

    /// Returns true, and opens the rest question, if all bodies were at rest and the solution does not solve the relaxation.
    pub(super) fn leaves_rest(&mut self, point: &NewtonPoint<T, D, C, R>) -> bool {
        if self.record.rest != RestQuestion::Pending || self.record.status != Status::Solved {
            return false;
        }
        self.record.rest = RestQuestion::Closed;
        let limit = self.tolerance() * T::literal(LEAVES);
        if self.problem.hardly_moves(point, limit) {
            return false;
        }
        self.problem.set_shift(false);
        let relaxed = self.problem.error_estimate(&point.r, &point.u);
        self.problem.set_shift(true);
        let leaves = relaxed > limit;
        if leaves {
            self.record.status = Status::Unsolved;
            self.open_rest_question(RestQuestion::OpenWithSolution);
        }
        leaves
    }

    /// Considers a point while the relaxation is solved. If both estimates are within the tolerance,
    /// by the relaxation and by Coulomb's law, a [check](Self::judge_rest) of the error is due.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn consider_rest(&mut self, point: &NewtonPoint<T, D, C, R>) {
        let tolerance = self.tolerance();
        let is_centring = self.record.rest == RestQuestion::Centring;
        let is_farther_inside =
            || self.problem.cone_margin(&point.r) > self.problem.cone_margin(&self.record.best);
        if point.estimate > tolerance || is_centring && !is_farther_inside() {
            return;
        }
        if self.coulomb_estimate(point) <= tolerance {
            self.record.check = Check::Error;
        }
    }

    /// The estimate by Coulomb's law, while the relaxation is solved.
    fn coulomb_estimate(&mut self, point: &NewtonPoint<T, D, C, R>) -> T {
        self.problem.set_shift(true);
        let estimate = self.problem.error_estimate(&point.r, &point.u);
        self.problem.set_shift(false);
        estimate
    }

    /// Checks the error of a point that was [considered](Self::consider_rest), and keeps its impulses if they solve Coulomb's law.
    ///
    /// Ends the solve if they are much more exact than the tolerance, or if the relaxation is solved exactly. Otherwise the
    /// search goes on: the error of a tick must not carry a body that is at the limit of its friction beyond that limit.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn judge_rest(&mut self, point: &NewtonPoint<T, D, C, R>) {
        let estimate = self.coulomb_estimate(point);
        self.problem.set_shift(true);
        let exactly = self.record.check == Check::ExactError;
        let is_solved = self.evaluate(&point.r, exactly)
            && self.solution.has_numbers()
            && !self.must_refuse_solution(&point.r, &point.u);
        let check = mem::replace(&mut self.record.check, Check::None);
        if is_solved {
            self.record.best = point.r;
            self.record.best_estimate = Some(estimate);
            if self.record.rest != RestQuestion::Centring {
                self.record.rest = RestQuestion::OpenWithSolution;
            }
            let answered = self.tolerance() * T::literal(ANSWERED);
            if estimate <= answered || self.is_exact(point) {
                self.record.rest = RestQuestion::Closed;
                self.stop(Status::Solved);
                return;
            }
        } else if check == Check::Error {
            self.record.check = Check::ExactError;
        }
        self.problem.set_shift(false);
    }

    /// Begins to look for impulses farther inside the cones than those of the last solution, which solves the scene.
    pub(super) fn begin_centring(&mut self) {
        self.record.status = Status::Unsolved;
        self.open_rest_question(RestQuestion::Centring);
    }

    /// Is the relaxation solved to much less than the tolerance?
    fn is_exact(&self, point: &NewtonPoint<T, D, C, R>) -> bool {
        point.estimate <= self.tolerance() * T::literal(EXACT)
    }

    /// Is it known that not all bodies can stay? Either the relaxation is solved exactly without a solution of Coulomb's law, or the duality
    /// gap proves that a contact moves, which probably slides.
    pub(super) fn cannot_rest(&self, point: &NewtonPoint<T, D, C, R>) -> bool {
        self.is_exact(point) || self.problem.must_slide(&point.r, &point.u)
    }

    /// Closes the rest question. If a solution is known, writes it, ends the solve, and returns its impulses.
    pub(super) fn close_rest_question(&mut self) -> Option<Stacked<T, D, C, R>> {
        let has_fallback = self.record.has_fallback();
        self.record.rest = RestQuestion::Closed;
        self.record.check = Check::None;
        self.problem.set_shift(true);
        if has_fallback {
            let (best, tolerance) = (self.record.best, self.tolerance());
            self.problem.evaluate(&best, (tolerance, true), self.solution);
            self.stop(Status::Solved);
        }
        has_fallback.then_some(self.record.best)
    }
}
