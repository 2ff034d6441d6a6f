//! The central path of a smoothed Coulomb law, an interior-point method: what follows a rejected Newton step of a cold start.
//!
//! With `r = Λ x`, `y = Λ u`, `Λ = diag(1, mu, ..., mu)` and `e = (1, 0, ..., 0)` the central path is
//!
//! `y_N x_N = tau`, `(x_N, x_T) ∘ (s, y_T) = beta tau e`, `y = Λ W Λ x + Λ q`, `tau -> 0`
//!
//! where `s` is an extra unknown with `s >= |y_T|`. That is `u_N = tau / r_N` and `y_T = -beta tau x_T / det x`: Coulomb's
//! law, smoothed, without the De Saxcé shift. The equations are linear but for the two bilinear products, so that
//! Mehrotra's corrector is exact to second order. Hyperstatic impulses stay in the interior of their cones. (In the convex
//! relaxation `s` is `y_N`.) The field `dual` of a pair is `(s, y_T)`.
//!
//! Coulomb's law is not monotone: the path can have folds. If it jams, sweeps lead away, and another path is entered, with
//! another weight `beta`. Every path that reaches `tau = 0` ends at a solution.

use crate::real::Real;
use crate::sets::pairs::{Pairs, mean_energy};
use crate::sets::path_system::PathSystem;
use crate::solver::monitor::Monitor;
use crate::solver::state::{State, Sweeps};
use crate::solver::tuning;

/// Newton's method tries to finish a path again once the merit, a square, is smaller by this factor: at half the residual.
const FALL: f64 = 4.0;

/// The same where it is asked whether all can stay, a hundredth: what hardly pushes there fails each time.
const FALL_AT_REST: f64 = 1e4;

/// What came of a step.
#[derive(Clone, Copy)]
pub(super) enum Progress {
    /// There are more to come.
    Far,
    /// Newton's method may finish from the point.
    Near,
    /// The path leads nowhere from here.
    Jammed,
}

