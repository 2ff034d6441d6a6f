//! The derivative of a solution with respect to its data, forward and adjoint ([`crate::guide::derivatives`]).
//!
//! In fixed modes (open, stick, slip; joint rows at a bound or not) the law is smooth. It is linearised as `dr = Z x + d0`,
//! `Y · du + c x = k` ([`law`]), where the unknowns `x` are the free changes of impulses and `d0` is the direct change of impulses by
//! the data. With `du = W dr + dq` that is a linear system with one unknown for each row that holds:
//!
//! `A x = k - Yᵀ (W d0 + dq)`, `A = Yᵀ W Z + c`, `dv = M⁻¹ (dp + Hᵀ dr)`
//!
//! A gradient solves the same system with `Aᵀ`. The method that found the solution plays no part.

use crate::error::Error;
use crate::factor::Factor;
use crate::linalg::blocks::product;
use crate::linalg::cholesky::axpy;
use crate::linalg::lu::Lu;
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::{norm, zeros};
use crate::linalg::zip::zip4;
use crate::real::Real;
use crate::scene::Scene;
use crate::sets::{ContactSet, RowSet};
use crate::solution::{Settings, Solution};
use directions::times_transposed;
use law::{Basis, LinearContact, LinearRow};
use margin::Margin;

mod directions;
mod law;
mod margin;

pub use directions::{Inputs, Outputs};

/// The derivative of a solution with respect to the data of its solve.
///
/// [`Self::forward`] computes the change of the solution for a change of the data, [`Self::adjoint`] the gradient of a weighted sum of the
/// solution with respect to all data. Both hold for small changes that keep the modes of the solution. [`crate::guide::derivatives`]
/// explains them.
///
/// A derivative borrows scene and factor. [`Self::new`] factorises its matrix by `u³ / 3` multiplications for `u` rows that hold; then it
/// serves any number of calls.
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
    contacts: [LinearContact<T, D>; C],
    rows: [LinearRow<T>; R],
    /// The matrix `A`, factorised.
    lu: Lu<T, D, C, R>,
    margin: Margin<T>,
    /// Does a null vector of `A` change the velocity?
    moves_freely: bool,
}

impl<'a, T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Derivative<'a, T, N, D, C, R, S>
{
    /// The derivative of a solution of this scene, with the factor of its solve. [`Settings::tolerance`] is the largest error of a solution whose
    /// solve has not reached its own tolerance ([`Solution::is_usable`]).
    ///
    /// # Errors
    /// [`Error::StaleFactor`]; [`Error::NoSolution`] if the solution is not usable at that error; [`Error::SceneChanged`].
    pub fn new(
        scene: &'a Scene<T, N, D, C, R, S>,
        factor: &'a Factor<T, N, D, C, R>,
        solution: &Solution<T, N, D, C, R>,
        settings: &Settings<T>,
    ) -> Result<Self, Error> {
        solution.check(scene, factor, settings)?;
        let mut derivative = Self {
            scene,
            factor,
            contacts: [LinearContact::open(); C],
            rows: [LinearRow::open(); R],
            lu: Lu::zero(),
            margin: Margin::none(),
            moves_freely: false,
        };
        let unknowns = derivative.linearise(solution);
        derivative.lu.begin(unknowns);
        derivative.weigh();
        derivative.assemble().ok_or(Error::NoSolution)?;
        // A smaller pivot is mere rounding. The floor is at most half of the digits, however large the rounding of `W`.
        let floor = factor.uncertainty().min(T::EPSILON.square_root());
        derivative.lu.factorise(floor).ok_or(Error::NoSolution)?;
        derivative.moves_freely = derivative.find_free_motion(floor.square_root());
        Ok(derivative)
    }

