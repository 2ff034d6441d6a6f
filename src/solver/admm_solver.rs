//! The first-order methods of the note as a solver of their own, without Newton's method.

use crate::admm::{Acceleration, Iterate, Momentum, SlipUpdate};
use crate::factor::resolvent::Resolvent;
use crate::problem::Problem;
use crate::solver::calls::{Call, Calls, Method};
use crate::solver::monitor::Monitor;
use crate::solver::warm_start::WarmStart;
use crate::{AdmmFactor, Error, Real, Scene, Settings, Solution};
use nalgebra::SVector;

/// ADMM with the penalty of the factor: Algorithm 2 of the note, Algorithm 1, or without acceleration.
///
/// For firmware that does without Newton's method: less code and RAM than [`crate::Solver`], but five times the work to
/// an error of 1e-6, and no proof of infeasibility. It keeps the last solution for a warm start, as [`crate::Solver`]
/// does, and never allocates.
///
/// ```
/// use nalgebra::{Matrix2, matrix, vector};
/// use stiction::{AdmmFactor, AdmmSolver, Contact, Scene, Settings};
///
/// let mut scene = Scene::<f32, 2, 2, 1>::new();
/// scene.set_mass(&(Matrix2::identity() * 2.0))?;
/// scene.push(&Contact { jacobian: matrix![0.0, 1.0; 1.0, 0.0], offset: vector![0.0, 0.0], mu: 0.5, key: 0 })?;
/// let factor = AdmmFactor::new(&scene)?; // with the resolvent (I + rho W)⁻¹
/// let mut solver = AdmmSolver::new();
/// let solution = solver.solve(&scene, &factor, &vector![0.3, -0.2], &Settings::new(1e-4))?;
/// assert!(solution.is_solved() && solution.work.iterations == solution.work.total());
/// # Ok::<(), stiction::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct AdmmSolver<T: Real, const N: usize, const D: usize, const C: usize> {
    calls: Calls<T, N, D, C>,
    method: Admm<T, D, C>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize> AdmmSolver<T, N, D, C> {
    /// A solver by Algorithm 2 that updates `s` at every iteration, and has solved nothing yet.
    #[must_use]
    pub const fn new() -> Self {
        Self::with(Acceleration::Restart, SlipUpdate::EveryIteration)
    }

    /// A solver with these options, see [`Acceleration`] and [`SlipUpdate`].
    #[must_use]
    pub const fn with(acceleration: Acceleration, slip_update: SlipUpdate) -> Self {
        Self {
            calls: Calls::none(),
            method: Admm {
                iterates: [const { Iterate::none() }; C],
                momentum: Momentum::none(acceleration),
                slip_update,
            },
        }
    }

    /// Forgets the last solve, as [`crate::Solver::reset`].
    pub fn reset(&mut self) {
        self.calls.reset();
    }

    /// Starts the next solve at these impulses, as [`crate::Solver::set_impulses`].
    ///
    /// # Errors
    /// Same errors as [`crate::Solver::set_impulses`].
    pub fn set_impulses(&mut self, impulses: &[(u32, SVector<T, D>)]) -> Result<(), Error> {
        self.calls.set_impulses(impulses)
    }

    /// The last solution.
    #[must_use]
    pub const fn solution(&self) -> &Solution<T, N, D, C> {
        &self.calls.solution
    }

    /// Solves a scene for a free impulse `M v_free` (N·s), as [`crate::Solver::solve`].
    ///
    /// # Errors
    /// Same errors as [`crate::Solver::solve`].
    pub fn solve(
        &mut self,
        scene: &Scene<T, N, D, C>,
        factor: &AdmmFactor<T, N, D, C>,
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C>, Error> {
        let data = (scene, factor.factor(), free_impulse, settings);
        let mut method = Running(&mut self.method, factor.resolvent());
        self.calls.run(&mut method, data, Call::Begin)
    }

    /// Goes on with a solve whose budget has ended, as [`crate::Solver::resume`].
    ///
    /// # Errors
    /// As for [`Self::solve`].
    pub fn resume(
        &mut self,
        scene: &Scene<T, N, D, C>,
        factor: &AdmmFactor<T, N, D, C>,
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C>, Error> {
        let data = (scene, factor.factor(), free_impulse, settings);
        let mut method = Running(&mut self.method, factor.resolvent());
        self.calls.resume(&mut method, data)
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Default for AdmmSolver<T, N, D, C> {
    fn default() -> Self {
        Self::new()
    }
}

/// The state of a solve by ADMM.
#[derive(Clone, Debug)]
struct Admm<T, const D: usize, const C: usize> {
    iterates: [Iterate<T, D>; C],
    momentum: Momentum<T>,
    slip_update: SlipUpdate,
}

/// A solve by ADMM with a resolvent.
struct Running<'a, T, const D: usize, const C: usize>(
    &'a mut Admm<T, D, C>,
    &'a Resolvent<T, D, C>,
);

impl<T: Real, const D: usize, const C: usize> Method<T, D, C> for Running<'_, T, D, C> {
    const SEEKS_PROOF: bool = false;

    fn begin<const N: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C>,
        warm_start: &mut WarmStart<T, D, C>,
    ) {
        let Self(admm, resolvent) = self;
        admm.iterates = warm_start.iterates(monitor.problem, resolvent.penalty);
        admm.momentum.start();
        monitor.count_stopping();
        monitor.consider_iterates(&admm.iterates);
    }

    fn advance<const N: usize>(&mut self, monitor: &mut Monitor<'_, '_, T, N, D, C>) {
        let Self(admm, resolvent) = self;
        let (iterates, momentum) = (&mut admm.iterates, &mut admm.momentum);
        monitor.iterate(resolvent, iterates, momentum, admm.slip_update);
    }

    fn contacts<const N: usize>(
        &self,
        _: &Problem<'_, T, N, D, C>,
    ) -> impl Iterator<Item = (SVector<T, D>, SVector<T, D>)> {
        let iterates = self.0.iterates.iter();
        iterates.map(|iterate| (iterate.u, iterate.impulse()))
    }

    fn impulses(&self) -> impl Iterator<Item = SVector<T, D>> {
        self.0.iterates.iter().map(Iterate::impulse)
    }
}
