//! The interior-point method on a smoothed Coulomb law: what follows a rejected Newton step.
//!
//! With `r = D x`, `w = D u`, `D = diag(1, mu, ..., mu)` the central path is
//!
//! `w_N x_N = tau`, `(x_N, x_T) ∘ (s, w_T) = beta tau e`, `w = D W D x + D q`, `tau -> 0`
//!
//! with a bound `s` on slip that is free. That is `u_N = tau / r_N` and `w_T = -beta tau x_T / det x`: Coulomb's law,
//! smoothed. What is linear stays linear, the rest is bilinear, so that the corrector of Mehrotra is exact to second
//! order. Hyperstatic impulses stay inside of their cones.

use crate::Real;
use crate::linalg::blocks::ContactVector;
use crate::linalg::hints::rolled;
use crate::solver::monitor::Monitor;
use crate::solver::newton::Newton;
use crate::solver::phases::{Phase, Solve};
use crate::solver::sweeps::Sweeps;
use crate::solver::tuning;
use crate::solver::workspace::Workspace;
use direction::System;
use pair::{Pair, Part, narrow, widen};

mod direction;
mod pair;

/// The central path: the pairs and how they get on.
#[derive(Clone, Debug)]
pub(crate) struct InteriorPoint<T, const D: usize, const C: usize> {
    pairs: [Pair<T, D>; C],
    /// Weight of friction on the path, see the module.
    beta: T,
    /// `tau` of the last steps, the last one first.
    taus: [Option<T>; 4],
    /// The merit at which Newton's method was last tried from here.
    tried: Option<T>,
    jams: usize,
}

impl<T: Real, const D: usize, const C: usize> InteriorPoint<T, D, C> {
    /// No solve yet.
    pub(crate) const fn none() -> Self {
        Self {
            pairs: [const { Pair::none() }; C],
            beta: T::ZERO,
            taus: [None; 4],
            tried: None,
            jams: 0,
        }
    }
}

