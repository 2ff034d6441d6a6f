//! The default method: Algorithm 2 for a start, semismooth Newton to the end.

use crate::admm::{Acceleration, Change, Iterate, Restart};
use crate::newton::{self, Point};
use crate::problem::Problem;
use crate::residual::quotient;
use crate::resolvent::Resolvent;
use crate::search::Search;
use crate::solution::zeros;
use crate::state::State;
use crate::{Error, Factor, Real, Scene, Settings, Solution};
use nalgebra::SVector;

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
    state: State<T, D, C>,
    solution: Solution<T, N, D, C>,
    /// The system of a Newton step, or the resolvent of an adapted penalty.
    workspace: Resolvent<T, D, C>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Solver<T, N, D, C> {
    /// A solver that has solved nothing yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            state: State::cold(),
            solution: Solution::none(),
            workspace: Resolvent::empty(),
        }
    }

    /// Forgets the last solution: the next solve starts cold.
    pub fn reset(&mut self) {
        self.state = State::cold();
    }

    /// Tells the next solve which contact of the last one each of its contacts was; `None` for a
    /// contact that was just made. Contacts that `previous` does not list start cold.
    pub fn carry_over(&mut self, previous: &[Option<usize>]) {
        self.state.carry_over(previous);
    }

    /// The last solution.
    #[must_use]
    pub const fn solution(&self) -> &Solution<T, N, D, C> {
        &self.solution
    }

    /// Solves a scene for a free impulse `f = -M v_free` (N·s).
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
        let problem = Problem::new(scene, factor, f, settings.slip)?;
        let mut balance = Balance::of(factor.penalty());
        let mut iterates = self.state.start(&problem, balance.penalty);
        let mut search = Search::new(&problem, settings, &mut self.solution);
        let mut solved = search.consider_iterates(&iterates, balance.penalty);
        let mut caution = Caution::new();
        let mut adapted = false;
        let mut length = 5;
        while !solved && search.has_budget() {
            let resolvent = if adapted {
                &self.workspace
            } else {
                factor.resolvent()
            };
            let mut acceleration = Restart::START;
            for _ in 0..length {
                let (change, done) = search.iterate(resolvent, &mut iterates, &mut acceleration);
                balance.observe(&change);
                solved = done;
                if solved || !search.has_budget() {
                    break;
                }
            }
            if solved {
                break;
            }
            let z = balance.join(&problem, &iterates);
            let mut point = Point::at(&problem, balance.scale, &z);
            solved = search.consider(&point.impulse, point.natural_map)
                || caution.allows(&point)
                    && finish(
                        &mut search,
                        &mut point,
                        &mut caution,
                        &balance,
                        &mut self.workspace,
                    );
            // What Newton leaves goes back to ADMM, with a penalty between its residuals.
            balance.update(search.cost());
            adapted = !solved && balance.penalty != factor.penalty();
            if adapted {
                let (delassus, contacts) = (factor.delassus(), factor.contacts());
                let computed = self.workspace.compute(delassus, contacts, balance.penalty);
                search.count_factorization();
                if computed.is_err() {
                    balance = Balance::of(factor.penalty());
                    adapted = false;
                }
            }
            for ((iterate, velocity), impulse) in
                iterates.iter_mut().zip(&point.velocity).zip(&point.impulse)
            {
                *iterate = Iterate::at(*velocity, SVector::from(*impulse) / -balance.penalty);
            }
            length = 8;
        }
        search.finish(solved);
        self.state.keep(&problem, &iterates, balance.penalty);
        Ok(&self.solution)
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Default for Solver<T, N, D, C> {
    fn default() -> Self {
        Self::new()
    }
}

/// Newton steps as long as they reduce the merit; true if one solves the problem.
fn finish<T: Real, const N: usize, const D: usize, const C: usize>(
    search: &mut Search<'_, T, N, D, C>,
    point: &mut Point<T, D, C>,
    caution: &mut Caution<T>,
    balance: &Balance<T>,
    workspace: &mut Resolvent<T, D, C>,
) -> bool {
    let problem = search.problem;
    while search.has_budget() {
        search.count_newton_step();
        let regularisation = caution.regularisation(point.natural_map);
        let matrix = &mut workspace.matrix;
        let step = newton::direction(problem, point, balance.scale, regularisation, matrix);
        let Some(step) = step else { break };
        let half = T::literal(0.5);
        let mut accepted = false;
        for length in [T::ONE, half] {
            let mut z = point.z;
            for (z, step) in z.iter_mut().zip(&step) {
                *z += step * length;
            }
            let trial = Point::at(problem, balance.scale, &z);
            if search.consider(&trial.impulse, trial.natural_map) {
                *point = trial;
                return true;
            }
            if trial.merit < point.merit * (T::ONE - T::literal(1e-4) * length) {
                *point = trial;
                accepted = true;
                if length == T::ONE {
                    caution.relax();
                }
                break;
            }
        }
        if !accepted {
            break;
        }
    }
    caution.reject(point.merit);
    false
}

