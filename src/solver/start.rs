//! The start of a solve from the last solution ([`crate::guide::method`]).

use crate::linalg::stacked::Stacked;
use crate::real::Real;
use crate::solution::Model;
use crate::solver::phases::Phases;
use crate::solver::solve::Solve;
use crate::solver::warm_start::WarmStartKind;

/// Impulses more than this many times the expected size are no start.
const MAX_IMPULSE_RATIO: f64 = 1e8;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize, P: Phases>
    Solve<'_, '_, T, N, D, C, R, S, P>
{
    /// Moves the point to the last solution if its estimate now is less than that of zero impulses, otherwise to zero impulses.
    /// (Estimates are relative to the impulses, so huge impulses are no start.)
    ///
    /// Unique impulses are extrapolated in the first call of a tick. Hyperstatic impulses are not: they can change without
    /// moving a body, and would reach the boundaries of their cones tick by tick.
    pub(super) fn go_to_start(&mut self) -> WarmStartKind {
        if let Some(earlier_indices) = self.warm_start.follow(self.monitor.problem.scene) {
            self.state.jacobian.follow(&earlier_indices);
        }
        self.set_zero_impulse();
        let rest = self.state.point.estimate;
        if !self.warm_start.is_cold() && rest > self.monitor.tolerance() {
            self.go_to_last_impulses(false);
            let (problem, point) = self.problem_and_point();
            let unique =
                problem.can_be_swept() && !problem.is_hyperstatic(&point.r, problem.sets.free_rows(&point.r));
            if unique && self.monitor.is_first_call() {
                self.extrapolate();
            } else if unique || !P::NEWTON {
                self.evaluate_impulses();
            } else {
                self.choose_hyperstatic();
            }
            let (problem, point) = self.problem_and_point();
            if point.estimate < rest && !problem.exceeds(&point.r, T::literal(MAX_IMPULSE_RATIO)) {
                return if unique { WarmStartKind::Isostatic } else { WarmStartKind::Hyperstatic };
            }
            self.set_zero_impulse();
        }
        WarmStartKind::None
    }

    /// Sets `r` to the last impulses, or the extrapolated ones if `onwards`, projected onto their cones and intervals.
    #[cfg_attr(target_os = "none", inline(never))]
    fn go_to_last_impulses(&mut self, onwards: bool) {
        let (problem, r) = (&*self.monitor.problem, &mut self.state.point.r);
        self.warm_start.impulses(problem.scene, onwards, r);
        problem.sets.project(r);
    }

    /// Extrapolates the impulses of the point. If the estimates of the extrapolated and of the last impulses are both within the tolerance,
    /// keeps the last: a body at rest must not drift with the errors of its impulses.
    fn extrapolate(&mut self) {
        let (r, mut u) = (self.state.point.r, Stacked::zero());
        self.go_to_last_impulses(true);
        self.evaluate_impulses();
        let tolerance = self.monitor.tolerance();
        if self.state.point.estimate <= tolerance {
            let (problem, point) = self.problem_and_point();
            let last = problem.velocities_and_estimate(&r, &mut u);
            if last <= tolerance {
                (point.r, point.u, point.estimate) = (r, u, last);
            }
        }
    }

    /// Moves the point from the last impulses to the better of two `z`: `û - r / alpha` with the last impulses and the velocities that they
    /// cause now, or the last `z`.
    ///
    /// The estimate decides. (The merit is a poor measure: if a heavy body stands on a light one, it sees only the light one.)
    fn choose_hyperstatic(&mut self) {
        let (r, mut u) = (self.state.point.r, Stacked::zero());
        let last = self.monitor.problem.velocities_and_estimate(&r, &mut u);
        let mut of_last_z = None;
        if last > self.monitor.tolerance() && self.warm_start.is_a_solution() {
            self.go_to_last_z();
            of_last_z = Some(self.state.point.estimate);
        }
        if of_last_z.is_none_or(|estimate| estimate * T::literal(3.0) > last) {
            let (problem, point) = self.problem_and_point();
            (point.r, point.u, point.estimate) = (r, u, last);
            problem.sets.augment(&u, &mut point.p);
            if let Some(estimate) = of_last_z {
                self.rebuild();
                if estimate < self.state.point.estimate {
                    self.go_to_last_z();
                }
            }
        }
    }

    /// Moves the point to the last `z = ũ - r / alpha`.
    #[cfg_attr(target_os = "none", inline(never))]
    fn go_to_last_z(&mut self) {
        let point = &mut self.state.point;
        self.warm_start.recall(self.monitor.problem.scene, &mut point.p, &mut point.r);
        self.rebuild();
    }

    /// Was the last solution at rest: did its loaded contacts move by at most 8 tolerances?
    pub(super) fn was_at_rest(&self) -> bool {
        let problem = &*self.monitor.problem;
        let [mut u, mut r] = [Stacked::zero(); 2];
        self.warm_start.recall(problem.scene, &mut u, &mut r);
        let share = self.monitor.tolerance() * T::literal(8.0);
        let stayed = || self.warm_start.has_contact_pushed() && !problem.loaded_contacts_move(&r, &u, share);
        problem.model == Model::Coulomb && (self.warm_start.presumes_rest || stayed())
    }
}
