//! Scene, factor and solver in one value.

use crate::derivative::Derivative;
use crate::error::Error;
use crate::factor::Factor;
use crate::real::Real;
use crate::scene::Scene;
use crate::solution::{Settings, Solution};
use crate::solver::{AllPhases, Phases, Solver};
use nalgebra::SVector;

mod limits;
mod worst_case;

/// A scene, its factor and its solver in one value, for a `static`.
///
/// A kernel computes its factor again when `M`, a Jacobian, a compliance, or the velocities, contacts and joint rows in use have changed. The
/// type parameter `P` names the [`Phases`] of its solver; the default is all phases.
///
/// ```
/// use nalgebra::{Matrix2, matrix, vector};
/// use stiction::{Contact, Kernel, Settings};
///
/// let mut kernel = Kernel::<f32, 2, 2, 1>::new(); // `const`
/// let scene = kernel.scene_mut();
/// scene.set_mass(&(Matrix2::identity() * 2.0))?;
/// scene.push(&Contact {
///     jacobian: matrix![0.0, 1.0; 1.0, 0.0],
///     offset: vector![0.0, 0.0],
///     mu: 0.5,
///     key: 0,
/// })?;
/// let solution = kernel.solve(&vector![0.0, -0.2], &Settings::default())?;
/// assert!(solution.is_solved() && solution.velocity.norm() < 1e-5);
/// # Ok::<(), stiction::Error>(())
/// ```
///
/// In a `static`, behind the mutex of the platform (`critical_section::Mutex` with a `RefCell` in firmware); a `static mut`
/// inside the `main` of `cortex_m_rt::entry` does as well (`examples/firmware`):
///
/// ```
/// use nalgebra::SVector;
/// use std::sync::Mutex;
/// use stiction::{Kernel, Settings};
///
/// static QUADRUPED: Mutex<Kernel<f32, 18, 3, 4>> = Mutex::new(Kernel::new()); // all zeros: no flash
///
/// let mut kernel = QUADRUPED.lock().unwrap();
/// let refused = kernel.solve(&SVector::zeros(), &Settings::default()); // it has no mass yet
/// assert!(refused.is_err());
/// ```
#[derive(Clone, Debug)]
pub struct Kernel<
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize = 0,
    const S: usize = 0,
    P = AllPhases,
> {
    scene: Scene<T, N, D, C, R, S>,
    factor: Factor<T, N, D, C, R>,
    solver: Solver<T, N, D, C, R, P>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Kernel<T, N, D, C, R, S>
{
    /// A new kernel: an empty scene, and a solver with all phases; [`Self::with_phases`] chooses others.
    #[must_use]
    pub const fn new() -> Self {
        Self::with_phases(AllPhases)
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize, P: Phases>
    Kernel<T, N, D, C, R, S, P>
{
    /// A new kernel: an empty scene, and a solver with these phases.
    #[must_use]
    pub const fn with_phases(phases: P) -> Self {
        Self { scene: Scene::new(), factor: Factor::empty(), solver: Solver::with_phases(phases) }
    }

    /// Makes the kernel as new: `N` velocities, no mass, no contacts and joint rows, no factor, nothing solved. It works in place, without a copy on the stack.
    ///
    /// [`Solver::reset`] forgets the last solve alone, and [`Scene::clear`] removes contacts and joint rows alone.
    ///
    /// ```
    /// # use nalgebra::{Matrix2, vector};
    /// # use stiction::{Error, Kernel, Settings};
    /// let mut kernel = Kernel::<f32, 2, 2, 1>::new();
    /// kernel.scene_mut().set_mass(&Matrix2::identity())?;
    /// kernel.reset();
    /// let refused = kernel.solve(&vector![0.0, 0.0], &Settings::default());
    /// assert!(refused.is_err()); // it has no mass
    /// # Ok::<(), Error>(())
    /// ```
    pub fn reset(&mut self) {
        self.scene.reset();
        self.factor.clear();
        self.solver.empty();
    }

    /// Index of the contact with the largest residual in the last solution ([`Solution::worst_contact`]).
    #[must_use]
    pub fn worst_contact(&self, settings: &Settings<T>) -> Option<usize> {
        let solution = self.solution();
        solution.worst_contact(&self.scene, &self.factor, settings)
    }

    /// The scene.
    #[must_use]
    pub const fn scene(&self) -> &Scene<T, N, D, C, R, S> {
        &self.scene
    }

    /// The scene, to be filled or changed.
    pub const fn scene_mut(&mut self) -> &mut Scene<T, N, D, C, R, S> {
        &mut self.scene
    }

    /// The solver, for [`Solver::reset`] and [`Solver::set_impulses`].
    pub const fn solver_mut(&mut self) -> &mut Solver<T, N, D, C, R, P> {
        &mut self.solver
    }

    /// The last solution. After an `Err` it is that of an earlier solve, or [`crate::Status::Unsolved`] after
    /// [`Self::solve_with_limits`].
    #[must_use]
    pub const fn solution(&self) -> &Solution<T, N, D, C, R> {
        self.solver.solution()
    }

    /// Solves the scene for a free impulse `M v_free` (N·s), as [`Solver::solve`]. If it has to, it computes the factor first
    /// (`N³/6 + m N²/2 + m² N/2` multiplications for `m` contact and joint rows).
    ///
    /// # Errors
    /// As [`Factor::prepare`] and [`Solver::solve`].
    pub fn solve(
        &mut self,
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C, R>, Error> {
        self.prepare()?;
        let solver = &mut self.solver;
        solver.solve(&self.scene, &self.factor, free_impulse, settings)
    }

    /// Continues a solve whose budget was used up, as [`Solver::resume`].
    ///
    /// # Errors
    /// As [`Factor::prepare`] and [`Solver::resume`].
    pub fn resume(
        &mut self,
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C, R>, Error> {
        self.prepare()?;
        let solver = &mut self.solver;
        solver.resume(&self.scene, &self.factor, free_impulse, settings)
    }

    /// Works on a solve for one [`Settings::budget`] and returns true if it has ended, as [`Solver::advance`].
    ///
    /// # Errors
    /// As [`Factor::prepare`] and [`Solver::resume`].
    pub fn advance(&mut self, free_impulse: &SVector<T, N>, settings: &Settings<T>) -> Result<bool, Error> {
        self.prepare()?;
        let solver = &mut self.solver;
        solver.advance(&self.scene, &self.factor, free_impulse, settings)
    }

    /// Derivative of the last solution with respect to its data, as [`Derivative::new`]. The scene and the settings have to be those of the
    /// solve.
    ///
    /// # Errors
    /// As [`Derivative::new`].
    pub fn derivative(&self, settings: &Settings<T>) -> Result<Derivative<'_, T, N, D, C, R, S>, Error> {
        Derivative::new(&self.scene, &self.factor, self.solution(), settings)
    }

    /// Computes the factor now if `M`, a Jacobian, a compliance, or the contacts and joint rows in use have changed. Without this
    /// call the next solve does so.
    ///
    /// # Errors
    /// As [`Factor::prepare`].
    pub fn prepare(&mut self) -> Result<(), Error> {
        self.solver.invalidate_if_unsolved();
        if self.factor.is_current(&self.scene) {
            return Ok(());
        }
        self.factor.prepare(&self.scene)
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize> Default
    for Kernel<T, N, D, C, R, S>
{
    fn default() -> Self {
        Self::new()
    }
}
