//! The central path: an interior-point method for a smoothed Coulomb law. It follows a rejected Newton step of a cold start
//! ([`crate::guide::method`]).
//!
//! With `r = Λ x`, `y = Λ u`, `Λ = diag(1, mu, ..., mu)` and `e = (1, 0, ..., 0)` the central path is
//!
//! `y_N x_N = tau`, `(x_N, x_T) ∘ (s, y_T) = beta tau e`, `y = Λ W Λ x + Λ q`, `tau -> 0`
//!
//! `∘` is the Jordan product, and `s` an extra unknown with `s >= |y_T|`. In other words `u_N = tau / r_N` and
//! `y_T = -beta tau x_T / det x`: Coulomb's law, smoothed, without the De Saxcé shift. The equations are linear except for the two bilinear
//! products, so Mehrotra's corrector is exact to second order. Hyperstatic impulses stay in the interior of their cones. (In the convex
//! relaxation `s` is `y_N`.) A *pair* is `x` and `(s, y_T)` of one contact.
//!
//! Coulomb's law is not monotone: the path can have folds. If a path *jams* (its steps become short), sweeps lead away, and another path
//! begins with another weight `beta`. Every path that reaches `tau = 0` ends at a solution. (A path that jams has nothing to do with a
//! scene that is jammed by friction, [`crate::Status::Jammed`].)

use crate::real::Real;
use crate::sets::pairs::{Pairs, mean_energy};
use crate::sets::path_system::PathSystem;
use crate::solver::phases::Phases;
use crate::solver::solve::Solve;
use crate::solver::state::{Failure, Newton, Next, Phase, Sweeps};
use crate::solver::tuning;
use core::mem;

/// Fall of the merit after which Newton's method tries again to finish a path. The merit is a square: the residual has halved.
const FALL: f64 = 4.0;

