//! How a solution moves with its data: its derivative, forward and backward.
//!
//! In the modes that a solution has (open, stick, slip; joint rows at a bound or not) the law is smooth. Linearised as
//! `dr = Z x + d0`, `Y · du + c x = k` ([`local`]), with `du = W dr + dq`, it is one linear system with as many unknowns as
//! there are rows that hold:
//!
//! `A x = k - Yᵀ (W d0 + dq)`, `A = Yᵀ W Z + c`, `dv = M⁻¹ (dp + Hᵀ dr)`
//!
//! A gradient is the same with `Aᵀ`. Nothing of the method that has found the solution is in it.

use crate::error::Error;
use crate::factor::Factor;
use crate::linalg::blocks::product;
use crate::linalg::cholesky::axpy;
use crate::linalg::lu::Lu;
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::zeros;
use crate::real::Real;
use crate::scene::Scene;
use crate::sets::{ContactSet, RowSet};
use crate::solution::{Settings, Solution, Status};
use directions::{Side, collect};
use local::{Local, LocalRow};
use margin::Margin;

mod directions;
mod local;
mod margin;

pub use directions::{Inputs, Outputs};

/// The derivative of a solution with respect to the data of its solve.
///
/// [`Self::forward`] says how the solution moves with a change of the data, [`Self::adjoint`] how a sum of its parts moves
/// with each of the data; both for data that change a little, in the modes that the solution has. It borrows scene and factor.
/// Factorised once, by `u³ / 3` multiplications for `u` rows that hold, it serves any number of calls. [`crate::guide::derivatives`]
/// explains it.
///
/// ```
/// use nalgebra::{Matrix2, matrix, vector};
/// use stiction::{Contact, Inputs, Kernel, Outputs, Settings};
///
/// // 2 kg slide over a floor (x, height), with a friction coefficient of 0.5.
/// let mut kernel = Kernel::<f64, 2, 2, 1>::new();
/// kernel.scene_mut().set_mass(&(Matrix2::identity() * 2.0))?;
/// let jacobian = matrix![0.0, 1.0; 1.0, 0.0];
/// kernel.scene_mut().push(&Contact { jacobian, offset: vector![0.0, 0.0], mu: 0.5, key: 0 })?;
/// let settings = Settings::new(1e-9);
/// kernel.solve(&vector![1.0, -0.2], &settings)?;
///
/// let derivative = kernel.derivative(&settings)?;
/// let mut change = Inputs::zero();
/// change.friction[0] = 1.0;
/// let velocity = derivative.forward(&change).velocity;
/// assert!((velocity - vector![-0.1, 0.0]).norm() < 1e-12); // the load, 0.2 N·s, over 2 kg
///
/// let mut weights = Outputs::zero();
/// weights.velocity[0] = 1.0; // of the speed alone
/// let gradient = derivative.adjoint(&weights);
/// assert!((gradient.friction[0] + 0.1).abs() < 1e-12);
/// assert!((gradient.free_impulse - vector![0.5, 0.25]).norm() < 1e-12); // 1/m; and a load has friction
/// # Ok::<(), stiction::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Derivative<
    'a,
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize = 0,
    const S: usize = 0,
> {
    scene: &'a Scene<T, N, D, C, R, S>,
    factor: &'a Factor<T, N, D, C, R>,
    contacts: [Local<T, D>; C],
    rows: [LocalRow<T>; R],
    lu: Lu<T, D, C, R>,
    margin: Margin<T>,
    moves_freely: bool,
}

impl<'a, T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Derivative<'a, T, N, D, C, R, S>
{
    /// The derivative of a solution of this scene, with the factor and the settings (their [`Settings::model`]) of its solve.
    ///
    /// # Errors
    /// [`Error::StaleFactor`]; [`Error::NoSolution`] if nothing was solved, if the scene is infeasible or jammed, or if the solution
    /// has not as many contacts and joint rows as the scene (limits of [`crate::Kernel::solve_with_limits`] are no rows of it).
    pub fn new(
        scene: &'a Scene<T, N, D, C, R, S>,
        factor: &'a Factor<T, N, D, C, R>,
        solution: &Solution<T, N, D, C, R>,
        settings: &Settings<T>,
    ) -> Result<Self, Error> {
        if !factor.is_current(scene) {
            return Err(Error::StaleFactor);
        }
        let counts = scene.counts();
        let fits = solution.contacts.len() == counts.contacts && solution.rows.len() == counts.rows;
        let unsolved = matches!(
            solution.status,
            Status::Unsolved | Status::Infeasible | Status::Jammed
        );
        if unsolved || !fits || !solution.has_numbers() {
            return Err(Error::NoSolution);
        }
        let mut derivative = Self {
            scene,
            factor,
            contacts: [Local::open(); C],
            rows: [LocalRow::open(); R],
            lu: Lu::zero(),
            margin: Margin::none(),
            moves_freely: false,
        };
        let unknowns = derivative.linearise(solution, settings);
        derivative.lu.begin(unknowns);
        derivative.assemble().ok_or(Error::NoSolution)?;
        // What rounding leaves of a pivot; where it leaves more than half of the digits, all the same no more.
        let floor = factor.uncertainty().min(T::EPSILON.square_root());
        derivative.lu.factorise(floor).ok_or(Error::NoSolution)?;
        derivative.moves_freely = derivative.find_free_motion(floor.square_root());
        Ok(derivative)
    }

