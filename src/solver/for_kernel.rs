//! What a [`crate::Kernel`] asks of its solver: about joint limits, the age of its factor, and calls that were refused.

use crate::error::Error;
use crate::problem::{Age, Problem};
use crate::real::Real;
use crate::scene::Scene;
use crate::solution::{Settings, Status};
use crate::solver::Solver;
use crate::solver::phases::Phases;
use crate::solver::record::Call;
use nalgebra::SVector;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, P: Phases>
    Solver<T, N, D, C, R, P>
{
    /// The call that continues a paused solve of this data, or begins one. A paused solve with joint limits is refused.
    pub(crate) fn resumed<const S: usize>(
        &self,
        scene: &Scene<T, N, D, C, R, S>,
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<Call, Error> {
        if self.has_limits() {
            return Err(Error::LimitsLeftOut);
        }
        Ok(self.record.resume(|| Problem::fingerprint(scene, free_impulse, settings)))
    }

    /// Notes that the solve has joint limits, the last rows of the scene, unless it has ended.
    pub(crate) fn note_limits<const S: usize>(&mut self, scene: &Scene<T, N, D, C, R, S>) {
        self.record.note_limits(|| scene.prints_of_rows());
    }

    /// Is a solve with joint limits paused?
    pub(crate) fn has_limits(&self) -> bool {
        self.record.has_limits()
    }

    /// Does the paused solve have this data, with its joint limits as the last rows of the scene?
    pub(crate) fn is_paused_with_limits<const S: usize>(
        &self,
        scene: &Scene<T, N, D, C, R, S>,
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> bool {
        self.record.is_paused(|| Problem::fingerprint(scene, free_impulse, settings) ^ scene.prints_of_rows())
    }

    /// Marks the last solution as unsolved, and forgets its solve.
    pub(crate) fn invalidate(&mut self) {
        self.record.forget();
        self.solution.invalidate();
    }

    /// Gives the solution of a new solver an infinite error, before the first call that may be refused.
    pub(crate) fn invalidate_if_unsolved(&mut self) {
        self.solution.invalidate_if_unsolved();
    }

    /// Notes that the solution violates limits for which there was no room, by this much of the error.
    pub(crate) fn note_left_out(&mut self, error: T) {
        if self.solution.status == Status::Solved {
            self.solution.status = Status::OutOfRows;
        }
        self.solution.error = self.solution.error.max(error);
    }

    /// Sets the age of the factor, for the next solve that begins and those after it.
    pub(crate) const fn set_factor_age(&mut self, age: Age) {
        self.record.factor_age = age;
    }
}
