//! The default method: Gauss-Seidel or a guess for a start, semismooth Newton to the end, and an interior-point method
//! where that fails.

use crate::problem::Problem;
use crate::solver::monitor::Monitor;
use crate::solver::phases::Solve;
use crate::solver::record::Record;
use crate::solver::warm_start::WarmStart;
use crate::solver::workspace::Workspace;
use crate::{Error, Factor, Real, Scene, Settings, Solution};
use nalgebra::SVector;

mod admm_solver;
mod frame;
mod gauss_seidel;
mod interior_point;
mod jacobian;
mod monitor;
mod newton;
mod outlook;
mod phases;
mod point;
mod record;
mod sweeps;
mod tuning;
mod warm_start;
mod workspace;

pub use admm_solver::AdmmSolver;

/// A solver for scenes of `N` velocities and up to `C` contacts of `D` rows.
///
/// It keeps the last solution, and starts the next solve from it (warm start) as far as the
/// contacts are still there, by their [`crate::Contact::key`]; [`Solver::reset`] forgets it. It
/// never allocates.
///
/// ```
/// use nalgebra::{Matrix2, matrix, vector};
/// use stiction::{Contact, ContactMode, Factor, Scene, Settings, Solver};
///
/// // 2 kg on a floor (x, height), pushed for 10 ms by 5 N sideways.
/// let mut scene = Scene::<f64, 2, 2, 1>::new();
/// scene.set_mass(&(Matrix2::identity() * 2.0))?;
/// scene.push(&Contact {
///     jacobian: matrix![0.0, 1.0; 1.0, 0.0],
///     offset: vector![0.0, 0.0],
///     mu: 0.5,
///     key: 0,
/// })?;
/// let factor = Factor::new(&scene)?;
/// let mut solver = Solver::new();
/// let f = -vector![5.0 * 0.01, -2.0 * 9.81 * 0.01]; // f = -M v_free
/// let solution = solver.solve(&scene, &factor, &f, &Settings::default())?;
/// assert_eq!(solution.contacts[0].mode, ContactMode::Stick);
/// # Ok::<(), stiction::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Solver<T, const N: usize, const D: usize, const C: usize> {
    warm_start: WarmStart<T, D, C>,
    solution: Solution<T, N, D, C>,
    record: Record<T, D, C>,
    solve: Solve<T, D, C>,
    workspace: Workspace<T, D, C>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Solver<T, N, D, C> {
    /// A solver that has solved nothing yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            warm_start: WarmStart::cold(),
            solution: Solution::none(),
            record: Record::none(),
            solve: Solve::none(),
            workspace: Workspace::none(),
        }
    }

    /// Forgets the last solve: the next one starts cold. [`Self::solution`] stays what it is.
    pub fn reset(&mut self) {
        self.warm_start = WarmStart::cold();
        self.record.forget();
        self.solve.stop();
        self.workspace.forget();
    }

    /// The last solution.
    #[must_use]
    pub const fn solution(&self) -> &Solution<T, N, D, C> {
        &self.solution
    }

    /// Solves a scene for a free impulse `f = -M v_free` (N·s).
    ///
    /// It ends when the scene is solved, when it is known not to be, or when it has cost
    /// [`Settings::budget`]. In the last case the answer is the best impulse
    /// whose error was computed (to compute it costs as much as an iteration, so not every iterate's
    /// is), with that error, and [`Self::resume`] goes on. (Another `solve` begins anew, with a warm start
    /// where that is any good; a budget that is always too small for it never gets there.)
    ///
    /// The factor has to be that of the scene's `M` and `H` as they are now: one that was computed before they changed is
    /// refused. One of another scene is not noticed if that has changed as often: sizes and steps of the error are those
    /// of its `W`.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for `f`, [`Error::FactorMismatch`], [`Error::StaleFactor`], [`Error::InvalidTolerance`].
    pub fn solve(
        &mut self,
        scene: &Scene<T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        f: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C>, Error> {
        self.run(scene, factor, f, settings, false)
    }

    /// Goes on with the last solve where its budget ended, for [`Settings::budget`] more.
    ///
    /// Scene, factor, `f` and tolerance are those of that solve. In how many calls it is done makes
    /// no difference to a bit of the solution, and the counts of the solution are those of all
    /// calls; only that a scene is infeasible may be noticed sooner, at the end of a call. After a
    /// solve that has ended the last solution is returned; without one, after [`Self::reset`] or
    /// with another number of contacts, this is [`Self::solve`].
    ///
    /// # Errors
    /// As [`Self::solve`].
    pub fn resume(
        &mut self,
        scene: &Scene<T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        f: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C>, Error> {
        let same = self.solution.contacts.len() == factor.contacts();
        if self.record.is_over() && same {
            Problem::check(scene, factor, f, settings)?;
            return Ok(&self.solution);
        }
        let resumed = same && !self.solve.is_idle();
        self.run(scene, factor, f, settings, resumed)
    }

    fn run(
        &mut self,
        scene: &Scene<T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        f: &SVector<T, N>,
        settings: &Settings<T>,
        resumed: bool,
    ) -> Result<&Solution<T, N, D, C>, Error> {
        Problem::check(scene, factor, f, settings)?;
        if !resumed {
            self.record.forget();
            self.solve.stop();
        }
        let mut problem = Problem::new(scene, factor, f, settings.slip);
        problem.fill();
        let (solution, record) = (&mut self.solution, &mut self.record);
        let mut monitor = Monitor::new(&mut problem, settings, solution, record, resumed);
        if !resumed {
            self.solve
                .begin(&mut monitor, &mut self.workspace, &mut self.warm_start);
        }
        while monitor.is_running() {
            self.solve.advance(&mut monitor, &mut self.workspace);
        }
        self.solve.finish(&mut monitor);
        let contacts = self.solve.contacts();
        self.warm_start.keep(scene.contacts(), contacts, resumed);
        Ok(&self.solution)
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Default for Solver<T, N, D, C> {
    fn default() -> Self {
        Self::new()
    }
}