    /// Linearises the laws, and returns the number of unknowns.
    fn linearise(&mut self, solution: &Solution<T, N, D, C, R>, settings: &Settings<T>) -> usize {
        let (scene, factor) = (self.scene, self.factor);
        let mut unknowns = 0;
        let sources = scene.contacts().iter().zip(&solution.contacts);
        for (i, (local, (contact, found))) in self.contacts.iter_mut().zip(sources).enumerate() {
            let alpha = factor.natural_map_step(i);
            let set = ContactSet::<T, D>::new(contact, settings.model, alpha, zeros());
            let u = scene.scale(i, found.velocity.into());
            let r = scene.unscale(i, found.impulse.into());
            let moves = |k| factor.delassus().inverse_mass(i, k) > T::ZERO;
            *local = Local::new(&set, settings.model, found.mode, (&u, &r), moves);
            self.margin.add_contact(&set, found.mode, (&u, &r));
            unknowns += local.count;
        }
        let sources = scene.rows().iter().zip(&solution.rows);
        for (j, (local, (row, found))) in self.rows.iter_mut().zip(sources).enumerate() {
            let set = RowSet::new(row, factor.row_step(j), T::ZERO);
            *local = LocalRow::new(row, set.alpha, found);
            let (u, r) = (found.velocity, found.impulse);
            self.margin.add_row(&set, found.mode, u, r);
            unknowns += local.count();
        }
        unknowns
    }

    /// Fills `A = Yᵀ W Z + c`: each row is `W` times one of `Y`, brought to the unknowns.
    fn assemble(&mut self) -> Option<()> {
        let delassus = self.factor.delassus();
        let mut unknown = 0;
        for (i, local) in self.contacts.iter().enumerate() {
            let equations = local.held.iter().zip(&local.damping).take(local.count);
            for (held, &damping) in equations {
                let mut moved = Stacked::zero();
                for (&held, row) in held.iter().zip(delassus.contacts.get(i)?) {
                    if held != T::ZERO {
                        axpy(held, row.as_flattened(), moved.contacts.as_flattened_mut());
                    }
                }
                for (moved, coupling) in moved.rows.iter_mut().zip(&delassus.coupling) {
                    *moved = product(held, coupling.get(i)?);
                }
                let row = self.lu.row_mut(unknown)?;
                collect(&self.contacts, &self.rows, &moved, Side::Free, row);
                *row.at_mut(unknown)? += damping;
                unknown += 1;
            }
        }
        let sources = delassus.coupling.iter().zip(&delassus.rows);
        for (local, (coupling, row)) in self.rows.iter().zip(sources) {
            if local.count() > 0 {
                let moved = Stacked {
                    contacts: coupling.map(|block| block.map(|entry| entry * local.scale)),
                    rows: row.map(|entry| entry * local.scale),
                };
                let row = self.lu.row_mut(unknown)?;
                collect(&self.contacts, &self.rows, &moved, Side::Free, row);
                unknown += 1;
            }
        }
        Some(())
    }

    /// Does an impulse that leaves all equations fulfilled move anything?
    fn find_free_motion(&self, floor: T) -> bool {
        let Some(x) = self.lu.null_vector() else {
            return false;
        };
        let (r, mut u) = (self.spread(&x, Side::Free), Stacked::zero());
        let (counts, all) = (self.scene.counts(), 0..D * C + R);
        self.factor.delassus().times(&r, &mut u, counts);
        r.dot(&u, all.clone()) > floor * x.dot(&x, all)
    }

    /// How far the next change of a mode is: the least impulse that would change one, as a share of the largest impulse
    /// (dimensionless, each over the root of the mass that it moves).
    ///
    /// At 0 the solution has a kink: one-sided derivatives, of which this is that of the mode that the solution reports.
    #[must_use]
    pub fn margin(&self) -> T {
        self.margin.value()
    }

    /// Are the impulses determined by the data? In a hyperstatic scene they are not, nor have they a derivative: [`Self::forward`] gives
    /// the change of impulses that is least (in the sum of `|dr|²` over the mass that each contact and row feels), [`Self::adjoint`] its
    /// gradient.
    #[must_use]
    pub fn has_unique_impulses(&self) -> bool {
        self.lu.rank() == self.lu.size()
    }

    /// Is the velocity determined by the data? It is, but where a hyperstatic load is shared between contacts that slip in different
    /// directions, such as the legs of a table that turns: then it depends on which of the solutions was found.
    #[must_use]
    pub const fn has_unique_velocity(&self) -> bool {
        !self.moves_freely
    }
}