    /// Linearises the laws, and returns the number of unknowns of the system.
    fn linearise(&mut self, solution: &Solution<T, N, D, C, R>) -> usize {
        let (scene, factor) = (self.scene, self.factor);
        let mut unknowns = 0;
        let laws = &mut self.contacts;
        for (i, law, contact, found) in zip4(0..C, laws, scene.contacts(), &solution.contacts) {
            let alpha = factor.mean_effective_mass(i);
            let set = ContactSet::<T, D>::new(contact, solution.model, alpha, zeros());
            let u = scene.scaled_velocity(i, found.velocity.into());
            let r = scene.scaled_impulse(i, found.impulse.into());
            let moves = |k| factor.delassus().inverse_mass(i, k) > T::ZERO;
            *law = LinearContact::new(&set, solution.model, found.mode, (&u, &r), moves);
            self.margin.add_contact(&set, found.mode, (&u, &r));
            unknowns += law.count;
        }
        for (j, law, row, found) in zip4(0..R, &mut self.rows, scene.rows(), &solution.rows) {
            let set = RowSet::new(row, factor.row_effective_mass(j), T::ZERO);
            *law = LinearRow::new(row, set.alpha, found);
            let (u, r) = (found.velocity, found.impulse);
            self.margin.add_row(&set, found.mode, u, r);
            unknowns += law.count();
        }
        unknowns
    }

    /// Sets the weights of unknowns: impulses over the root of the stiffness of their springs, as of [`crate::LeastImpulses`].
    fn weigh(&mut self) {
        let factor = self.factor;
        let mass = factor.common_effective_mass().square_root();
        let mut weights = self.lu.weights_mut().iter_mut();
        for law in &self.contacts {
            for (z, weight) in law.basis(Basis::Z).zip(&mut weights) {
                *weight = norm(z) / mass;
            }
        }
        for (j, law) in self.rows.iter().enumerate() {
            if law.count() > 0
                && let Some(weight) = weights.next()
            {
                *weight = law.scale / factor.row_effective_mass(j).square_root();
            }
        }
    }

    /// Fills `A = Yᵀ W Z + c` row by row: `Zᵀ` times `W` times a column of `Y`.
    fn assemble(&mut self) -> Option<()> {
        let delassus = self.factor.delassus();
        let mut unknown = 0;
        for (i, law) in self.contacts.iter().enumerate() {
            for (y, &c) in law.equations() {
                let mut w_y = Stacked::zero();
                for (&y, row) in y.iter().zip(delassus.contacts.get(i)?) {
                    if y != T::ZERO {
                        axpy(y, row.as_flattened(), w_y.contacts.as_flattened_mut());
                    }
                }
                for (w_y, row) in w_y.rows.iter_mut().zip(&delassus.rows) {
                    *w_y = product(y, row.contacts.get(i)?);
                }
                let row = self.lu.row_mut(unknown)?;
                times_transposed(&self.contacts, &self.rows, &w_y, Basis::Z, row);
                *row.at_mut(unknown)? += c;
                unknown += 1;
            }
        }
        for (law, row) in self.rows.iter().zip(&delassus.rows) {
            if law.count() > 0 {
                let mut w_y = *row;
                w_y.iter_mut().for_each(|entry| *entry *= law.scale);
                let row = self.lu.row_mut(unknown)?;
                times_transposed(&self.contacts, &self.rows, &w_y, Basis::Z, row);
                unknown += 1;
            }
        }
        Some(())
    }

    /// Does a null vector of `A`, a change of impulses that satisfies all equations, change the velocity?
    fn find_free_motion(&self, floor: T) -> bool {
        let Some(x) = self.lu.null_vector() else {
            return false;
        };
        let (r, mut u) = (self.times(&x, Basis::Z), Stacked::zero());
        let (counts, all) = (self.scene.counts(), 0..D * C + R);
        self.factor.delassus().times(&r, &mut u, counts);
        r.dot(&u, all.clone()) > floor * x.dot(&x, all)
    }

    /// Distance to the next change of a mode: the least impulse that would change one, as a share of the largest impulse (dimensionless,
    /// each impulse over the root of the mass that it moves).
    ///
    /// At 0 the solution has a kink, and its derivatives are one-sided. This derivative is then that of the reported modes.
    #[must_use]
    pub fn margin(&self) -> T {
        self.margin.value()
    }

    /// Are the impulses unique? In a hyperstatic scene they are not, so they have no derivative: [`Self::forward`] returns the least change, which is
    /// that of the [`crate::LeastImpulses`] while none of these is on the boundary of its cone, and [`Self::adjoint`] returns its gradient.
    #[must_use]
    pub fn has_unique_impulses(&self) -> bool {
        self.lu.rank() == self.lu.size()
    }

    /// Is the velocity unique? It is not if contacts that slip in different directions share a hyperstatic load, such as the legs of a table
    /// that turns: then it depends on the solution that was found.
    #[must_use]
    pub const fn has_unique_velocity(&self) -> bool {
        !self.moves_freely
    }
}
