//! The methods of the solver as values, so that a test can go through all of them.

use nalgebra::SVector;
use stiction::{Error, Factor, Real, Scene, Settings, Solution, Solver};

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Method {
    Plain,
    Fast,
    Restart,
}

impl Method {
    pub(crate) const ALL: [Self; 3] = [Self::Plain, Self::Fast, Self::Restart];

    pub(crate) fn solve<'a, T: Real, const N: usize, const D: usize, const C: usize>(
        self,
        solver: &'a mut Solver<T, N, D, C>,
        scene: &Scene<T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        f: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&'a Solution<T, N, D, C>, Error> {
        match self {
            Self::Plain => solver.solve_plain(scene, factor, f, settings),
            Self::Fast => solver.solve_fast(scene, factor, f, settings),
            Self::Restart => solver.solve_restart(scene, factor, f, settings),
        }
    }
}

/// A cold solve by the default method.
pub(crate) fn solve<T: Real, const N: usize, const D: usize, const C: usize>(
    scene: &Scene<T, N, D, C>,
    f: &SVector<T, N>,
    settings: &Settings<T>,
) -> Result<Solution<T, N, D, C>, Error> {
    let factor = Factor::new(scene)?;
    Solver::new().solve(scene, &factor, f, settings).cloned()
}
