//! The default method: Gauss-Seidel or a guess for a start, semismooth Newton to the end, and the central path
//! if that fails.

use crate::error::Error;
use crate::factor::Factor;
use crate::problem::Problem;
use crate::real::Real;
use crate::scene::Scene;
use crate::solution::{Settings, Solution};
use crate::solver::method::Method;
use crate::solver::monitor::Monitor;
use crate::solver::record::{Record, fingerprint};
use crate::solver::warm_start::WarmStart;
use nalgebra::SVector;

mod central_path;
#[cfg(test)]
mod fixtures;
mod infeasible;
mod initial_guess;
mod method;
pub(crate) mod monitor;
mod newton;
mod phases;
pub(crate) mod point;
pub(crate) mod record;
mod rest;
mod state;
mod sweeps;
mod tuning;
pub(crate) mod warm_start;

pub(crate) use infeasible::JAM_BUDGET;
pub use phases::{AllPhases, Phases, SweepsAndNewton, SweepsOnly};
pub(crate) use record::Call;

/// A solver for scenes of `N` velocities, up to `C` contacts of `D` rows and up to `R` joint rows.
///
/// It keeps the last solution, and starts the next solve from it (warm start) as far as the
/// contacts are still there, by their [`crate::Contact::key`]; [`Solver::reset`] forgets it. It
/// never allocates. It has the [`Phases`] of its type: who counts bytes of flash may leave some out.
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
pub struct Solver<
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize = 0,
    P = AllPhases,
