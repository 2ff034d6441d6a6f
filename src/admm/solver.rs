//! The first-order methods of the note as a solver of their own, without Newton's method.

use crate::admm::iterate::{Extrapolation, Iterate, iterate};
use crate::admm::{Acceleration, SlipUpdate};
use crate::error::Error;
use crate::factor::AdmmFactor;
use crate::factor::resolvent::Resolvent;
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::quotient;
use crate::linalg::zip::zip3;
use crate::problem::{Age, Problem};
use crate::real::Real;
use crate::scene::Scene;
use crate::solution::{Settings, Solution};
use crate::solver::AllPhases;
use crate::solver::monitor::Monitor;
use crate::solver::record::{Call, Measure, Record};
use crate::solver::warm_start::WarmStart;
use nalgebra::SVector;

/// ADMM with the penalty of the factor: Algorithm 2 of the note, Algorithm 1, or without acceleration.
///
/// The note's method by itself: less code and RAM than [`crate::Solver`], but five times the work to an error of 1e-6, and no proof of
/// infeasibility. (For firmware that does without Newton's method [`crate::SweepsOnly`] takes as much flash and less work.) It keeps the last solution for a warm start, as [`crate::Solver`]
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
    solution: Solution<T, N, D, C>,
    warm_start: WarmStart<T, D, C, 0>,
    record: Record<T, D, C, 0>,
    iterates: [Iterate<T, D>; C],
    extrapolation: Extrapolation<T>,
    slip_update: SlipUpdate,
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
            solution: Solution::none(),
            warm_start: WarmStart::cold(),
            record: Record::none(),
            iterates: [const { Iterate::none() }; C],
            extrapolation: Extrapolation::none(acceleration),
            slip_update,
        }
    }

    /// Forgets the last solve, as [`crate::Solver::reset`].
    pub fn reset(&mut self) {
        self.warm_start = WarmStart::cold();
        self.record.forget();
    }

    /// Starts the next solve at these impulses, as [`crate::Solver::set_impulses`].
    ///
    /// # Errors
    /// Same errors as [`crate::Solver::set_impulses`].
    pub fn set_impulses(&mut self, impulses: &[(u32, SVector<T, D>)]) -> Result<(), Error> {
        self.warm_start.set(impulses, &[])?;
        self.record.forget();
        Ok(())
    }

    /// The last solution.
    #[must_use]
    pub const fn solution(&self) -> &Solution<T, N, D, C> {
        &self.solution
    }

    /// Solves a scene for a free impulse `M v_free` (N·s), as [`crate::Solver::solve`].
    ///
    /// # Errors
    /// Same errors as [`crate::Solver::solve`].
    pub fn solve<const S: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, 0, S>,
        factor: &AdmmFactor<T, N, D, C>,
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C>, Error> {
        self.run(scene, factor, free_impulse, settings, false)
    }

    /// Goes on with a solve whose budget has ended, as [`crate::Solver::resume`]; with another penalty it begins anew.
    ///
    /// # Errors
    /// As for [`Self::solve`].
    pub fn resume<const S: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, 0, S>,
        factor: &AdmmFactor<T, N, D, C>,
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C>, Error> {
        self.run(scene, factor, free_impulse, settings, true)
    }

    /// Begins a solve, or goes on with a paused one.
    fn run<const S: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, 0, S>,
        factor: &AdmmFactor<T, N, D, C>,
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
        resumes: bool,
    ) -> Result<&Solution<T, N, D, C>, Error> {
        let data = || factor.penalty().hash(Problem::fingerprint(scene, free_impulse, settings));
        let call = if resumes { self.record.resume(data) } else { Call::Begin };
        self.solution.invalidate_if_unsolved();
        Problem::check(scene, factor.factor(), free_impulse, settings)?;
        let mut problem = Problem::new(scene, factor.factor(), free_impulse, settings, Age::New);
        problem.fill(false);
        let resolvent = factor.resolvent();
        if call == Call::Begin {
            self.record.begin();
            self.begin(&problem, resolvent.penalty);
        }
        let (solution, record) = (&mut self.solution, &mut self.record);
        let monitor = Monitor::new(&mut problem, settings, solution, record, call);
        let (iterates, extrapolation) = (&mut self.iterates, &mut self.extrapolation);
        let mut solve = Solve { monitor, resolvent, iterates, extrapolation, slip_update: self.slip_update };
        let r = solve.run();
        let mut u = Stacked::zero();
        for (u, iterate) in u.contacts.iter_mut().zip(&self.iterates) {
            *u = iterate.u.into();
        }
        self.warm_start.keep(scene, &u, &r, call != Call::Begin);
        self.record.pause(data);
        Ok(&self.solution)
    }

    /// Sets the first iterates: those of the last solution, or zero without one.
    fn begin<const S: usize>(&mut self, problem: &Problem<'_, T, N, D, C, 0, S>, penalty: T) {
        let _ = self.warm_start.follow(problem.scene);
        let [mut u, mut r] = [Stacked::zero(); 2];
        self.warm_start.recall(problem.scene, &mut u, &mut r);
        problem.sets.project(&mut r);
        for (iterate, &u, &r) in zip3(&mut self.iterates, &u.contacts, &r.contacts) {
            *iterate = Iterate::at(u.into(), r.into(), penalty);
        }
        self.extrapolation.start();
    }
}

