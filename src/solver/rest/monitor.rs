//! The monitor while [the rest question](super) is open: a point is an answer if it solves the relaxation and Coulomb's law.

use crate::real::Real;
use crate::sets::point::NewtonPoint;
use crate::solution::{Model, Status};
use crate::solver::monitor::Monitor;
use crate::solver::record::{Check, RestQuestion};
use core::mem;

/// A solution leaves a rest if its estimate by the relaxation exceeds this share of the tolerance.
const LEAVES: f64 = 0.25;

/// A body creeps if its loaded contacts move by more than this many tolerances.
const CREEPS: f64 = 2.0;

/// A solution at rest closes the question if its estimate is at most this share of the tolerance.
const ANSWERED: f64 = 0.125;

/// After a jam the answer is no if the estimate by the relaxation is below this share of that by Coulomb's law.
const CLEAR: f64 = 0.05;

/// The relaxation counts as solved exactly if its estimate is at most this share of the tolerance.
const EXACT: f64 = 1.0 / 64.0;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Monitor<'_, '_, T, N, D, C, R, S>
{
    /// Opens the rest question as `question`: the relaxation is solved from now on.
    pub(super) fn open_rest_question(&mut self, question: RestQuestion) {
        self.record.rest = question;
        self.problem.set_law(Model::ConvexRelaxation);
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
        self.record.rest = RestQuestion::Answered;
        let limit = self.tolerance() * T::literal(LEAVES);
        if self.problem.hardly_moves(point, limit) {
            return false;
        }
        let relaxed = self.problem.estimate_by(Model::ConvexRelaxation, &point.r, &point.u);
        let leaves = relaxed > limit;
        if leaves {
            self.record.status = Status::Unsolved;
            self.open_rest_question(RestQuestion::OpenWithSolution);
        }
        leaves
    }

    /// Considers a point while the relaxation is solved. If both estimates are within the tolerance,
    /// by the relaxation and by Coulomb's law, a [check](Self::check_rest) of the error is due.
    pub(in crate::solver) fn consider_rest(&mut self, point: &NewtonPoint<T, D, C, R>) {
        let tolerance = self.tolerance();
        let is_centring = self.record.rest == RestQuestion::Centring;
        let is_farther_inside =
            || self.problem.cone_margin(&point.r) > self.problem.cone_margin(&self.record.best);
        if point.estimate > tolerance || is_centring && !is_farther_inside() {
            return;
        }
        if self.problem.estimate_by(Model::Coulomb, &point.r, &point.u) <= tolerance {
            self.record.check = Check::Error;
        }
    }

    /// Checks the error of a point that was [considered](Self::consider_rest), and keeps its impulses if they solve Coulomb's law.
    ///
    /// Ends the solve if they are much more exact than the tolerance, or if the relaxation is solved exactly. Otherwise the
    /// search goes on. A body at the limit of its friction could slide from the error of a tick alone.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(in crate::solver) fn check_rest(&mut self, point: &NewtonPoint<T, D, C, R>) {
        self.problem.set_law(Model::Coulomb);
        let estimate = self.problem.error_estimate(&point.r, &point.u);
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
                self.record.rest = RestQuestion::Answered;
                self.stop(Status::Solved);
                return;
            }
        } else if check == Check::Error {
            self.record.check = Check::ExactError;
        }
        self.problem.set_law(Model::ConvexRelaxation);
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
    pub(super) fn cannot_rest(&mut self, point: &NewtonPoint<T, D, C, R>) -> bool {
        let has_jammed = self.record.rest == RestQuestion::OpenAfterJam;
        let share = T::literal(CLEAR);
        has_jammed && point.estimate < share * self.problem.estimate_by(Model::Coulomb, &point.r, &point.u)
            || self.is_exact(point)
            || self.problem.must_slide(&point.r, &point.u)
    }

    /// Closes the rest question. If a solution is known, writes it, ends the solve, and returns true.
    pub(super) fn close_rest_question(&mut self) -> bool {
        let has_fallback = self.record.has_fallback();
        self.record.rest = RestQuestion::Answered;
        self.record.check = Check::None;
        self.problem.set_law(Model::Coulomb);
        if has_fallback {
            let wanted = (self.tolerance(), true);
            self.problem.evaluate(&self.record.best, wanted, self.solution);
            self.stop(Status::Solved);
        }
        has_fallback
    }
}