impl<T: Real, const D: usize, const C: usize> Solve<T, D, C> {
    /// The interior point from the impulses of the point.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn begin_interior<const N: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C>,
    ) -> Phase {
        let start = tuning::interior_start();
        if start < 10 {
            self.point.set_zero_impulse(monitor.problem);
        }
        if monitor.problem.can_be_swept() {
            self.sweeps = Sweeps::none();
            for _ in 0..start % 10 {
                self.sweep_once(monitor);
            }
        }
        self.path.jams = 0;
        let (mut sum, mut count) = (T::ZERO, T::ZERO);
        for law in monitor.problem.laws() {
            rolled();
            if law.alpha > T::ZERO {
                let rows = if law.rows() == 1 { 1 } else { D };
                let q = law.q.iter().take(rows);
                sum += law.alpha * q.fold(T::ZERO, |sum, &q| sum + q * q);
                count += T::ONE;
            }
        }
        self.centre(monitor, sum / count.max(T::ONE) * tuning::first_energy(), tuning::first_gain(), T::ONE);
        self.place(monitor);
        Phase::InteriorPoint
    }

    /// Pairs of the central path near the impulses and `u` of the point.
    fn centre<const N: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C>,
        energy: T,
        gain: T,
        beta: T,
    ) {
        let contacts = self.point.r.iter().zip(&self.point.u);
        let targets = self.path.pairs.iter_mut().zip(contacts);
        for ((pair, (r, u)), law) in targets.zip(monitor.problem.laws()) {
            rolled();
            *pair = Pair::none();
            if Part::of(law) != Part::Nothing {
                let augmented = law.augmented(&(*u).into()).into();
                let (x, w) = (narrow(law, r), widen(law, &augmented));
                *pair = Pair::centred(law, &x, &w, energy, gain, beta);
            }
        }
        self.path.beta = beta;
        self.path.taus = [None; 4];
        self.path.tried = None;
    }

    /// Moves the point to the impulses of the pairs.
    pub(super) fn place<const N: usize>(&mut self, monitor: &Monitor<'_, '_, T, N, D, C>) {
        let pairs = self.path.pairs.iter().zip(monitor.problem.laws());
        for (r, (pair, law)) in self.point.r.iter_mut().zip(pairs) {
            rolled();
            *r = widen(law, &pair.x.into()).into();
        }
        let (r, u) = (&self.point.r, &mut self.point.u);
        self.point.natural_map = monitor.problem.natural_map(r, u);
    }

    /// `tau` of the pairs.
    fn tau<const N: usize>(&self, monitor: &Monitor<'_, '_, T, N, D, C>) -> T {
        let (mut sum, mut count) = (T::ZERO, T::ZERO);
        for (pair, law) in self.path.pairs.iter().zip(monitor.problem.laws()) {
            rolled();
            let [normal, tangential] = pair.energies();
            let part = Part::of(law);
            if matches!(part, Part::Normal | Part::Coulomb) {
                sum += normal;
                count += T::ONE;
            }
            if matches!(part, Part::Cone | Part::Coulomb) {
                sum += tangential / self.path.beta;
                count += T::ONE;
            }
        }
        sum / count.max(T::ONE)
    }

    /// A step along the central path, and what is to come.
    #[inline(never)]
    pub(super) fn follow_path<const N: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C>,
        workspace: &mut Workspace<T, D, C>,
    ) -> Phase {
        monitor.solution.work.newton_steps += 1;
        let tau = self.tau(monitor);
        let length = self.step_inside(monitor, workspace, tau);
        self.place(monitor);
        self.consider(monitor);
        if monitor.is_over() {
            return Phase::InteriorPoint;
        }
        let here = self.tau(monitor);
        let near = tuning::near::<T>().max(T::literal(10.0) * monitor.tolerance());
        if self.point.natural_map < near && length.is_some() {
            self.set_p(monitor);
            if tuning::from_w() > 0 {
                let pairs = self.path.pairs.iter().zip(monitor.problem.laws());
                for (p, (pair, law)) in self.point.p.iter_mut().zip(pairs) {
                    if matches!(Part::of(law), Part::Cone | Part::Coulomb) {
                        *p = narrow(law, &pair.w.into()) / self.path.beta;
                    }
                }
            }
            self.point.rebuild(monitor.problem, self.penalty.scale);
            let merit = self.point.merit;
            let half = |tried: T| merit * T::literal(4.0) < tried;
            if self.path.tried.is_none_or(half) {
                self.path.tried = Some(merit);
                return Phase::Newton(Newton::finish());
            }
            self.place(monitor);
        }
        let [.., before] = self.path.taus;
        let stalls = before.is_some_and(|before| here > before * tuning::stalled());
        let [first, second, third, _] = self.path.taus;
        self.path.taus = [Some(here), first, second, third];
        if stalls || length.is_none_or(|length| length < tuning::jam()) {
            self.leave_jam(monitor, here);
        }
        Phase::InteriorPoint
    }

    /// Sweeps, and back to the central path nearby with another weight of friction.
    fn leave_jam<const N: usize>(&mut self, monitor: &mut Monitor<'_, '_, T, N, D, C>, tau: T) {
        monitor.fail();
        let (r, u, natural_map) = (self.point.r, self.point.u, self.point.natural_map);
        if monitor.problem.can_be_swept() {
            self.sweeps = Sweeps::none();
            for _ in 0..tuning::jam_sweeps() {
                self.sweep_once(monitor);
            }
            let here = monitor.problem.natural_map_at(&self.point.r, &self.point.u);
            self.point.natural_map = here;
            self.consider(monitor);
            if here > natural_map {
                (self.point.r, self.point.u) = (r, u);
            }
        }
        let beta = if self.path.jams % 2 == 0 { tuning::beta() } else { T::ONE };
        self.path.jams += 1;
        self.centre(monitor, tau * tuning::lift(), T::ONE, beta);
        self.place(monitor);
    }

    /// Moves the pairs, and says how far; `None` if there is no step.
    fn step_inside<const N: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C>,
        workspace: &mut Workspace<T, D, C>,
        tau: T,
    ) -> Option<T> {
        let (matrix, elimination) = workspace.lend();
        let (pairs, beta) = (&self.path.pairs, self.path.beta);
        let u: &ContactVector<T, D, C> = &self.point.u;
        let system = System::new(monitor.problem, pairs, u, matrix, elimination)?;
        let boundary = tuning::boundary::<T>();
        let limit = T::ONE / boundary;
        let predicted = system.predict()?;
        let left = T::ONE - system.reach(&predicted, limit).min(T::ONE);
        let goal = left * left * left * tau;
        let mut step = system.correct(&predicted, goal, beta)?;
        let mut reach = system.reach(&step, limit);
        if reach < tuning::correct_again() {
            if let Some(other) = system.correct(&step, goal, beta) {
                let farther = system.reach(&other, limit);
                if farther > reach {
                    (step, reach) = (other, farther);
                }
            }
        }
        let length = (boundary * reach).min(T::ONE);
        let laws = monitor.problem.laws();
        for (pair, (step, law)) in self.path.pairs.iter_mut().zip(step.iter().zip(laws)) {
            rolled();
            pair.go(Part::of(law), step, length);
        }
        Some(length)
    }
}