/// A solve under way in one call.
struct Solve<'s, 'a, T: Real, const N: usize, const D: usize, const C: usize, const S: usize> {
    monitor: Monitor<'s, 'a, T, N, D, C, 0, S>,
    resolvent: &'s Resolvent<T, D, C>,
    iterates: &'s mut [Iterate<T, D>; C],
    extrapolation: &'s mut Extrapolation<T>,
    slip_update: SlipUpdate,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const S: usize> Solve<'_, '_, T, N, D, C, S> {
    /// Iterates until the end of the solve or of the budget, and writes the solution. Returns the last impulses.
    fn run(&mut self) -> Stacked<T, D, C, 0> {
        if self.monitor.is_first_call() {
            self.monitor.count_stopping();
            self.consider();
        }
        while self.monitor.is_running() {
            self.step();
        }
        let r = impulses(self.iterates);
        if !self.monitor.is_over() {
            let mut u = Stacked::zero();
            let estimate = self.monitor.problem.velocities_and_estimate(&r, &mut u);
            self.monitor.keep(&r, &u, (estimate, Measure::Estimate));
        }
        self.monitor.finish::<AllPhases>();
        r
    }

    /// Makes one iteration. If the iterates may be within the tolerance, shows them to the monitor.
    #[inline]
    fn step(&mut self) {
        self.monitor.solution.work.iterations += 1;
        let problem = &*self.monitor.problem;
        let sets = problem.sets.contacts();
        let change = iterate(sets, self.resolvent, self.iterates, self.extrapolation, self.slip_update);
        // Squares are compared, without a root.
        let size = problem.expected_size * problem.expected_size;
        let estimate = quotient(change.error, size.max(change.impulse));
        let tolerance = self.monitor.tolerance() * self.monitor.tolerance();
        if self.slip_update == SlipUpdate::OuterLoop && estimate <= tolerance {
            self.iterates.iter_mut().for_each(Iterate::update_slip);
            self.extrapolation.start();
        }
        if estimate <= tolerance * T::literal(4.0) {
            self.consider();
        }
    }

    /// Shows the iterates to the monitor.
    fn consider(&mut self) {
        let (r, mut u) = (impulses(self.iterates), Stacked::zero());
        let monitor = &mut self.monitor;
        let estimate = monitor.problem.velocities_and_estimate(&r, &mut u);
        monitor.consider(&r, &u, estimate);
        while !monitor.is_over() && monitor.must_return() {
            monitor.check::<AllPhases>(&r, &u);
        }
    }
}

/// The impulses `r = -rho ζ` of all contacts.
fn impulses<T: Real, const D: usize, const C: usize>(iterates: &[Iterate<T, D>; C]) -> Stacked<T, D, C, 0> {
    let mut r = Stacked::zero();
    for (r, iterate) in r.contacts.iter_mut().zip(iterates) {
        *r = iterate.impulse().into();
    }
    r
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Default for AdmmSolver<T, N, D, C> {
    fn default() -> Self {
        Self::new()
    }
}
