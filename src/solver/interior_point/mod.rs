//! The interior-point method on a smoothed Coulomb law: what follows a rejected Newton step.
//!
//! With `r = Λ x`, `y = Λ u`, `Λ = diag(1, mu, ..., mu)` and `e = (1, 0, ..., 0)` the central path is
//!
//! `y_N x_N = tau`, `(x_N, x_T) ∘ (s, y_T) = beta tau e`, `y = Λ W Λ x + Λ q`, `tau -> 0`
//!
//! where `s` is an extra unknown with `s >= |y_T|`. That is `u_N = tau / r_N` and `y_T = -beta tau x_T / det x`: Coulomb's
//! law, smoothed, without the De Saxcé shift. The equations are linear but for the two bilinear products, so that
//! Mehrotra's corrector is exact to second order. Hyperstatic impulses stay in the interior of their cones. (In the convex
//! relaxation `s` is `y_N`.) The field `w` of a pair is `(s, y_T)`.
//!
//! Coulomb's law is not monotone: the path can have folds. If it jams, sweeps lead away, and another path is entered, with
//! another weight `beta`. Every path that reaches `tau = 0` ends at a solution.

use crate::Real;
use crate::laws::{Coulomb, Laws, Room};
use crate::linalg::hints::{opaque, rolled};
use crate::solver::monitor::Monitor;
use crate::solver::phases::{Phase, Solve};
use crate::solver::sweeps::Sweeps;
use crate::solver::tuning;
use crate::solver::workspace::Workspace;
use direction::System;
use nalgebra::SVector;
use pair::{Pair, Part, widen};

mod direction;
mod lorentz;
mod pair;
mod row_pairs;
#[cfg(test)]
mod tests;

/// The state of the interior point.
#[derive(Clone, Debug)]
pub(crate) struct InteriorPoint<T: Real, const D: usize, const C: usize, L: Laws = Coulomb> {
    pairs: [Pair<T, D, L>; C],
    /// Weight of friction on the central path.
    beta: T,
    /// `tau` of the last point that had one.
    tau: T,
    /// Steps on this path.
    steps: usize,
    /// The merit at Newton's last trial on this path.
    tried: Option<T>,
    jams: usize,
}

/// What came of a step.
pub(super) enum Progress {
    /// There are more to come.
    Far,
    /// Newton's method may finish from the point.
    Near,
    /// The path leads nowhere from here.
    Jammed,
}

impl<T: Real, const D: usize, const C: usize, L: Laws> InteriorPoint<T, D, C, L> {
    /// No solve yet.
    pub(crate) const fn none() -> Self {
        Self {
            pairs: [const { Pair::none() }; C],
            beta: T::ZERO,
            tau: T::ZERO,
            steps: 0,
            tried: None,
            jams: 0,
        }
    }

    /// `tau`: the mean of the products that are to vanish.
    fn tau(&self) -> T {
        let (mut sum, mut count) = (T::ZERO, T::ZERO);
        let mut add = |product| {
            sum += product;
            count += T::ONE;
        };
        for pair in &self.pairs {
            rolled();
            pair.products(self.beta)
                .into_iter()
                .flatten()
                .for_each(&mut add);
            if let Some(rows) = pair.rows.get() {
                rows.products().for_each(&mut add);
            }
        }
        sum / count.max(T::ONE)
    }
}