/// [`FALL`] while the [rest question](super::rest) is open: the residual has fallen to a hundredth. Contacts that hardly push make Newton's
/// method fail there each time.
const FALL_AT_REST: f64 = 1e4;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize, P: Phases>
    Solve<'_, '_, T, N, D, C, R, S, P>
{
    /// Begins the central path near the impulses of the point, with a `tau` of 10 times the mean of `alpha |q|²`, or less if the error of
    /// the point is small.
    pub(super) fn begin_path(&mut self) -> Phase {
        self.state.path.jams = 0;
        // A solution that slides is far from one that rests.
        let is_near = !self.monitor.problem.is_relaxed();
        let share = if is_near { self.state.point.estimate * tuning::tau_share() } else { T::ONE };
        self.enter_path(self.far_tau() * share.min(T::ONE), tuning::first_gain(), T::ONE);
        self.back_to_path();
        Phase::CentralPath
    }

    /// Sets the pairs to those of a central path near the impulses and `u` of the point.
    fn enter_path(&mut self, tau: T, gain: T, beta: T) {
        self.state.path.beta = beta;
        self.state.path.tau = tau;
        self.state.path.steps = 0;
        self.state.path.tried = None;
        let (r, u) = (&self.state.point.r, &self.state.point.u);
        let pairs = &mut self.state.path.pairs;
        pairs.enter(&self.monitor.problem.sets, (r, u), tau, gain, beta);
    }

    /// Moves the point to the impulses of the pairs.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn back_to_path(&mut self) {
        let sets = &self.monitor.problem.sets;
        self.state.path.pairs.impulses(sets, &mut self.state.point.r);
        self.evaluate_impulses();
    }

    /// Makes a step along the central path.
    #[inline(never)]
    pub(super) fn path_step(&mut self) -> Next {
        self.monitor.solution.work.newton_steps += 1;
        let length = self.move_pairs();
        self.state.path.is_stuck = length.is_none_or(|length| length < tuning::jammed());
        let tau = self.state.path.pairs.tau(self.state.path.beta);
        if tau.is_finite() {
            self.state.path.tau = tau;
        }
        self.state.path.steps += 1;
        self.back_to_path();
        self.consider();
        if self.monitor.must_return() {
            return Ok(Phase::CentralPath);
        }
        self.progress()
    }

    /// What follows a step that did not solve the scene: Newton's method, if it may finish from the point.
    #[inline(never)]
    pub(super) fn progress(&mut self) -> Next {
        if self.state.point.estimate < tuning::near() {
            self.rebuild_from_velocity();
            let (merit, tried) = (self.state.point.merit, self.state.path.tried);
            let fall = if self.monitor.problem.is_relaxed() { FALL_AT_REST } else { FALL };
            if tried.is_none_or(|tried| merit * T::literal(fall) < tried) {
                self.state.path.tried = Some(merit);
                return Ok(Phase::Newton(Newton::finish()));
            }
            self.back_to_path();
        }
        if self.state.path.is_stuck || self.state.path.steps >= tuning::longest_path() {
            Err(Failure::Jammed)
        } else {
            Ok(Phase::CentralPath)
        }
    }

    /// Moves the pairs by a step of Mehrotra's predictor-corrector method. Returns its length; `None` if the system is singular.
    #[inline(never)]
    fn move_pairs(&mut self) -> Option<T> {
        self.state.forget();
        let (matrix, elimination) = (&mut self.state.matrix, &mut self.state.jacobian.elimination);
        let (pairs, beta) = (&self.state.path.pairs, self.state.path.beta);
        let (sets, delassus) = (&self.monitor.problem.sets, self.monitor.problem.factor.delassus());
        let u = &self.state.point.u;
        let mut system = PathSystem::new(sets, pairs, u, matrix, elimination);
        system.factorise(sets, delassus)?;
        // Share of the way to the boundary of the cones.
        let fraction = T::ONE - tuning::margin::<T>();
        let limit = T::ONE / fraction;
        let (mut step, mut corrected) = (Pairs::none(), Pairs::none());
        system.predict(&mut step)?;
        let remainder = T::ONE - pairs.max_step(&step, limit).min(T::ONE);
        let goal = (remainder * remainder * remainder * self.state.path.tau, beta);
        system.correct(&step, goal, &mut corrected)?;
        let mut longest = pairs.max_step(&corrected, limit);
        if longest < tuning::correct_again() {
            system.correct(&corrected, goal, &mut step)?;
            let farther = pairs.max_step(&step, limit);
            if farther > longest {
                (corrected, longest) = (step, farther);
            }
        }
        let length = (fraction * longest).min(T::ONE);
        self.state.path.pairs.advance(&corrected, length);
        Some(length)
    }

    /// Leaves a jam by some sweeps, and begins another central path, or Newton's method if it may finish from the point after the sweeps.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn leave_jam(&mut self) -> Phase {
        self.monitor.note_failure();
        let tau = self.state.path.tau;
        let jams = self.state.path.jams;
        self.state.path.jams = jams.wrapping_add(1);
        let has_merged = jams.is_multiple_of(2) && self.merge_contacts();
        self.evaluate_impulses();
        if !self.state.point.estimate.is_finite() {
            self.set_zero_impulse();
        }
        if self.monitor.problem.can_be_swept() {
            self.state.sweeps = Sweeps::none();
            let sweeps = if has_merged { tuning::sweeps() } else { tuning::sweeps_at_jam() };
            for _ in 0..sweeps {
                self.sweep_once();
            }
        }
        // `map` lets the compiler round the constants.
        let value = |values: &[T]| {
            let value = values.get(jams % values.len().max(1));
            value.copied().unwrap_or(T::ONE)
        };
        // `tau` rises with each round of weights, so that no path repeats an earlier one.
        let round = T::count(1 + jams.div_euclid(tuning::WEIGHTS.len()));
        let mut raised = tau * tuning::tau_raise() * round;
        if jams == 0 {
            raised = raised.max(self.far_tau()); // the first path may have begun too near its end
        }
        if jams == tuning::jams_to_farthest() {
            self.enter_path(self.far_tau() / T::EPSILON.square_root(), tuning::first_gain(), T::ONE);
        } else {
            let (gain, beta) = (tuning::GAINS.map(T::literal), tuning::WEIGHTS.map(T::literal));
            self.enter_path(raised, value(&gain), value(&beta));
        }
        self.evaluate_impulses();
        self.consider();
        if has_merged || self.state.point.estimate < tuning::near() || self.monitor.must_return() {
            self.rebuild_from_velocity();
            return Phase::Newton(Newton::finish());
        }
        self.back_to_path();
        Phase::CentralPath
    }

    /// Moves the impulse of each contact that is nearly the same as another one with more friction to that one. Returns false if there is none.
    ///
    /// A path shares the load between such contacts, and jams where one of them alone has to bear it.
    #[inline(never)]
    fn merge_contacts(&mut self) -> bool {
        let problem = &*self.monitor.problem;
        let (delassus, sets) = (problem.factor.delassus(), problem.sets.contacts());
        let r = &mut self.state.point.r.contacts;
        let mut has_merged = false;
        for i in 0..sets.len() {
            // Of contacts with the same friction the first one bears.
            let rank = |k: usize| sets.get(k).map(|set| (set.cone.friction(), sets.len() - k));
            let better = (0..sets.len()).find(|&j| rank(j) > rank(i) && delassus.are_nearly_one(i, j));
            if let Some(j) = better
                && let Ok([from, to]) = r.get_disjoint_mut([i, j])
                && *from != [T::ZERO; D]
            {
                for (from, to) in from.iter_mut().zip(to) {
                    *to += mem::replace(from, T::ZERO);
                }
                has_merged = true;
            }
        }
        has_merged
    }

    /// The `tau` of a path that begins far from a solution.
    fn far_tau(&self) -> T {
        mean_energy(&self.monitor.problem.sets) * tuning::first_tau()
    }
}