impl<T: Real, const D: usize, const C: usize, const R: usize> State<T, D, C, R> {
    /// Begins the interior-point method at the impulses of the point.
    ///
    /// `tau` starts at 10 times the mean of `alpha |q|²`.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn begin_path<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) {
        self.path.jams = 0;
        let tau = mean_energy(&monitor.problem.sets) * tuning::first_tau();
        self.enter_path(monitor, tau, tuning::first_gain(), T::ONE);
        self.back_to_path(monitor);
    }

    /// Pairs of a central path near the impulses and `u` of the point.
    #[cfg_attr(target_os = "none", inline(never))]
    fn enter_path<const N: usize, const S: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
        tau: T,
        gain: T,
        beta: T,
    ) {
        self.path.beta = beta;
        self.path.tau = tau;
        self.path.steps = 0;
        self.path.tried = None;
        let (r, u) = (&self.point.r, &self.point.u);
        let pairs = &mut self.path.pairs;
        pairs.enter(&monitor.problem.sets, (r, u), tau, gain, beta);
    }

    /// Moves the point to the impulses of the pairs.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn back_to_path<const N: usize, const S: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
    ) {
        let sets = &monitor.problem.sets;
        self.path.pairs.impulses(sets, &mut self.point.r);
        let (r, u) = (&self.point.r, &mut self.point.u);
        self.point.estimate = monitor.problem.velocities_and_estimate(r, u);
    }

    /// A step along the central path.
    #[inline(never)]
    pub(super) fn path_step<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) -> Progress {
        monitor.solution.work.newton_steps += 1;
        let length = self.move_pairs(monitor);
        self.path.is_stuck = length.is_none_or(|length| length < tuning::jammed());
        let tau = self.path.pairs.tau(self.path.beta);
        if tau.is_finite() {
            self.path.tau = tau;
        }
        self.path.steps += 1;
        self.back_to_path(monitor);
        self.consider_answer(monitor);
        if monitor.waits() {
            return Progress::Far;
        }
        self.progress(monitor)
    }

    /// What came of a step that does not solve the problem.
    #[inline(never)]
    pub(super) fn progress<const N: usize, const S: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
    ) -> Progress {
        if self.point.estimate < tuning::near() {
            self.point.rebuild_from_velocity(monitor.problem);
            let (merit, tried) = (self.point.merit, self.path.tried);
            let fall = if monitor.record.asks_for_rest() {
                FALL_AT_REST
            } else {
                FALL
            };
            if tried.is_none_or(|tried| merit * T::literal(fall) < tried) {
                self.path.tried = Some(merit);
                return Progress::Near;
            }
            self.back_to_path(monitor);
        }
        if self.path.is_stuck || self.path.steps >= tuning::longest_path() {
            Progress::Jammed
        } else {
            Progress::Far
        }
    }

    /// Moves the pairs by a step of Mehrotra's predictor-corrector method. Returns its length; `None` if there is no step.
    #[inline(never)]
    fn move_pairs<const N: usize, const S: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
    ) -> Option<T> {
        self.forget();
        let (matrix, elimination) = (&mut self.matrix, &mut self.jacobian.elimination);
        let (pairs, beta) = (&self.path.pairs, self.path.beta);
        let (sets, delassus) = (&monitor.problem.sets, monitor.problem.factor.delassus());
        let u = &self.point.u;
        let mut system = PathSystem::new(sets, pairs, u, matrix, elimination);
        system.factorise(sets, delassus)?;
        // The fraction to the boundary
        let fraction = T::ONE - tuning::margin::<T>();
        let limit = T::ONE / fraction;
        let (mut step, mut corrected) = (Pairs::none(), Pairs::none());
        system.predict(&mut step)?;
        let left = T::ONE - pairs.max_step(&step, limit).min(T::ONE);
        let goal = (left * left * left * self.path.tau, beta);
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
        self.path.pairs.advance(&corrected, length);
        Some(length)
    }

    /// Moves to pseudo-random impulses of the expected size, seeded by the number of jams.
    #[cfg_attr(target_os = "none", inline(never))]
    fn restart_at_random<const N: usize, const S: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
        jams: usize,
    ) {
        let mut state = u32::try_from(jams).unwrap_or(0);
        let mut random = |size: T| {
            // Numerical Recipes' generator, of which the upper half is random enough
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let share = T::count(usize::from((state >> 16) as u16)) / T::literal(32768.0);
            size * (share - T::ONE)
        };
        let (problem, r) = (&*monitor.problem, &mut self.point.r);
        for (r, set) in r.contacts.iter_mut().zip(problem.sets.contacts()) {
            let size = problem.expected(set.alpha);
            *r = r.map(|_| random(size));
        }
        for (r, set) in r.rows.iter_mut().zip(problem.sets.rows()) {
            *r = random(problem.expected(set.alpha));
        }
        problem.sets.project(r);
    }

    /// Leaves a jam by some sweeps, and enters another central path. Returns whether Newton's method may finish from where the
    /// sweeps have led.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn leave_jam<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) -> bool {
        monitor.note_failure();
        let tau = self.path.tau;
        let jams = self.path.jams;
        self.path.jams = jams.wrapping_add(1);
        if jams > tuning::jams_to_anywhere() && jams % 4 == 1 {
            self.restart_at_random(monitor, jams);
        } else if (jams + 1).is_multiple_of(tuning::jams_to_best())
            && let Some(best) = monitor.best()
        {
            self.point.r = best;
        }
        let (r, u) = (&self.point.r, &mut self.point.u);
        self.point.estimate = monitor.problem.velocities_and_estimate(r, u);
        if !self.point.estimate.is_finite() {
            self.point.set_zero_impulse(monitor.problem);
        }
        if monitor.problem.can_be_swept() {
            self.sweeps = Sweeps::none();
            for _ in 0..tuning::sweeps_at_jam() {
                self.sweep_once(monitor);
            }
        }
        // Rounded by the compiler.
        let value = |values: &[T]| {
            let value = values.get(jams % values.len().max(1));
            value.copied().unwrap_or(T::ONE)
        };
        let gain = value(&tuning::GAINS.map(T::literal));
        let beta = value(&tuning::WEIGHTS.map(T::literal));
        // Higher with each round of weights, so that none repeats another.
        let round = T::count(1 + jams.div_euclid(tuning::WEIGHTS.len()));
        self.enter_path(monitor, tau * tuning::tau_raise() * round, gain, beta);
        let (r, u) = (&self.point.r, &mut self.point.u);
        self.point.estimate = monitor.problem.velocities_and_estimate(r, u);
        self.consider(monitor);
        let is_near = self.point.estimate < tuning::near() || monitor.waits();
        if is_near {
            self.point.rebuild_from_velocity(monitor.problem);
        }
        is_near
    }
}
