//! The solver: settings, status, solution, and the loop that stops on the promised error.

use crate::admm::{Acceleration, Fast, Iterate, Plain, Restart, iterate};
use crate::factor::{ContactVector, Factor};
use crate::problem::Problem;
use crate::residual::quotient;
use crate::{Error, Real, Scene};
use heapless::Vec;
use nalgebra::{ArrayStorage, SVector};

/// When the tangential speed `s` in `b(s) = w + mu s e_N` is updated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlipUpdate {
    /// At every iteration, `s_i = |ũ_Ti|` (default).
    EveryIteration,
    /// In an outer loop, each time the convex problem with `s` frozen is solved.
    OuterLoop,
    /// Never, `s = 0`: the convex relaxation, in which a sliding contact lifts off at `mu |u_T|`.
    /// The error is then that of the relaxation, without `mu |u_T|`.
    Never,
}

/// How exactly and how long to solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings<T> {
    /// Error below which a solution counts as solved (dimensionless); see [`Solution::error`].
    pub tolerance: T,
    /// Largest number of iterations.
    pub max_iterations: usize,
    /// When `s` is updated.
    pub slip: SlipUpdate,
}

impl<T> Settings<T> {
    /// Settings for Coulomb's law with at most 1000 iterations.
    pub const fn new(tolerance: T) -> Self {
        Self {
            tolerance,
            max_iterations: 1000,
            slip: SlipUpdate::EveryIteration,
        }
    }
}

impl<T: Real> Default for Settings<T> {
    /// Tolerance 1e-4, which `f32` reaches as well.
    fn default() -> Self {
        Self::new(T::literal(1e-4))
    }
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Status {
    /// The error is at most the tolerance.
    Solved,
    /// It is not; the solution is the best that was found.
    MaxIterations,
}

/// What a contact does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactMode {
    /// No impulse.
    Open,
    /// An impulse inside the friction cone, no relative velocity.
    Stick,
    /// An impulse on the boundary of the friction cone.
    Slip,
}

/// One contact of a [`Solution`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactSolution<T, const D: usize> {
    /// Contact impulse `r_i` (N·s), normal first.
    pub impulse: SVector<T, D>,
    /// Relative velocity `u_i = H_i v + w_i` (m/s), normal first.
    pub velocity: SVector<T, D>,
    /// Open, stick or slip.
    pub mode: ContactMode,
}

/// The outcome of a solve.
#[derive(Clone, Debug)]
pub struct Solution<T, const N: usize, const D: usize, const C: usize> {
    /// Generalised velocity `v` at the end of the step.
    pub velocity: SVector<T, N>,
    /// The contacts, in the order of the scene.
    pub contacts: Vec<ContactSolution<T, D>, C>,
    /// Whether the error is below the tolerance.
    pub status: Status,
    /// Iterations done.
    pub iterations: usize,
    /// Error of `v` and `r` in Coulomb's law and in the dynamics, the larger of
    /// `|r - Π_K(r - alpha û)| / max(|r|, |alpha q|)` and
    /// `|M v + f - Hᵀ r| / max(|f|, |M v|, |Hᵀ r|)`, with a bound on the rounding in its own
    /// evaluation added. Independent of units.
    pub error: T,
}

/// A solver for scenes of `N` velocities and up to `C` contacts of `D` rows.
///
/// It keeps the last solution, and starts the next solve from it (warm start) as far as the
/// contacts are still there; [`Solver::reset`] forgets it. It never allocates.
///
/// ```
/// use nalgebra::{Matrix2, matrix, vector};
/// use stiction::{Contact, ContactMode, Factor, Scene, Settings, Solver};
///
/// // 2 kg on a floor (x, height), pushed for 10 ms by 5 N sideways.
/// let mut scene = Scene::<f64, 2, 2, 1>::new();
/// scene.set_mass(&(2.0 * Matrix2::identity()))?;
/// scene.push(&Contact {
///     jacobian: matrix![0.0, 1.0; 1.0, 0.0],
///     offset: vector![0.0, 0.0],
///     mu: 0.5,
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
    /// `ũ` and `r` of the last solve, for those that have them.
    state: [Option<State<T, D>>; C],
    solution: Solution<T, N, D, C>,
}

