//! The methods of the crate as values, so that a test can go through all of them.

use nalgebra::SVector;
use stiction::{AdmmSolver, Error, Factor, Real, Scene, Settings, Solution, Solver};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    Plain,
    Fast,
    Restart,
    Newton,
}

impl Method {
    pub const ALL: [Self; 4] = [Self::Plain, Self::Fast, Self::Restart, Self::Newton];

    /// A cold solve.
    pub fn solve<T: Real, const N: usize, const D: usize, const C: usize>(
        self,
        scene: &Scene<T, N, D, C>,
        f: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<Solution<T, N, D, C>, Error> {
        let factor = &Factor::new(scene)?;
        let mut admm = AdmmSolver::new();
        match self {
            Self::Plain => admm.solve_plain(scene, factor, f, settings).cloned(),
            Self::Fast => admm.solve_fast(scene, factor, f, settings).cloned(),
            Self::Restart => admm.solve_restart(scene, factor, f, settings).cloned(),
            Self::Newton => Solver::new().solve(scene, factor, f, settings).cloned(),
        }
    }
}
