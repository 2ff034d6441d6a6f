//! Evaluation of a [`NewtonPoint`] (`src/sets/point.rs`): the `z` of Newton's method, and the impulses, velocities, residual and
//! merit that follow from it.

use crate::linalg::stacked::Stacked;
use crate::linalg::vector::quotient;
use crate::problem::Problem;
use crate::real::Real;
pub(crate) use crate::sets::point::NewtonPoint;

impl<T: Real, const D: usize, const C: usize, const R: usize> NewtonPoint<T, D, C, R> {
    /// Sets `r` and `P` to 0, the start of cold sweeps. A joint row whose interval does not contain 0 gets the impulse nearest to 0. `z`,
    /// residual and merit are stale until [`Self::rebuild`].
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn set_zero_impulse<const N: usize, const S: usize>(
        &mut self,
        problem: &Problem<'_, T, N, D, C, R, S>,
    ) {
        (self.p, self.r) = (Stacked::zero(), Stacked::zero());
        for (r, set) in self.r.rows.iter_mut().zip(problem.sets.rows()) {
            *r = set.project(T::ZERO);
        }
        problem.velocities_of_least(&self.r, &mut self.u);
        self.estimate = if problem.scene.is_mixed() {
            problem.error_estimate(&self.r, &self.u)
        } else {
            quotient(problem.r0_norm, problem.expected_size)
        };
    }

    /// Computes velocities and estimate of the impulses.
    #[inline]
    pub(crate) fn evaluate_impulses<const N: usize, const S: usize>(
        &mut self,
        problem: &Problem<'_, T, N, D, C, R, S>,
    ) {
        self.estimate = problem.velocities_and_estimate(&self.r, &mut self.u);
    }

    /// Computes `z_i = P_i - r_i / alpha_i` from `P` and `r`, and evaluates it.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn rebuild<const N: usize, const S: usize>(
        &mut self,
        problem: &Problem<'_, T, N, D, C, R, S>,
    ) {
        problem.sets.join(&self.p, &self.r, &mut self.z);
        self.update(problem);
    }

    /// Computes `z_i = û_i - r_i / alpha_i` from `u` and `r`, and evaluates it.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn rebuild_from_velocity<const N: usize, const S: usize>(
        &mut self,
        problem: &Problem<'_, T, N, D, C, R, S>,
    ) {
        problem.sets.augment(&self.u, &mut self.p);
        self.rebuild(problem);
    }

    /// Evaluates `z`: computes `P`, `r`, `u`, residual, merit and estimate.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn update<const N: usize, const S: usize>(&mut self, problem: &Problem<'_, T, N, D, C, R, S>) {
        let sets = &problem.sets;
        sets.split(&self.z, &mut self.p, &mut self.r, &mut self.residual);
        self.evaluate_impulses(problem);
        let counts = sets.counts();
        let velocities = self.u.in_use(counts);
        for (residual, &u) in self.residual.in_use_mut(counts).zip(velocities) {
            *residual += u;
        }
        self.merit = sets.merit(&self.residual);
    }
}
