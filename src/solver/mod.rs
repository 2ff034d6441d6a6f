//! [`Solver`]: Gauss-Seidel sweeps or a guess to begin, semismooth Newton steps to finish, and the central path (an interior-point
//! method) where Newton's method fails. [`crate::guide::method`] explains the method.

use crate::error::Error;
use crate::factor::Factor;
use crate::problem::Problem;
use crate::real::Real;
use crate::scene::Scene;
use crate::solution::{Settings, Solution};
use crate::solver::monitor::Monitor;
use crate::solver::record::Record;
use crate::solver::solve::Solve;
use crate::solver::state::State;
use crate::solver::warm_start::WarmStart;
use core::marker::PhantomData;
use nalgebra::SVector;

mod central_path;
mod check;
#[cfg(test)]
mod fixtures;
mod for_kernel;
mod infeasible;
mod initial_guess;
mod method;
pub(crate) mod monitor;
mod newton;
mod phases;
mod point;
pub(crate) mod record;
mod refinement;
mod rest;
mod solve;
mod start;
mod state;
mod sweeps;
mod tuning;
pub(crate) mod warm_start;

pub(crate) use infeasible::JAM_BUDGET;
pub use phases::{AllPhases, Phases, SweepsAndNewton, SweepsOnly};
pub(crate) use record::Call;

