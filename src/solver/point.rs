//! Evaluation of the point of a solve ([`NewtonPoint`]): the `z` of Newton's method, and the impulses, velocities, residual and merit that
//! follow from it.

use crate::linalg::stacked::Stacked;
use crate::linalg::vector::quotient;
use crate::problem::Problem;
use crate::real::Real;
use crate::sets::point::NewtonPoint;
use crate::solver::phases::Phases;
use crate::solver::solve::Solve;

impl<'a, T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize, P: Phases>
    Solve<'_, 'a, T, N, D, C, R, S, P>
{
    /// The problem, and the point.
    #[inline]
    pub(super) fn problem_and_point(
        &mut self,
    ) -> (&Problem<'a, T, N, D, C, R, S>, &mut NewtonPoint<T, D, C, R>) {
        (self.monitor.problem, &mut self.state.point)
    }

    /// Sets `r` and `P` to 0, the start of cold sweeps. A joint row whose interval does not contain 0 gets the impulse nearest to 0. `z`,
    /// residual and merit are stale until [`Self::rebuild`].
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn set_zero_impulse(&mut self) {
        let (problem, point) = self.problem_and_point();
        (point.p, point.r) = (Stacked::zero(), Stacked::zero());
        for (r, set) in point.r.rows.iter_mut().zip(problem.sets.rows()) {
            *r = set.project(T::ZERO);
        }
        problem.velocities_of_least(&point.r, &mut point.u);
        point.estimate = if problem.scene.is_mixed() {
            problem.error_estimate(&point.r, &point.u)
        } else {
            quotient(problem.r0_norm, problem.expected_size)
        };
    }

    /// Computes velocities and estimate of the impulses.
    #[inline]
    pub(super) fn evaluate_impulses(&mut self) {
        let (problem, point) = self.problem_and_point();
        point.estimate = problem.velocities_and_estimate(&point.r, &mut point.u);
    }

    /// Computes `z_i = P_i - r_i / alpha_i` from `P` and `r`, and evaluates it.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn rebuild(&mut self) {
        let (problem, point) = self.problem_and_point();
        problem.sets.join(&point.p, &point.r, &mut point.z);
        self.evaluate_z();
    }

    /// Computes `z_i = û_i - r_i / alpha_i` from `u` and `r`, and evaluates it.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn rebuild_from_velocity(&mut self) {
        let (problem, point) = self.problem_and_point();
        problem.sets.augment(&point.u, &mut point.p);
        self.rebuild();
    }

    /// Evaluates `z` ([`Problem::evaluate_point`]).
    pub(super) fn evaluate_z(&mut self) {
        let (problem, point) = self.problem_and_point();
        problem.evaluate_point(point);
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Problem<'_, T, N, D, C, R, S>
{
    /// Computes `P`, `r`, `u`, residual, merit and estimate from the `z` of a point.
    pub(crate) fn evaluate_point(&self, point: &mut NewtonPoint<T, D, C, R>) {
        self.sets.split(&point.z, &mut point.p, &mut point.r, &mut point.residual);
        point.estimate = self.velocities_and_estimate(&point.r, &mut point.u);
        let counts = self.sets.counts();
        let velocities = point.u.in_use(counts);
        for (residual, &u) in point.residual.in_use_mut(counts).zip(velocities) {
            *residual += u;
        }
        point.merit = self.sets.merit(&point.residual);
    }
}
