//! The check of the error of impulses: whether they solve the scene, and what follows if they do not. Impulses far above the expected size
//! are doubted, whatever their error.

use crate::linalg::stacked::Stacked;
use crate::real::Real;
use crate::solution::Status;
use crate::solver::monitor::Monitor;
use crate::solver::phases::Phases;
use crate::solver::record::{Check, Measure};
use core::mem;

/// Work that an error with twice the digits takes from the budget. A check in vain takes as much: if the solution is refused, or if a solver
/// without such errors misses the tolerance.
const EXACT_ERROR: usize = 20;

/// Impulses above this many times the expected size are doubtful: walls may then close by a tenth of what is asked at an error of a hundredth.
/// (With a fifth of it, solved impacts would be searched for a proof; with ten times as much, slow walls would count as solved.)
pub(super) const DOUBTFUL_IMPULSE_RATIO: f64 = 10.0;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Monitor<'_, '_, T, N, D, C, R, S>
{
    /// Checks the error of impulses, the last that [`Self::consider`] saw. Ends the solve if they solve the scene.
    ///
    /// If the error exceeds the tolerance, sweeps alone go on. For other phases a check with twice the digits is due. If that error exceeds
    /// the tolerance, too, `H v + w` and `W r + q` differ by rounding. The difference is then added to the constant terms of the velocities,
    /// and the search continues (iterative refinement).
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn check<P: Phases>(&mut self, r: &Stacked<T, D, C, R>, u: &Stacked<T, D, C, R>) {
        let exactly = P::EXACT_ERRORS && self.record.check == Check::ExactError;
        let mut is_solved = self.evaluate(r, exactly);
        if !is_solved && !self.problem.counts_stopping {
            self.count_stopping();
            is_solved = self.evaluate(r, exactly);
        }
        let check = mem::replace(&mut self.record.check, Check::None);
        if is_solved && self.must_refuse_solution(r, u) {
            self.record.has_doubted = true;
            self.charge(EXACT_ERROR); // or each piece might be checked in vain
        } else if is_solved {
            self.record.best = *r;
            self.stop(if self.has_numbers(r) {
                Status::Solved
            } else {
                Status::PrecisionLimit // squares overflow
            });
        } else {
            self.keep(r, u, (self.solution.error, Measure::Error));
            self.holds_best = !exactly && self.record.best == *r;
            if !P::EXACT_ERRORS {
                self.charge(EXACT_ERROR);
            } else if check == Check::Error {
                // The estimate that asked for the check may be that of a sweep, without the natural map.
                if self.problem.error_estimate(r, u) <= self.settings.tolerance {
                    self.record.check = Check::ExactError;
                }
            } else {
                self.correct_velocities(r);
            }
        }
    }

    /// Takes work from the budget of the call.
    pub(super) fn charge(&mut self, work: usize) {
        self.work_limit = self.work_limit.saturating_sub(work);
    }

    /// Are the solution that is written, of these impulses, and their square finite?
    pub(super) fn has_numbers(&self, r: &Stacked<T, D, C, R>) -> bool {
        self.solution.has_numbers() && self.problem.sets.contact_square(r).is_finite()
    }

    /// Ends the solve if the best impulses solve the scene although their estimate is above the tolerance: it may be that of rounding.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn check_best(&mut self) {
        let Some(&r) = self.best() else { return };
        let mut u = Stacked::zero();
        if self.evaluate(&r, false) && self.has_numbers(&r) {
            self.problem.velocities(&r, &mut u);
            if !self.must_refuse_solution(&r, &u) {
                self.stop(Status::Solved);
            }
        }
    }

    /// Writes the solution of impulses, with its error, in twice the digits if that is asked. Returns true if the error is within the
    /// tolerance.
    pub(super) fn evaluate(&mut self, r: &Stacked<T, D, C, R>, exactly: bool) -> bool {
        let tolerance = self.settings.tolerance;
        if exactly {
            self.charge(EXACT_ERROR);
        }
        self.holds_best = false;
        let wanted = (tolerance, exactly);
        self.problem.evaluate(r, wanted, self.solution);
        self.solution.error <= tolerance
    }

    /// Are impulses more than 10 times as large as expected?
    pub(super) fn is_doubtful(&self, r: &Stacked<T, D, C, R>) -> bool {
        self.problem.exceeds(r, T::literal(DOUBTFUL_IMPULSE_RATIO))
    }

    /// Are these impulses doubtful, and do they throw a body or let walls close?
    pub(super) fn is_absurd(&self, r: &Stacked<T, D, C, R>, u: &Stacked<T, D, C, R>) -> bool {
        self.is_doubtful(r) && (self.problem.throws(r, u) || self.problem.lets_walls_close(u))
    }

    /// Must the impulses of the solution be refused, whatever their error: are they doubtful, and do they let walls close or squeeze?
    pub(super) fn must_refuse_solution(&self, r: &Stacked<T, D, C, R>, u: &Stacked<T, D, C, R>) -> bool {
        self.is_doubtful(r) && (self.problem.lets_walls_close(u) || self.problem.squeezes(r, self.solution))
    }
}