/// A solver for scenes of `N` velocities, up to `C` contacts of `D` rows and up to `R` joint rows.
///
/// A solver keeps its last solution. The next solve starts from it (warm start): each contact and joint row from the one with the same
/// [`crate::Contact::key`]. [`Solver::reset`] forgets it. A solver never allocates. The type parameter `P` names its [`Phases`]; fewer of
/// them save flash.
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
pub struct Solver<T: Real, const N: usize, const D: usize, const C: usize, const R: usize = 0, P = AllPhases>
{
    solution: Solution<T, N, D, C, R>,
    warm_start: WarmStart<T, D, C, R>,
    record: Record<T, D, C, R>,
    state: State<T, D, C, R>,
    phases: PhantomData<P>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize> Solver<T, N, D, C, R> {
    /// A new solver with all phases; [`Self::with_phases`] chooses others.
    #[must_use]
    pub const fn new() -> Self {
        Self::with_phases(AllPhases)
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, P: Phases>
    Solver<T, N, D, C, R, P>
{
    /// A new solver with these phases.
    #[must_use]
    pub const fn with_phases(_: P) -> Self {
        Self {
            solution: Solution::none(),
            warm_start: WarmStart::cold(),
            record: Record::none(),
            state: State::none(),
            phases: PhantomData,
        }
    }

    /// Forgets the last solve: the next one starts cold. [`Self::solution`] stays, and so does the scene.
    pub fn reset(&mut self) {
        self.warm_start = WarmStart::cold();
        self.record.forget();
        self.state.forget();
    }

    /// Makes the solver as new, in place.
    pub(crate) fn empty(&mut self) {
        self.reset();
        self.solution.empty();
    }

    /// Sets the impulses (N·s) at which the next solve starts, in place of the last solution: each with the key of its contact or joint row.
    ///
    /// Contacts and joint rows that are not listed start at zero. Impulses outside their cones are projected. If all impulses together have a
    /// larger error than zero impulses, they are ignored.
    ///
    /// ```
    /// # use nalgebra::{Matrix2, matrix, vector};
    /// # use stiction::{Contact, Factor, Scene, Settings, Solver};
    /// # let mut scene = Scene::<f64, 2, 2, 1>::new();
    /// # scene.set_mass(&(Matrix2::identity() * 2.0))?;
    /// # scene.push(&Contact { jacobian: matrix![0.0, 1.0; 1.0, 0.0], offset: vector![0.0, 0.0], mu: 0.5, key: 7 })?;
    /// # let factor = Factor::new(&scene)?;
    /// # let mut solver = Solver::new();
    /// solver.set_impulses(&[(7, vector![0.2, 0.0])], &[])?; // N·s, normal first
    /// let solution = solver.solve(&scene, &factor, &vector![0.0, -0.2], &Settings::default())?;
    /// assert_eq!(solution.work.total(), 0); // they were the solution
    /// # Ok::<(), stiction::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::ListFull`] if there are more than `C` or `R`, [`Error::NotFinite`].
    pub fn set_impulses(
        &mut self,
        contacts: &[(u32, SVector<T, D>)],
        rows: &[(u32, T)],
    ) -> Result<(), Error> {
        self.warm_start.set(contacts, rows)?;
        self.record.forget();
        self.state.forget();
        Ok(())
    }

    /// Where the next solve starts.
    #[must_use]
    pub const fn warm_start(&self) -> &WarmStart<T, D, C, R> {
        &self.warm_start
    }

    /// Starts the next solve where another solver would start it. What is kept beside that, as a matrix of the last solve, is forgotten: the solver that
    /// it comes from goes on with the same bits if it is given its own.
    pub fn set_warm_start(&mut self, warm_start: WarmStart<T, D, C, R>) {
        self.warm_start = warm_start;
        self.record.forget();
        self.state.forget();
    }

    /// Declares that nothing moved before the next solve. That solve returns a solution at rest if Coulomb's law has one.
    ///
    /// Call it before the first solve, or after [`Self::reset`]: a cold solve of a body at rest may find another solution, in which it slides
    /// ([`crate::guide::error`]). Later the solver knows whether its last solution was at rest.
    ///
    /// ```
    /// # use stiction::Kernel;
    /// let mut kernel = Kernel::<f32, 6, 3, 4>::new();
    /// kernel.solver_mut().presume_rest(); // the crate stands on its slope before we begin
    /// ```
    pub fn presume_rest(&mut self) {
        self.warm_start.presumes_rest = true;
    }

    /// The last solution. After an `Err` it is the solution of an earlier solve.
    #[must_use]
    pub const fn solution(&self) -> &Solution<T, N, D, C, R> {
        &self.solution
    }

    /// Solves a scene for a free impulse `M v_free` (N·s), see [`crate::time_stepping::free_impulse`].
    ///
    /// It ends when the scene is solved, when it is proved infeasible (by [`AllPhases`]), when rounding allows no better, or when
    /// [`Settings::budget`] is used up. If the scene is not solved, the solution holds the best impulses so far, with their error. After the
    /// end of a budget [`Self::resume`] continues; another `solve` begins again, with a warm start if that is better than zero impulses.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the free impulse; [`Error::StaleFactor`]; [`Error::SceneIncomplete`];
    /// [`Error::InvalidTolerance`].
    pub fn solve<const S: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, R, S>,
        factor: &Factor<T, N, D, C, R>,
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C, R>, Error> {
        self.run((scene, factor, free_impulse, settings), Call::Begin)
    }

    /// Continues a solve whose budget was used up, for one more [`Settings::budget`]. Its status is [`crate::Status::OutOfBudget`] or
    /// [`crate::Status::Jammed`].
    ///
    /// Scene, free impulse, tolerance and model have to be those of that solve: the solver compares their fingerprint. If they differ, if the
    /// last solve has ended, and after [`Self::reset`], this is [`Self::solve`].
    ///
    /// Several calls give the same bits as one call, and the work of the solution is that of all calls. There are three exceptions.
    /// At the end of its budget a call may look for a proof that the scene is infeasible (once in a solve). So several calls may
    /// find a proof sooner. They may also find one for a scene that is infeasible by rounding alone, which one call solves with
    /// large impulses. If a solution is known at the end of a call, the solver no longer asks whether a body can stay at
    /// rest. And a call that ends unsolved computes the error of the best impulses: it may find that they solve the scene although their
    /// estimate does not say so.
    ///
    /// # Errors
    /// As [`Self::solve`]; [`Error::LimitsLeftOut`] if the paused solve has limits: [`crate::Kernel::resume_with_limits`] continues it.
    pub fn resume<const S: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, R, S>,
        factor: &Factor<T, N, D, C, R>,
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C, R>, Error> {
        let call = self.resumed(scene, free_impulse, settings)?;
        self.run((scene, factor, free_impulse, settings), call)
    }

    /// Works for one [`Settings::budget`] on a solve, and writes a solution only at its end. Returns true if the solve has ended.
    ///
    /// It continues or begins a solve as [`Self::resume`] does, and is for solves in small pieces: a pause costs little more than the
    /// velocities of the free motion. The size of the pieces changes no bit. A budget of 0 counts as 1, so the solve ends. Until then,
    /// [`Self::solution`] is [`crate::Status::Unsolved`]; [`Self::resume`] with a budget of 0 writes the best solution so far, with its error.
    ///
    /// # Errors
    /// As [`Self::resume`].
    pub fn advance<const S: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, R, S>,
        factor: &Factor<T, N, D, C, R>,
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<bool, Error> {
        let call = self.resumed(scene, free_impulse, settings)?;
        self.work((scene, factor, free_impulse, &settings.of_a_piece()), call, false)
    }

    /// Runs a call and returns the solution that it writes.
    fn run<const S: usize>(
        &mut self,
        data: Data<'_, T, N, D, C, R, S>,
        call: Call,
    ) -> Result<&Solution<T, N, D, C, R>, Error> {
        self.work(data, call, true)?;
        Ok(&self.solution)
    }

    /// Works on a solve until its end or the end of the budget. Writes the solution at the end of the solve, with `writes` also at the end of
    /// the budget. Returns true if the solve has ended.
    #[inline(never)] // one copy for all calls of a size: `.ci/solvers` counts them
    pub(crate) fn work<const S: usize>(
        &mut self,
        (scene, factor, free_impulse, settings): Data<'_, T, N, D, C, R, S>,
        call: Call,
        writes: bool,
    ) -> Result<bool, Error> {
        self.invalidate_if_unsolved();
        Problem::check(scene, factor, free_impulse, settings)?;
        if call != Call::Resume {
            self.record.begin();
        }
        let mut problem = Problem::new(scene, factor, free_impulse, settings, self.record.factor_age);
        problem.fill(true);
        let (solution, record) = (&mut self.solution, &mut self.record);
        let monitor = Monitor::new(&mut problem, settings, solution, record, call);
        let (state, warm_start) = (&mut self.state, &mut self.warm_start);
        Solve { monitor, state, warm_start, phases: PhantomData::<P> }.run(writes);
        if call != Call::Resume {
            self.record.pause(|| Problem::fingerprint(scene, free_impulse, settings));
        }
        Ok(self.record.is_over())
    }
}

/// The data of a call: scene, factor, free impulse and settings.
type Data<'a, T, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize> =
    (&'a Scene<T, N, D, C, R, S>, &'a Factor<T, N, D, C, R>, &'a SVector<T, N>, &'a Settings<T>);

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize> Default
    for Solver<T, N, D, C, R>
{
    fn default() -> Self {
        Self::new()
    }
}
