//! Scene, factor and solver in one value.

use crate::derivative::Derivative;
use crate::error::Error;
use crate::factor::Factor;
use crate::loads::LeastImpulses;
use crate::problem::Age;
use crate::real::Real;
use crate::scene::Scene;
use crate::solution::{Settings, Solution, Violation};
use crate::solver::{AllPhases, Call, Phases, Solver};
use core::mem;
use nalgebra::SVector;

mod limits;
mod parts;
mod worst_case;

pub use parts::{ContactOf, FreeImpulseOf, JointRowOf, Parts, SceneOf, SolutionOf};

/// A scene, its factor and its solver in one value, for a `static`.
///
/// A kernel computes its factor again when `M`, a Jacobian, a compliance, or the velocities, contacts and joint rows in use have changed. It
/// does so, too, when a solve begins after a call that has not solved its scene: a bit that has flipped in the memory of the factor spoils no second
/// tick. The type parameter `P` names the [`Phases`] of its solver; the default is all phases.
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
    /// Did the last call fail to solve its scene? The factor may be to blame: its memory may have changed.
    in_doubt: bool,
    /// New if the factor was computed since the last solve began.
    factor_age: Age,
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
        let solver = Solver::with_phases(phases);
        Self { scene: Scene::new(), factor: Factor::empty(), solver, in_doubt: false, factor_age: Age::New }
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
        self.in_doubt = false;
    }

    /// Index of the contact with the largest residual in the last solution ([`Solution::worst_contact`]).
    #[must_use]
    pub fn worst_contact(&self) -> Option<usize> {
        let solution = self.solution();
        solution.worst_contact(&self.scene, &self.factor)
    }

    /// The largest violations of the laws in the last solution, in m/s and N·s ([`Solution::violation`]).
    #[must_use]
    pub fn violation(&self) -> Violation<T> {
        self.solution().violation(&self.scene, &self.factor)
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

    /// The factor of the last call, stale if the scene has changed since.
    #[must_use]
    pub const fn factor(&self) -> &Factor<T, N, D, C, R> {
        &self.factor
    }

    /// Its solver, with the warm start of the next solve.
    #[must_use]
    pub const fn solver(&self) -> &Solver<T, N, D, C, R, P> {
        &self.solver
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
        self.run(Call::Begin, (free_impulse, settings), true)?;
        Ok(self.solver.solution())
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
        let call = self.solver.resumed(&self.scene, free_impulse, settings)?;
        self.run(call, (free_impulse, settings), true)?;
        Ok(self.solver.solution())
    }

    /// Works on a solve for one [`Settings::budget`] and returns true if it has ended, as [`Solver::advance`].
    ///
    /// # Errors
    /// As [`Factor::prepare`] and [`Solver::resume`].
    pub fn advance(&mut self, free_impulse: &SVector<T, N>, settings: &Settings<T>) -> Result<bool, Error> {
        let call = self.solver.resumed(&self.scene, free_impulse, settings)?;
        self.run(call, (free_impulse, &settings.of_a_piece()), false)
    }

    /// Works on a solve, and returns true if it has ended. `writes`: writes a solution also at the end of the budget.
    fn run(
        &mut self,
        call: Call,
        (free_impulse, settings): (&SVector<T, N>, &Settings<T>),
        writes: bool,
    ) -> Result<bool, Error> {
        self.prepare_to_solve(call)?;
        let data = (&self.scene, &self.factor, free_impulse, settings);
        let result = self.solver.work(data, call, writes);
        self.note_doubt(result.is_err());
        result
    }

    /// Notes whether a call, which may be refused, has not solved its scene.
    fn note_doubt(&mut self, is_refused: bool) {
        self.in_doubt = is_refused || !self.solution().is_solved();
    }

    /// Derivative of the last solution with respect to its data, as [`Derivative::new`]. The scene and the model have to be those of the
    /// solve.
    ///
    /// # Errors
    /// As [`Derivative::new`].
    pub fn derivative(&self, settings: &Settings<T>) -> Result<Derivative<'_, T, N, D, C, R, S>, Error> {
        Derivative::new(&self.scene, &self.factor, self.solution(), settings)
    }

    /// The least impulses of the last solution, those of springs of equal stiffness, as [`LeastImpulses::new`].
    ///
    /// # Errors
    /// As [`LeastImpulses::new`].
    pub fn least_impulses(&self, settings: &Settings<T>) -> Result<LeastImpulses<T, D, C, R>, Error> {
        LeastImpulses::new(&self.scene, &self.factor, self.solution(), settings)
    }

    /// How near to slipping the last solution is ([`Solution::slip_reserve`]): the least share of friction with which what sticks still sticks.
    ///
    /// # Errors
    /// As [`LeastImpulses::new`].
    pub fn slip_reserve(&self, settings: &Settings<T>) -> Result<T, Error> {
        self.solution().slip_reserve(&self.scene, &self.factor, settings)
    }

    /// The largest factor on a further impulse with which what sticks still sticks, by the relaxation ([`Solution::load_reserve`]).
    ///
    /// # Errors
    /// As [`Solution::load_reserve`].
    pub fn load_reserve(&self, load: &SVector<T, N>, settings: &Settings<T>) -> Result<T, Error> {
        self.solution().load_reserve(&self.scene, &self.factor, load, settings)
    }

    /// The least share of friction with which all bodies could stay at rest ([`Scene::rest_reserve`]).
    ///
    /// # Errors
    /// As [`Scene::rest_reserve`] and [`Factor::prepare`].
    pub fn rest_reserve(&mut self, free_impulse: &SVector<T, N>, settings: &Settings<T>) -> Result<T, Error> {
        self.prepare()?;
        self.scene.rest_reserve(&self.factor, free_impulse, settings)
    }

    /// Computes the factor now if `M`, a Jacobian, a compliance, or the contacts and joint rows in use have changed, or if the last call has not
    /// solved its scene. Without this call the next solve does so.
    ///
    /// # Errors
    /// As [`Factor::prepare`].
    pub fn prepare(&mut self) -> Result<(), Error> {
        self.prepare_for(Call::Begin)
    }

    /// Computes the factor if it has to, and tells the solver of a solve that begins how old it is.
    fn prepare_to_solve(&mut self, call: Call) -> Result<(), Error> {
        self.prepare_for(call)?;
        if call == Call::Begin {
            self.solver.set_factor_age(mem::replace(&mut self.factor_age, Age::Old));
        }
        Ok(())
    }

    /// Computes the factor if the scene has changed, or if it is in doubt and the call begins a solve.
    fn prepare_for(&mut self, call: Call) -> Result<(), Error> {
        self.solver.invalidate_if_unsolved();
        let in_doubt = self.in_doubt && call == Call::Begin;
        if !in_doubt && self.factor.is_current(&self.scene) {
            return Ok(());
        }
        self.in_doubt = false;
        self.factor_age = Age::New;
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

#[cfg(test)]
mod tests;