> {
    solution: Solution<T, N, D, C, R>,
    warm_start: WarmStart<T, D, C, R>,
    record: Record<T, D, C, R>,
    method: Method<T, D, C, R, P>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>
    Solver<T, N, D, C, R>
{
    /// A solver of all phases that has solved nothing yet; [`Self::with_phases`] makes one of others.
    #[must_use]
    pub const fn new() -> Self {
        Self::with_phases(AllPhases)
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, P: Phases>
    Solver<T, N, D, C, R, P>
{
    /// A solver of these phases, that has solved nothing yet.
    #[must_use]
    pub const fn with_phases(phases: P) -> Self {
        Self {
            solution: Solution::none(),
            warm_start: WarmStart::cold(),
            record: Record::none(),
            method: Method::none(phases),
        }
    }

    /// Forgets the last solve: the next one starts cold. [`Self::solution`] stays, and so does the scene.
    pub fn reset(&mut self) {
        self.warm_start = WarmStart::cold();
        self.record.forget();
        self.method.forget();
    }

    /// Makes it as new, in place.
    pub(crate) fn empty(&mut self) {
        self.reset();
        self.solution.empty();
    }

    /// Starts the next solve at these impulses (N·s), each with the key of its contact or joint row, in place of
    /// the last solution. What is missing starts at zero. Impulses outside their cones are projected.
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
        self.method.forget();
        Ok(())
    }

    /// Tells that nothing moved before the next solve, which is then answered by a solution at rest, if Coulomb's law has one.
    ///
    /// A solver knows by itself whether its last solution was at rest. This is for the first solve, and for that after [`Self::reset`]: a cold
    /// solve of a body at rest may come to another solution, in which it slides ([`crate::guide::error`]).
    ///
    /// ```
    /// # use stiction::Kernel;
    /// let mut kernel = Kernel::<f32, 6, 3, 4>::new();
    /// kernel.solver_mut().presume_rest(); // the crate stands on its slope before we begin
    /// ```
    pub fn presume_rest(&mut self) {
        self.warm_start.presume_rest();
    }

    /// The last solution. After an `Err` it is still that of an earlier solve.
    #[must_use]
    pub const fn solution(&self) -> &Solution<T, N, D, C, R> {
        &self.solution
    }

    /// Solves a scene for a free impulse `M v_free` (N·s), see [`crate::time_stepping::free_impulse`].
    ///
    /// It ends when the scene is solved, when it is proved infeasible (by [`AllPhases`]), when rounding allows no better, or when
    /// [`Settings::budget`] is used up. Unless it is solved, the answer is the best impulse whose error was computed, with that
    /// error. After a budget, [`Self::resume`] continues; another `solve` begins again, with a warm start if that is better than rest.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the free impulse; [`Error::StaleFactor`] unless the factor belongs to the scene's current `M`,
    /// `H` and number of contacts; [`Error::InvalidTolerance`].
    pub fn solve<const S: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, R, S>,
        factor: &Factor<T, N, D, C, R>,
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C, R>, Error> {
        self.run((scene, factor, free_impulse, settings), Call::Begin)
    }

    /// Goes on with a solve that ended as [`crate::Status::OutOfBudget`], or as [`crate::Status::Jammed`] with its budget used up, for
    /// [`Settings::budget`] more.
    ///
    /// Only with scene, free impulse, tolerance and model of that solve: it tells by their fingerprint. Splitting a solve into several calls
    /// gives the same bits as one call, and the work of the solution is that of all calls; only that each call that writes a solution may look
    /// for a proof that the scene is infeasible, once in a solve: such a scene may be noticed sooner, also one that a whole call solves with
    /// large impulses, because it is infeasible by no more than rounding. The question whether a body can stay at rest ends with a call, too, if
    /// a solution is known. Where no solve of such data was paused (the last one has ended, after
    /// [`Self::reset`], with other numbers) this is [`Self::solve`].
    ///
    /// # Errors
    /// As [`Self::solve`]; [`Error::LimitsLeftOut`] after a [`crate::Kernel::solve_with_limits`] whose budget has ended.
    pub fn resume<const S: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, R, S>,
        factor: &Factor<T, N, D, C, R>,
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C, R>, Error> {
        let call = self.paused(|| fingerprint(scene, free_impulse, settings))?;
        self.run((scene, factor, free_impulse, settings), call)
    }

    /// Works for [`Settings::budget`] on a solve, without a solution before the end. Returns whether the solve has ended.
    ///
    /// As [`Self::resume`], for who works on a solve in small pieces: a pause costs hardly more than the data's way to the contacts. Until
    /// the solve has ended [`Self::solution`] is [`crate::Status::Unsolved`]; [`Self::resume`] with a budget of 0 writes down the best so far,
    /// with its error. In what pieces it is done changes no bit.
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
        let call = self.paused(|| fingerprint(scene, free_impulse, settings))?;
        self.go_on((scene, factor, free_impulse, settings), call, false)?;
        Ok(self.record.is_over())
    }

    /// Goes on with a solve that was paused, but for one with limits.
    fn paused(&self, data: impl FnOnce() -> u64) -> Result<Call, Error> {
        if self.record.has_limits() {
            return Err(Error::LimitsLeftOut);
        }
        Ok(self.record.resume(data))
    }

    /// Notes that the solve had limits, if its budget has ended.
    pub(crate) fn note_limits(&mut self) {
        self.record.note_limits();
    }

    /// Takes back what the last solution claims, with which no solve goes on.
    pub(crate) fn invalidate(&mut self) {
        self.record.forget();
        self.solution.disown();
    }

    /// Before what may refuse the first call.
    pub(crate) fn disown_nothing(&mut self) {
        self.solution.disown_nothing();
    }

    /// Did a joint row with this key push in the last solve?
    pub(crate) fn has_pushed(&self, key: u32) -> bool {
        self.warm_start.has_pushed(key)
    }

    /// [`Self::solve`], or the same in place of the last one, to which there are rows more: its work counts as well.
    pub(crate) fn run<const S: usize>(
        &mut self,
        data: Data<'_, T, N, D, C, R, S>,
        call: Call,
    ) -> Result<&Solution<T, N, D, C, R>, Error> {
        self.go_on(data, call, true)?;
        Ok(&self.solution)
    }

    /// Works on a solve, and writes down its solution, if that is wanted also before the end.
    fn go_on<const S: usize>(
        &mut self,
        (scene, factor, free_impulse, settings): Data<'_, T, N, D, C, R, S>,
        call: Call,
        writes: bool,
    ) -> Result<(), Error> {
        self.disown_nothing();
        Problem::check(scene, factor, free_impulse, settings)?;
        if call != Call::Resume {
            self.record.begin();
        }
        let mut problem = Problem::new(scene, factor, free_impulse, settings.model);
        problem.fill(true);
        let (solution, record) = (&mut self.solution, &mut self.record);
        let mut monitor = Monitor::new(&mut problem, settings, solution, record, call);
        if call != Call::Resume {
            self.method.begin(&mut monitor, &mut self.warm_start);
        }
        // What is written is to have its error.
        while monitor.is_running() || writes && monitor.asks_for_error() {
            self.method.advance(&mut monitor, &mut self.warm_start);
        }
        if writes || monitor.is_over() {
            if P::CENTRAL_PATH {
                self.method.end_question(&mut monitor);
            }
            monitor.finish(self.method.impulses());
            // Without a budget there is no work for a search.
            if P::CENTRAL_PATH && settings.budget > 0 {
                monitor.check_infeasibility(self.method.impulses());
            }
        } else {
            monitor.pause();
        }
        let [u, r] = self.method.solution(&problem);
        let replaces = call != Call::Begin;
        self.warm_start.keep(scene, u, r, replaces);
        if call != Call::Resume {
            self.record
                .pause(|| fingerprint(scene, free_impulse, settings));
        }
        Ok(())
    }
}

/// The data of a call: scene, factor, free impulse and settings.
type Data<'a, T, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize> = (
    &'a Scene<T, N, D, C, R, S>,
    &'a Factor<T, N, D, C, R>,
    &'a SVector<T, N>,
    &'a Settings<T>,
);

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize> Default
    for Solver<T, N, D, C, R>
{
    fn default() -> Self {
        Self::new()
    }
}