/// How much Newton's steps are regularised, and when they are worth trying.
struct Caution<T> {
    level: T,
    /// The merit at which the last step was rejected, and how often it was waited since.
    rejected: Option<T>,
    waited: usize,
}

impl<T: Real> Caution<T> {
    fn new() -> Self {
        Self {
            level: T::literal(1e-3),
            rejected: None,
            waited: 0,
        }
    }

    /// Is a step worth trying? After a rejection first-order iterations must have brought the
    /// merit down, or have been tried twice.
    fn allows<const D: usize, const C: usize>(&mut self, point: &Point<T, D, C>) -> bool {
        let waiting = self
            .rejected
            .is_some_and(|merit| point.merit > merit * T::literal(0.3));
        if waiting && self.waited < 2 {
            self.waited += 1;
            return false;
        }
        self.waited = 0;
        true
    }

    /// `λ`: vanishes with the error, so that the last steps are Newton's.
    fn regularisation(&self, natural_map: T) -> T {
        let lambda = self.level * T::literal(1e-3) * natural_map.min(T::ONE) + T::literal(1e-9);
        lambda.min(T::literal(0.3))
    }

    /// A full step was accepted.
    fn relax(&mut self) {
        self.level = (self.level * T::literal(0.1)).max(T::literal(1e-3));
    }

    /// A step was rejected at this merit.
    fn reject(&mut self, merit: T) {
        self.level = (self.level * T::literal(10.0))
            .max(T::ONE)
            .min(T::literal(1e6));
        self.rejected = Some(merit);
    }
}

/// The penalties of ADMM and of Newton's method, and what ADMM says of them.
struct Balance<T> {
    /// `rho` of ADMM.
    penalty: T,
    /// `kappa` of Newton's `rho_i = kappa alpha_i`.
    scale: T,
    start: T,
    /// `|ζᵏ⁺¹ - ζ̂ᵏ|²` and `|ũᵏ⁺¹ - ûᵏ|²` of the last iteration.
    primal: T,
    dual: T,
    restarts: usize,
}

impl<T: Real> Balance<T> {
    fn of(penalty: T) -> Self {
        Self {
            penalty,
            scale: T::ONE,
            start: penalty,
            primal: T::ONE,
            dual: T::ONE,
            restarts: 0,
        }
    }

    fn observe(&mut self, change: &Change<T>) {
        self.primal = change.primal;
        self.dual = change.dual;
    }

    /// Raises the penalties where the primal residual is the larger, by the square root of the
    /// ratio, at most tenfold; every 300 iterations' worth of work tries another size altogether.
    fn update(&mut self, cost: usize) {
        const SCALES: [f64; 8] = [10.0, 0.1, 100.0, 0.01, 3.0, 0.3, 1000.0, 1e-3];
        if cost >= 300 * (self.restarts + 1) {
            let scale = SCALES.get(self.restarts % SCALES.len()).copied();
            self.scale = T::literal(scale.unwrap_or(1.0));
            self.penalty = self.start * self.scale;
            self.restarts += 1;
            return;
        }
        let (ten, tenth) = (T::literal(10.0), T::literal(0.1));
        let factor = quotient(self.primal, self.dual).square_root().square_root();
        let factor = factor.min(ten).max(tenth);
        let two = T::ONE + T::ONE;
        if factor > two || factor * two < T::ONE {
            self.penalty *= factor;
            self.scale *= factor;
        }
    }

    /// `z = P - r / rho_i` at the projected velocities and multipliers of ADMM.
    fn join<const N: usize, const D: usize, const C: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C>,
        iterates: &[Iterate<T, D>; C],
    ) -> [SVector<T, D>; C] {
        let mut z = [zeros(); C];
        for ((z, iterate), law) in z.iter_mut().zip(iterates).zip(problem.laws()) {
            *z = iterate.u;
            if law.step > T::ZERO {
                *z += iterate.zeta * (self.penalty / (self.scale * law.step));
            }
        }
        z
    }
}
