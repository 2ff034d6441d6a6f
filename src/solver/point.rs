//! How a point of Newton's method is evaluated.

use crate::linalg::stacked::Stacked;
use crate::linalg::vector::quotient;
use crate::problem::Problem;
use crate::real::Real;
pub(crate) use crate::sets::point::NewtonPoint;

impl<T: Real, const D: usize, const C: usize, const R: usize> NewtonPoint<T, D, C, R> {
    /// Sets `r = 0` and `P = 0`, from where sweeps set off; `z`, residual and merit are stale until [`Self::rebuild`]. Joint rows
    /// whose bounds leave out 0 have the nearest impulse.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn set_zero_impulse<const N: usize, const S: usize>(
        &mut self,
        problem: &Problem<'_, T, N, D, C, R, S>,
    ) {
        (self.p, self.r) = (Stacked::zero(), Stacked::zero());
        for (r, set) in self.r.rows.iter_mut().zip(problem.sets.rows()) {
            *r = set.project(T::ZERO);
        }
        problem.velocities_at_rest(&self.r, &mut self.u);
        self.estimate = if problem.scene.is_mixed() {
            problem.error_estimate(&self.r, &self.u)
        } else {
            quotient(problem.r0_norm, problem.reference_impulse)
        };
    }

    /// Moves to `z_i = P_i - r_i / rho_i` of its own `P` and `r`, with `rho_i = alpha_i`.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn rebuild<const N: usize, const S: usize>(
        &mut self,
        problem: &Problem<'_, T, N, D, C, R, S>,
    ) {
        problem.sets.join(&self.p, &self.r, &mut self.z);
        self.update(problem);
    }

    /// Moves to `z_i = û_i - r_i / rho_i` of its own `r` and `u`.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn rebuild_from_velocity<const N: usize, const S: usize>(
        &mut self,
        problem: &Problem<'_, T, N, D, C, R, S>,
    ) {
        problem.sets.augment(&self.u, &mut self.p);
        self.rebuild(problem);
    }

    /// Evaluates what follows from `z`, with `rho_i = alpha_i`.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn update<const N: usize, const S: usize>(
        &mut self,
        problem: &Problem<'_, T, N, D, C, R, S>,
    ) {
        let sets = &problem.sets;
        sets.split(&self.z, &mut self.p, &mut self.r, &mut self.residual);
        self.estimate = problem.velocities_and_estimate(&self.r, &mut self.u);
        let counts = sets.counts();
        let velocities = self.u.in_use(counts);
        for (residual, &u) in self.residual.in_use_mut(counts).zip(velocities) {
            *residual += u;
        }
        self.merit = sets.merit(&self.residual);
    }
}
