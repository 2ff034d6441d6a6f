//! The methods of the crate as values, so that a test or a tool can go through all of them.

use nalgebra::SVector;
use stiction::{
    Acceleration, AdmmFactor, AdmmSolver, Error, Factor, Real, Scene, Settings, SlipUpdate, Solution, Solver,
};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    Plain,
    Fast,
    Restart,
    Default,
}

/// The states between two solves, of each solver.
#[derive(Clone)]
pub struct Solvers<T: Real, const N: usize, const D: usize, const C: usize> {
    pub default: Solver<T, N, D, C>,
    admm: [AdmmSolver<T, N, D, C>; 3],
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Solvers<T, N, D, C> {
    /// All cold; those by ADMM update `s` so.
    pub fn new(slip_update: SlipUpdate) -> Self {
        let accelerations = [Acceleration::Plain, Acceleration::Nesterov, Acceleration::Restart];
        Self {
            default: Solver::new(),
            admm: accelerations.map(|acceleration| AdmmSolver::with(acceleration, slip_update)),
        }
    }

    /// Takes over the state of one method.
    pub fn take(&mut self, method: Method, other: &Self) {
        let ([plain, fast, restart], others) = (&mut self.admm, &other.admm);
        match method {
            Method::Plain => plain.clone_from(&others[0]),
            Method::Fast => fast.clone_from(&others[1]),
            Method::Restart => restart.clone_from(&others[2]),
            Method::Default => self.default.clone_from(&other.default),
        }
    }

    /// Forgets the last solves.
    pub fn reset(&mut self) {
        self.default.reset();
        self.admm.iter_mut().for_each(AdmmSolver::reset);
    }

    /// The last solution by a method.
    pub fn solution(&self, method: Method) -> &Solution<T, N, D, C> {
        let [plain, fast, restart] = &self.admm;
        match method {
            Method::Plain => plain.solution(),
            Method::Fast => fast.solution(),
            Method::Restart => restart.solution(),
            Method::Default => self.default.solution(),
        }
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Default for Solvers<T, N, D, C> {
    fn default() -> Self {
        Self::new(SlipUpdate::EveryIteration)
    }
}

/// The factors, of each solver.
#[derive(Clone)]
pub struct Factors<T: Real, const N: usize, const D: usize, const C: usize> {
    pub default: Factor<T, N, D, C>,
    pub admm: AdmmFactor<T, N, D, C>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Factors<T, N, D, C> {
    pub fn empty() -> Self {
        Self { default: Factor::empty(), admm: AdmmFactor::empty() }
    }

    /// Prepares the one that a method needs.
    pub fn prepare(&mut self, method: Method, scene: &Scene<T, N, D, C>) -> Result<(), Error> {
        match method {
            Method::Default => self.default.prepare(scene),
            _ => self.admm.prepare(scene),
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
        factors: &Factors<T, N, D, C>,
        push: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&'a Solution<T, N, D, C>, Error> {
        let Solvers { default, admm: [plain, fast, restart] } = solvers;
        match self {
            Self::Plain => plain.solve(scene, &factors.admm, push, settings),
            Self::Fast => fast.solve(scene, &factors.admm, push, settings),
            Self::Restart => restart.solve(scene, &factors.admm, push, settings),
            Self::Default => default.solve(scene, &factors.default, push, settings),
        }
    }

    /// A cold solve.
    pub fn solve<T: Real, const N: usize, const D: usize, const C: usize>(
        self,
        scene: &Scene<T, N, D, C>,
        push: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<Solution<T, N, D, C>, Error> {
        self.solve_with(SlipUpdate::EveryIteration, scene, push, settings)
    }

    /// A cold solve with an update of `s`.
    pub fn solve_with<T: Real, const N: usize, const D: usize, const C: usize>(
        self,
        slip_update: SlipUpdate,
        scene: &Scene<T, N, D, C>,
        push: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<Solution<T, N, D, C>, Error> {
        let mut factors = Factors::empty();
        factors.prepare(self, scene)?;
        let mut solvers = Solvers::new(slip_update);
        self.run(&mut solvers, scene, &factors, push, settings).cloned()
    }
}
