//! The methods of the crate as values, so that a test or a tool can go through all of them.

use nalgebra::SVector;
use stiction::{AdmmSolver, Error, Factor, Real, Scene, Settings, Solution, Solver};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    Plain,
    Fast,
    Restart,
    Default,
}

/// The states between two solves, of each solver.
#[derive(Clone)]
pub struct Solvers<T, const N: usize, const D: usize, const C: usize> {
    pub default: Solver<T, N, D, C>,
    pub admm: AdmmSolver<T, N, D, C>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Default for Solvers<T, N, D, C> {
    fn default() -> Self {
        Self {
            default: Solver::new(),
            admm: AdmmSolver::new(),
        }
    }
}

impl Method {
    pub const ALL: [Self; 4] = [Self::Plain, Self::Fast, Self::Restart, Self::Default];

    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Fast => "fast",
            Self::Restart => "restart",
            Self::Default => "default",
        }
    }

    /// A solve from the states of the solvers.
    pub fn run<'a, T: Real, const N: usize, const D: usize, const C: usize>(
        self,
        solvers: &'a mut Solvers<T, N, D, C>,
        scene: &Scene<T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        f: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&'a Solution<T, N, D, C>, Error> {
        let Solvers { default, admm } = solvers;
        match self {
            Self::Plain => admm.solve_plain(scene, factor, f, settings),
            Self::Fast => admm.solve_fast(scene, factor, f, settings),
            Self::Restart => admm.solve_restart(scene, factor, f, settings),
            Self::Default => default.solve(scene, factor, f, settings),
        }
    }

    /// A cold solve.
    pub fn solve<T: Real, const N: usize, const D: usize, const C: usize>(
        self,
        scene: &Scene<T, N, D, C>,
        f: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<Solution<T, N, D, C>, Error> {
        let factor = Factor::new(scene)?;
        let mut solvers = Solvers::default();
        self.run(&mut solvers, scene, &factor, f, settings).cloned()
    }
}