/// What a warm start keeps of a contact.
#[derive(Clone, Copy, Debug)]
struct State<T, const D: usize> {
    u: SVector<T, D>,
    r: SVector<T, D>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Solver<T, N, D, C> {
    /// A solver that has solved nothing yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            state: [None; C],
            solution: Solution {
                velocity: zeros(),
                contacts: Vec::new(),
                status: Status::MaxIterations,
                iterations: 0,
                error: T::ZERO,
            },
        }
    }

    /// Forgets the last solution: the next solve starts cold.
    pub fn reset(&mut self) {
        self.state = [None; C];
    }

    /// Tells the next solve which contact of the last one each of its contacts was; `None` for a
    /// contact that was just made. Contacts that `previous` does not list start cold.
    pub fn carry_over(&mut self, previous: &[Option<usize>]) {
        let last = self.state;
        self.reset();
        for (state, index) in self.state.iter_mut().zip(previous) {
            *state = index.and_then(|index| last.get(index).copied().flatten());
        }
    }

    /// The last solution.
    #[must_use]
    pub const fn solution(&self) -> &Solution<T, N, D, C> {
        &self.solution
    }

    /// Solves by the default method, [`Self::solve_restart`].
    ///
    /// # Errors
    /// [`Error::NotFinite`] for `f`, [`Error::FactorMismatch`].
    pub fn solve(
        &mut self,
        scene: &Scene<T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        f: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C>, Error> {
        self.solve_restart(scene, factor, f, settings)
    }

    /// Solves by ADMM without acceleration.
    ///
    /// `f = -M v_free` is minus the free impulse (N·s).
    ///
    /// # Errors
    /// [`Error::NotFinite`] for `f`, [`Error::FactorMismatch`].
    pub fn solve_plain(
        &mut self,
        scene: &Scene<T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        f: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C>, Error> {
        self.run::<Plain>(scene, factor, f, settings)
    }

    /// Solves by Algorithm 1 of the note, fast ADMM.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for `f`, [`Error::FactorMismatch`].
    pub fn solve_fast(
        &mut self,
        scene: &Scene<T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        f: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C>, Error> {
        self.run::<Fast<T>>(scene, factor, f, settings)
    }

    /// Solves by Algorithm 2 of the note, fast ADMM with restart.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for `f`, [`Error::FactorMismatch`].
    pub fn solve_restart(
        &mut self,
        scene: &Scene<T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        f: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C>, Error> {
        self.run::<Restart<T>>(scene, factor, f, settings)
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Solver<T, N, D, C> {
    fn run<A: Acceleration<T>>(
        &mut self,
        scene: &Scene<T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        f: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C>, Error> {
        let problem = Problem::new(scene, factor, f, settings.slip)?;
        let rho = factor.penalty();
        let tolerance = settings.tolerance;
        let mut iterates = self.start(&problem);
        let mut best = Best {
            r: [[T::ZERO; D]; C],
            natural_map: None,
        };
        let mut solved = best.consider(&problem, &iterates, tolerance, &mut self.solution);
        let mut acceleration = A::START;
        // The estimate of the error is cheap; the error is looked at when the estimate promises.
        let mut gate = tolerance + tolerance;
        let mut iterations = 0;
        while !solved && iterations < settings.max_iterations {
            iterations += 1;
            let change = iterate(&problem, &mut iterates, &mut acceleration);
            let size = problem.size.max(rho * change.zeta.square_root());
            let estimate = quotient(change.residual.square_root(), size);
            if settings.slip == SlipUpdate::OuterLoop && estimate <= tolerance {
                iterates.iter_mut().for_each(Iterate::update_slip);
                acceleration = A::START;
            }
            if estimate <= gate || iterations == settings.max_iterations {
                solved = best.consider(&problem, &iterates, tolerance, &mut self.solution);
                gate = estimate * T::literal(0.5);
            }
        }
        let contacts = problem.laws().len();
        for (state, iterate) in self.state.iter_mut().zip(&iterates).take(contacts) {
            *state = Some(State {
                u: iterate.u,
                r: iterate.zeta * -rho,
            });
        }
        self.solution.iterations = iterations;
        self.solution.status = Status::Solved;
        if !solved {
            self.solution.status = Status::MaxIterations;
            problem.evaluate(&best.r, &mut self.solution);
        }
        Ok(&self.solution)
    }

    /// The first iterate: the state of the last solve, or at rest without impulse.
    fn start(&self, problem: &Problem<'_, T, N, D, C>) -> [Iterate<T, D>; C] {
        let mut iterates = [Iterate::at(zeros(), zeros()); C];
        let states = problem.laws().iter().zip(&self.state);
        for (iterate, (law, state)) in iterates.iter_mut().zip(states) {
            if let Some(State { u, r }) = state {
                let r = law.cone.project(r);
                *iterate = Iterate::at(*u, r / -problem.factor.penalty());
            }
        }
        iterates
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Default for Solver<T, N, D, C> {
    fn default() -> Self {
        Self::new()
    }
}

/// The best impulse so far.
struct Best<T, const D: usize, const C: usize> {
    r: ContactVector<T, D, C>,
    /// The first part of its error, as contact space sees it; none before the first candidate.
    natural_map: Option<T>,
}

impl<T: Real, const D: usize, const C: usize> Best<T, D, C> {
    /// Keeps the impulse of an iterate if it is the best so far; true if it solves the problem.
    ///
    /// Only an impulse that contact space finds good enough is worth its velocity and its error.
    fn consider<const N: usize>(
        &mut self,
        problem: &Problem<'_, T, N, D, C>,
        iterates: &[Iterate<T, D>; C],
        tolerance: T,
        solution: &mut Solution<T, N, D, C>,
    ) -> bool {
        let mut r = [[T::ZERO; D]; C];
        for (r, iterate) in r.iter_mut().zip(iterates) {
            *r = (iterate.zeta * -problem.factor.penalty()).into();
        }
        let natural_map = problem.natural_map(&r);
        if self.natural_map.is_some_and(|best| natural_map >= best) {
            return false;
        }
        self.r = r;
        self.natural_map = Some(natural_map);
        if natural_map > tolerance {
            return false;
        }
        problem.evaluate(&r, solution);
        solution.error <= tolerance
    }
}

const fn zeros<T: Real, const K: usize>() -> SVector<T, K> {
    SVector::from_array_storage(ArrayStorage([[T::ZERO; K]; 1]))
}
