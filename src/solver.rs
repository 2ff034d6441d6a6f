//! The default method: Algorithm 2 for a start, semismooth Newton to the end.

use crate::admm::{Acceleration, Iterate, Restart};
use crate::gauss_seidel;
use crate::infeasibility;
use crate::newton::{self, Point};
use crate::problem::Problem;
use crate::resolvent::Resolvent;
use crate::safeguard::{Balance, Caution};
use crate::search::Search;
use crate::solution::zeros;
use crate::state::State;
use crate::{Error, Factor, Real, Scene, Settings, Solution, Status};
use core::mem;
use nalgebra::SVector;

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
        Problem::check(scene, factor, f)?;
        let problem = Problem::new(scene, factor, f, settings.slip);
        let mut balance = Balance::new();
        let mut caution = Caution::new();
        let mut point = Point::zero();
        let eager = self
            .state
            .point(&problem, balance.scale, settings.tolerance, &mut point);
        let mut search = Search::new(problem, settings, &mut self.solution);
        search.consider(&point.impulse, &point.relative, point.natural_map);
        let mut adapted = false;
        // What was left for a side branch, and the impulses of that branch.
        let mut left = None;
        let mut swept = [[T::ZERO; D]; C];
        let mut length = 5;
        if eager && search.is_running() {
            let before = point.energy;
            caution = Caution::warm();
            refine(
                &mut search,
                &mut point,
                &mut caution,
                &balance,
                &mut self.workspace,
            );
            caution = Caution::new();
            if search.is_running() && point.energy > before * T::literal(0.1) {
                // It was misleading.
                point.reset(&search.problem, balance.scale);
            }
        }
        while search.is_running() {
            let resolvent = if adapted {
                &self.workspace
            } else {
                factor.resolvent()
            };
            approach(&mut search, &mut point, resolvent, &mut balance, length);
            if search.is_running() && caution.allows(&point) {
                refine(
                    &mut search,
                    &mut point,
                    &mut caution,
                    &balance,
                    &mut self.workspace,
                );
            }
            if !search.is_running() {
                break;
            }
            // What Newton leaves goes back to ADMM, with penalties that its residuals balance.
            if search.solution.factorizations > 0 {
                balance.update(search.cost());
            }
            let penalties = search.problem.penalties(balance.scale);
            let (delassus, contacts) = (factor.delassus(), factor.contacts());
            let computed = self.workspace.compute(delassus, contacts, &penalties);
            adapted = computed.is_ok();
            search.solution.factorizations += 1;
            length = 8;
            if balance.has_restarted() {
                caution.forget();
                length = 20;
                // Now and then from elsewhere; if that does not help, back to where it was.
                if let Some(last) = left.take() {
                    (point.velocity, point.impulse) = last;
                } else if balance.turns_aside() {
                    left = Some((point.velocity, point.impulse));
                    for _ in 0..20 {
                        search.solution.iterations += 1;
                        gauss_seidel::sweep(&search.problem, &mut swept);
                    }
                    (point.velocity, point.impulse) = (search.problem.lifted(&swept), swept);
                }
                point.rebuild(&search.problem, balance.scale);
            }
            if search.take_lost() {
                point.reset(&search.problem, balance.scale);
            }
        }
        if !search.is_solved() || search.impulse_is_excessive() {
            look_for_proof(&mut search);
        }
        search.finish();
        let contacts = point.velocity.into_iter().zip(point.impulse);
        let contacts = contacts.map(|(u, r)| (u, r.into()));
        self.state.keep(scene.contacts(), contacts);
        Ok(&self.solution)
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Default for Solver<T, N, D, C> {
    fn default() -> Self {
        Self::new()
    }
}

/// A few iterations of Algorithm 2 from a point.
#[inline(never)]
fn approach<T: Real, const N: usize, const D: usize, const C: usize>(
    search: &mut Search<'_, T, N, D, C>,
    point: &mut Point<T, D, C>,
    resolvent: &Resolvent<T, D, C>,
    balance: &mut Balance<T>,
    length: usize,
) {
    let mut iterates = [Iterate::at(zeros(), zeros(), T::ONE); C];
    let pairs = point.velocity.iter().zip(&point.impulse);
    let pairs = pairs.zip(&resolvent.penalties);
    for (iterate, ((velocity, &impulse), &penalty)) in iterates.iter_mut().zip(pairs) {
        *iterate = Iterate::at(*velocity, impulse.into(), penalty);
    }
    let mut acceleration = Restart::START;
    for _ in 0..length {
        let change = search.iterate(resolvent, &mut iterates, &mut acceleration);
        balance.observe(&change);
        if !search.is_running() {
            break;
        }
    }
    let targets = point.velocity.iter_mut();
    let targets = targets.zip(&mut point.impulse);
    for ((velocity, impulse), iterate) in targets.zip(&iterates) {
        *velocity = iterate.u;
        *impulse = iterate.impulse().into();
    }
    point.rebuild(&search.problem, balance.scale);
    if search.is_running() {
        search.consider(&point.impulse, &point.relative, point.natural_map);
    }
}

/// At most 30 Newton steps from a point, as long as they reduce the energy.
#[inline(never)]
fn refine<T: Real, const N: usize, const D: usize, const C: usize>(
    search: &mut Search<'_, T, N, D, C>,
    point: &mut Point<T, D, C>,
    caution: &mut Caution<T>,
    balance: &Balance<T>,
    workspace: &mut Resolvent<T, D, C>,
) {
    let lengths = if balance.has_ever_restarted() { 5 } else { 2 };
    let mut trial = Point::zero();
    for _ in 0..30 {
        if !search.is_running() {
            return;
        }
        search.solution.newton_steps += 1;
        let regularisation = caution.regularisation(point.natural_map);
        let (problem, matrix) = (&search.problem, &mut workspace.matrix);
        let step = newton::direction(problem, point, balance.scale, regularisation, matrix);
        let accepted = step.and_then(|step| {
            [1.0, 0.5, 0.25, 0.1, 0.02]
                .map(T::literal)
                .into_iter()
                .take(lengths)
                .find(|&length| {
                    let pairs = point.z.iter().zip(&step);
                    for (trial, (z, step)) in trial.z.iter_mut().zip(pairs) {
                        *trial = z + step * length;
                    }
                    trial.update(&search.problem, balance.scale);
                    search.consider(&trial.impulse, &trial.relative, trial.natural_map);
                    let enough = point.energy * (T::ONE - T::literal(2e-4) * length);
                    let better = trial.energy < enough || !search.is_running();
                    if better {
                        mem::swap(point, &mut trial);
                    }
                    better
                })
        });
        match accepted {
            Some(length) if length == T::ONE => caution.relax(),
            Some(_) => {}
            None => {
                caution.reject(point.energy);
                if caution.is_first_rejection() {
                    look_for_proof(search);
                }
                search.fail();
                return;
            }
        }
    }
}

/// Stops the search if the scene is infeasible.
fn look_for_proof<T: Real, const N: usize, const D: usize, const C: usize>(
    search: &mut Search<'_, T, N, D, C>,
) {
    if !search.solution.certificate.is_empty() {
        return;
    }
    let Some(proof) = infeasibility::certificate(&search.problem) else {
        return;
    };
    for &d in proof.iter().take(search.problem.laws().len()) {
        // There is room: a solution holds as many contacts as a scene.
        let _ = search.solution.certificate.push(d);
    }
    search.stop(Status::Infeasible);
}