impl<T: Real, const D: usize, const C: usize, L: Laws> Solve<T, D, C, L> {
    /// Begins the interior-point method at the impulses of the point, after a search for a proof of infeasibility.
    ///
    /// `tau` starts at 10 times the mean of `alpha |q|²`.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn begin_interior<const N: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, L>,
    ) -> Phase {
        monitor.look_for_proof();
        let (mut energy, mut count) = (T::ZERO, T::ZERO);
        for law in monitor.problem.laws() {
            rolled();
            energy += law.energy(Part::of(law).count::<D>());
            count += T::ONE;
        }
        self.interior.jams = 0;
        let tau = energy / count * tuning::first_tau();
        self.enter_path(monitor, tau, tuning::first_gain(), T::ONE);
        self.back_to_path(monitor);
        Phase::InteriorPoint
    }

    /// Pairs of a central path near the impulses and `u` of the point.
    #[cfg_attr(target_os = "none", inline(never))]
    fn enter_path<const N: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, L>,
        tau: T,
        gain: T,
        beta: T,
    ) {
        self.interior.beta = beta;
        self.interior.tau = tau;
        self.interior.steps = 0;
        self.interior.tried = None;
        self.interior.pairs = [Pair::none(); C];
        let contacts = self.point.r.iter().zip(&self.point.u);
        let targets = self.interior.pairs.iter_mut().zip(contacts);
        for ((pair, (r, u)), law) in targets.zip(monitor.problem.laws()) {
            rolled();
            let velocity = law.augmented(&(*u).into());
            *pair = Pair::centred(law, &(*r).into(), &velocity, tau, gain, beta);
        }
    }

    /// Moves the point to the impulses of the pairs.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn back_to_path<const N: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, L>,
    ) {
        let pairs = self.interior.pairs.iter().zip(monitor.problem.laws());
        for (r, (pair, law)) in self.point.r.iter_mut().zip(pairs) {
            rolled();
            *r = widen(law, &pair.x).into();
            if let Some(rows) = law.rows.get() {
                *r = rows.project(&pair.x).into();
            }
        }
        let (r, u) = (&self.point.r, &mut self.point.u);
        self.point.natural_map = monitor.problem.natural_map(r, u);
    }

    /// A step along the central path.
    #[inline(never)]
    pub(super) fn step_inside<const N: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, L>,
        workspace: &mut Workspace<T, D, C, L>,
    ) -> Progress {
        monitor.solution.work.newton_steps += 1;
        let length = self.move_pairs(monitor, workspace);
        self.back_to_path(monitor);
        self.consider(monitor);
        if monitor.is_over() {
            return Progress::Far;
        }
        if self.is_near(monitor) {
            self.point.rebuild_from_velocity(monitor.problem);
            let (merit, tried) = (self.point.merit, self.interior.tried);
            // Each time at half the residual at most.
            if tried.is_none_or(|tried| merit * T::literal(4.0) < tried) {
                self.interior.tried = Some(merit);
                return Progress::Near;
            }
            self.back_to_path(monitor);
        }
        let tau = self.interior.tau();
        if tau.is_finite() {
            self.interior.tau = tau;
        }
        self.interior.steps += 1;
        let too_long = self.interior.steps >= tuning::longest_path();
        if too_long || length.is_none_or(|length| length < tuning::jammed()) {
            Progress::Jammed
        } else {
            Progress::Far
        }
    }

    /// Moves the pairs by a step of Mehrotra's predictor-corrector method. Returns its length; `None` if there is no step.
    fn move_pairs<const N: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, L>,
        workspace: &mut Workspace<T, D, C, L>,
    ) -> Option<T> {
        let (matrix, elimination) = workspace.lend();
        let (pairs, beta) = (&self.interior.pairs, self.interior.beta);
        let system = System::new(monitor.problem, pairs, &self.point.u, matrix, elimination)?;
        // The fraction to the boundary
        let fraction = T::ONE - tuning::margin::<T>();
        let limit = T::ONE / fraction;
        let predicted = system.predict()?;
        let left = T::ONE - system.reach(&predicted, limit).min(T::ONE);
        let tau = left * left * left * self.interior.tau();
        let mut step = system.correct(&predicted, tau, beta)?;
        let mut reach = system.reach(&step, limit);
        if reach < tuning::correct_again() {
            let other = system.correct(&step, tau, beta)?;
            let farther = system.reach(&other, limit);
            if farther > reach {
                (step, reach) = (other, farther);
            }
        }
        let length = (fraction * reach).min(T::ONE);
        for (pair, step) in self.interior.pairs.iter_mut().zip(&step) {
            rolled();
            pair.go(step, length);
        }
        Some(length)
    }

    /// May Newton's method finish from the point?
    fn is_near<const N: usize>(&self, monitor: &Monitor<'_, '_, T, N, D, C, L>) -> bool {
        let near = tuning::near::<T>().max(T::literal(10.0) * monitor.tolerance());
        self.point.natural_map < near
    }

    /// Moves to pseudo-random impulses of the expected size, seeded by the number of jams.
    #[cfg_attr(target_os = "none", inline(never))]
    fn go_anywhere<const N: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, L>,
        jams: usize,
    ) {
        let mut state = u32::try_from(jams).unwrap_or(0);
        for (law, r) in opaque(monitor.problem.laws()).iter().zip(&mut self.point.r) {
            rolled();
            let size = monitor.problem.expected(law);
            let mut impulse = SVector::from(*r);
            for entry in &mut impulse {
                // Numerical Recipes' generator, of which the upper half is random enough
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let share = T::count(usize::from((state >> 16) as u16)) / T::literal(32768.0);
                *entry = size * (share - T::ONE);
            }
            *r = law.project(&impulse).into();
        }
    }

    /// Leaves a jam by some sweeps, and enters another central path. Returns whether Newton's method may finish from where the
    /// sweeps have led.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn leave_jam<const N: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, L>,
    ) -> bool {
        monitor.note_failure();
        let tau = self.interior.tau;
        let jams = self.interior.jams;
        self.interior.jams = jams.wrapping_add(1);
        if jams > tuning::jams_to_anywhere() && jams % 4 == 1 {
            self.go_anywhere(monitor, jams);
        } else if (jams + 1).is_multiple_of(tuning::jams_to_best())
            && let Some(best) = monitor.best()
        {
            self.point.r = best;
        }
        let (r, u) = (&self.point.r, &mut self.point.u);
        self.point.natural_map = monitor.problem.natural_map(r, u);
        if !self.point.natural_map.is_finite() {
            self.point.set_zero_impulse(monitor.problem);
        }
        if monitor.problem.can_be_swept() {
            self.sweeps = Sweeps::none();
            for _ in 0..tuning::sweeps_at_jam() {
                self.sweep_once(monitor);
            }
        }
        let value = |values: &[f64]| {
            let value = values.get(jams % values.len().max(1));
            value.map_or(T::ONE, |&value| T::literal(value))
        };
        let (gain, beta) = (value(&tuning::GAINS), value(&tuning::WEIGHTS));
        // Higher with each round of weights, so that none repeats another.
        let round = T::count(1 + jams.div_euclid(tuning::WEIGHTS.len()));
        self.enter_path(monitor, tau * tuning::lift() * round, gain, beta);
        let (r, u) = (&self.point.r, &mut self.point.u);
        self.point.natural_map = monitor.problem.natural_map(r, u);
        self.consider(monitor);
        let is_near = self.is_near(monitor);
        if is_near {
            self.point.rebuild_from_velocity(monitor.problem);
        }
        is_near
    }
}
