//! The default method: Gauss-Seidel or a guess for a start, semismooth Newton to the end, and an interior-point method
//! if that fails.

use crate::laws::{Coulomb, Laws};
use crate::problem::Problem;
use crate::solver::calls::{Calls, Data, Method};
use crate::solver::monitor::Monitor;
use crate::solver::phases::Solve;
use crate::solver::warm_start::WarmStart;
use crate::solver::workspace::Workspace;
use crate::{Error, Factor, Real, Scene, Settings, Solution};
use nalgebra::SVector;

mod admm_solver;
mod calls;
mod contact_by_contact;
mod doubt;
#[cfg(test)]
mod fixtures;
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
mod relaxed_sweep;
mod row_keys;
mod row_sweep;
mod several_tangents;
mod sweeps;
mod tuning;
mod warm_start;
mod workspace;

pub use crate::admm::{Acceleration, SlipUpdate};
pub use admm_solver::AdmmSolver;
pub(crate) use calls::Call;

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
/// let push = vector![5.0 * 0.01, -2.0 * 9.81 * 0.01]; // the free impulse M v_free, N·s
/// let solution = solver.solve(&scene, &factor, &push, &Settings::default())?;
/// assert_eq!(solution.contacts[0].mode, ContactMode::Stick);
/// # Ok::<(), stiction::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Solver<T: Real, const N: usize, const D: usize, const C: usize, L: Laws = Coulomb> {
    calls: Calls<T, N, D, C, L>,
    method: Hybrid<T, D, C, L>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, L: Laws> Solver<T, N, D, C, L> {
    /// A solver that has solved nothing yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            calls: Calls::none(),
            method: Hybrid {
                solve: Solve::none(),
                workspace: Workspace::none(),
            },
        }
    }

    /// Forgets the last solve: the next one starts cold. [`Self::solution`] stays what it is.
    pub fn reset(&mut self) {
        self.calls.reset();
        self.method.workspace.forget();
    }

    /// Starts the next solve at these impulses (N·s), each with the [`crate::Contact::key`] of its contact, in place of
    /// the last solution. Contacts whose key is missing start at zero. Impulses outside their cones are projected.
    /// Impulses whose error exceeds that of zero impulses are ignored.
    ///
    /// ```
    /// # use nalgebra::{Matrix2, matrix, vector};
    /// # use stiction::{Contact, Factor, Scene, Settings, Solver};
    /// # let mut scene = Scene::<f64, 2, 2, 1>::new();
    /// # scene.set_mass(&(Matrix2::identity() * 2.0))?;
    /// # scene.push(&Contact { jacobian: matrix![0.0, 1.0; 1.0, 0.0], offset: vector![0.0, 0.0], mu: 0.5, key: 7 })?;
    /// # let factor = Factor::new(&scene)?;
    /// # let mut solver = Solver::new();
    /// solver.set_impulses(&[(7, vector![0.2, 0.0])])?; // N·s, normal first
    /// let solution = solver.solve(&scene, &factor, &vector![0.0, -0.2], &Settings::default())?;
    /// assert_eq!(solution.work.total(), 0); // they were the solution
    /// # Ok::<(), stiction::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::ContactListFull`] if there are more than `C`, [`Error::NotFinite`].
    pub fn set_impulses(&mut self, impulses: &[(u32, SVector<T, D>)]) -> Result<(), Error> {
        self.calls.set_impulses(impulses)?;
        self.method.workspace.forget();
        Ok(())
    }

    /// The last solution. After an `Err` it is still that of an earlier solve.
    #[must_use]
    pub const fn solution(&self) -> &Solution<T, N, D, C, L> {
        &self.calls.solution
    }

    /// Solves a scene for a free impulse `M v_free` (N·s), see [`crate::time_stepping::free_impulse`].
    ///
    /// It ends when the scene is solved, when it is proved infeasible, when rounding allows no better, or when
    /// [`Settings::budget`] is used up. Unless it is solved, the answer is the best impulse whose error was computed, with that
    /// error. After a budget, [`Self::resume`] continues; another `solve` begins again, with a warm start if that is better than rest.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the free impulse; [`Error::StaleFactor`] unless the factor belongs to the scene's current `M`,
    /// `H` and number of contacts; [`Error::InvalidTolerance`]; [`Error::InvalidFriction`], only in a scene from
    /// [`Scene::from_parts`].
    pub fn solve(
        &mut self,
        scene: &Scene<T, N, D, C, L>,
        factor: &Factor<T, N, D, C, L>,
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C, L>, Error> {
        self.run((scene, factor, free_impulse, settings), Call::Begin)
    }

    /// Goes on with a solve that ended as [`crate::Status::OutOfBudget`], for [`Settings::budget`] more.
    ///
    /// Scene, factor, free impulse, tolerance and model have to be those of that solve. Splitting a solve into several calls
    /// gives the same bits as one call, and the work of the solution is that of all calls; only that a scene is
    /// infeasible may be noticed sooner, at the end of a call. Where no solve was paused (the last one has ended, after
    /// [`Self::reset`], with another number of contacts) this is [`Self::solve`].
    ///
    /// # Errors
    /// As [`Self::solve`].
    pub fn resume(
        &mut self,
        scene: &Scene<T, N, D, C, L>,
        factor: &Factor<T, N, D, C, L>,
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C, L>, Error> {
        let data = (scene, factor, free_impulse, settings);
        self.calls.resume(&mut self.method, data)
    }

    /// Takes back what the last solution claims, with which no solve goes on.
    pub(crate) fn disown(&mut self) {
        self.calls.disown();
    }

    /// Did a joint row with this key push in the last solve?
    pub(crate) fn has_pushed(&self, key: u32) -> bool {
        self.calls.warm_start.has_pushed(key)
    }

    /// [`Self::solve`], or the same in place of the last one, to which there are slots more: its work counts as well.
    pub(crate) fn run(
        &mut self,
        data: Data<'_, T, N, D, C, L>,
        call: Call,
    ) -> Result<&Solution<T, N, D, C, L>, Error> {
        self.calls.run(&mut self.method, data, call)
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, L: Laws> Default
    for Solver<T, N, D, C, L>
{
    fn default() -> Self {
        Self::new()
    }
}

/// The default method, see `phases`.
#[derive(Clone, Debug)]
struct Hybrid<T: Real, const D: usize, const C: usize, L: Laws = Coulomb> {
    solve: Solve<T, D, C, L>,
    workspace: Workspace<T, D, C, L>,
}

impl<T: Real, const D: usize, const C: usize, L: Laws> Method<T, D, C, L> for Hybrid<T, D, C, L> {
    const SEEKS_PROOF: bool = true;

    fn begin<const N: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, L>,
        warm_start: &mut WarmStart<T, D, C, L>,
    ) {
        self.solve.begin(monitor, &mut self.workspace, warm_start);
    }

    fn advance<const N: usize>(&mut self, monitor: &mut Monitor<'_, '_, T, N, D, C, L>) {
        self.solve.advance(monitor, &mut self.workspace);
    }

    fn contacts<const N: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C, L>,
    ) -> impl Iterator<Item = (SVector<T, D>, SVector<T, D>)> {
        self.solve.contacts(problem)
    }

    fn impulses(&self) -> impl Iterator<Item = SVector<T, D>> {
        self.solve.point.r.iter().map(|&r| r.into())
    }
}
