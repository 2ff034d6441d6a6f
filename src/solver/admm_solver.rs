//! The first-order methods of the note as solvers of their own, without Newton's method.

use crate::admm::{Acceleration, Fast, Plain, Restart};
use crate::problem::Problem;
use crate::solver::monitor::Monitor;
use crate::solver::record::Record;
use crate::solver::warm_start::WarmStart;
use crate::{Error, Factor, Real, Scene, Settings, Solution};
use nalgebra::SVector;

/// Plain ADMM, Algorithm 1 and Algorithm 2 with the penalty of the factor.
///
/// For firmware that does without the Newton finish of [`crate::Solver`]: less code and no
/// workspace, but five times the work to an error of 1e-6, and no proof of infeasibility. It keeps the
/// last solution for a warm start, as [`crate::Solver`] does, and never allocates.
#[derive(Clone, Debug)]
pub struct AdmmSolver<T, const N: usize, const D: usize, const C: usize> {
    warm_start: WarmStart<T, D, C>,
    solution: Solution<T, N, D, C>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize> AdmmSolver<T, N, D, C> {
    /// A solver that has solved nothing yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            warm_start: WarmStart::cold(),
            solution: Solution::none(),
        }
    }

    /// Forgets the last solution: the next solve starts cold.
    pub fn reset(&mut self) {
        self.warm_start = WarmStart::cold();
    }

    /// The last solution.
    #[must_use]
    pub const fn solution(&self) -> &Solution<T, N, D, C> {
        &self.solution
    }

    /// Solves by ADMM without acceleration; `f = -M v_free` is minus the free impulse (N·s).
    ///
    /// # Errors
    /// [`Error::NotFinite`] for `f`, [`Error::FactorMismatch`], [`Error::StaleFactor`],
    /// [`Error::InvalidTolerance`], [`Error::NoResolvent`].
    pub fn solve_plain(
        &mut self,
        scene: &Scene<T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        f: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C>, Error> {
        self.run::<Plain>(scene, factor, f, settings)
    }

    /// Solves by Algorithm 1 of the note, fast ADMM.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for `f`, [`Error::FactorMismatch`], [`Error::StaleFactor`],
    /// [`Error::InvalidTolerance`], [`Error::NoResolvent`].
    pub fn solve_fast(
        &mut self,
        scene: &Scene<T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        f: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C>, Error> {
        self.run::<Fast<T>>(scene, factor, f, settings)
    }

    /// Solves by Algorithm 2 of the note, fast ADMM with restart.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for `f`, [`Error::FactorMismatch`], [`Error::StaleFactor`],
    /// [`Error::InvalidTolerance`], [`Error::NoResolvent`].
    pub fn solve_restart(
        &mut self,
        scene: &Scene<T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        f: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C>, Error> {
        self.run::<Restart<T>>(scene, factor, f, settings)
    }

    fn run<A: Acceleration<T>>(
        &mut self,
        scene: &Scene<T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        f: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C>, Error> {
        Problem::check(scene, factor, f, settings)?;
        let resolvent = factor.resolvent().ok_or(Error::NoResolvent)?;
        let mut problem = Problem::new(scene, factor, f, settings.slip);
        problem.fill();
        let mut iterates = self.warm_start.iterates(&problem, factor.penalty());
        let mut record = Record::none();
        let mut monitor = Monitor::new(
            &mut problem,
            settings,
            &mut self.solution,
            &mut record,
            false,
        );
        let mut acceleration = A::START;
        monitor.consider_iterates(&iterates);
        while monitor.is_running() {
            monitor.iterate(resolvent, &mut iterates, &mut acceleration);
        }
        if !monitor.is_over() {
            monitor.consider_iterates(&iterates);
        }
        monitor.finish(&iterates.map(|iterate| iterate.impulse().into()));
        let contacts = iterates.iter().map(|i| (i.u, i.impulse()));
        self.warm_start.keep(scene.contacts(), contacts, false);
        Ok(&self.solution)
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Default for AdmmSolver<T, N, D, C> {
    fn default() -> Self {
        Self::new()
    }
}
