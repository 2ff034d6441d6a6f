//! Changes of data and of solutions, and the products with the derivative ([`Derivative::forward`]) and its transpose
//! ([`Derivative::adjoint`]).

use super::Derivative;
use super::law::{Basis, LinearContact, LinearRow};
use crate::linalg::blocks::product;
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::{add, quotient, zeros};
use crate::linalg::zip::{zip3, zip4};
use crate::real::Real;
use nalgebra::SVector;

/// A change of the data of a solve, or a gradient with respect to them.
///
/// The entries belong to the velocities, contacts and joint rows of the scene, in its order. Unused entries are not read; in a gradient they
/// are 0. A change of `M`, `H` or compliance is a change of these entries, with `v` and `r` of the solution:
///
/// | change | equals a change of | gradient |
/// |---|---|---|
/// | `dM` of the mass matrix | `free_impulse` by `-dM v` | `-free_impulse vᵀ` |
/// | `dH_i` of a Jacobian | `free_impulse` by `dH_iᵀ r_i`, `offsets[i]` by `dH_i v` | `offsets[i] vᵀ + r_i free_impulseᵀ` |
/// | `dH_j` of a joint row | `free_impulse` by `dH_jᵀ λ_j`, `row_offsets[j]` by `dH_j v` | `row_offsets[j] vᵀ + λ_j free_impulseᵀ` |
/// | `dR` of compliance | `offsets[i]` by `dR r_i`, `row_offsets[j]` by `dR λ_j` | `offsets[i] r_i`, row by row; `row_offsets[j] λ_j` |
///
/// (A change of `M` keeps the free impulse here. If you compute the free impulse from `M`, add its change.)
#[derive(Clone, Debug, PartialEq)]
pub struct Inputs<T, const N: usize, const D: usize, const C: usize, const R: usize = 0> {
    /// Free impulse `M v_free` (N·s).
    pub free_impulse: SVector<T, N>,
    /// Offsets `w_i` of contacts (m/s).
    pub offsets: [SVector<T, D>; C],
    /// Friction coefficients, as [`crate::Scene::set_friction`] sets them.
    pub friction: [T; C],
    /// Offsets of joint rows (m/s, rad/s).
    pub row_offsets: [T; R],
    /// Bounds of joint rows, lower and upper (N·s, N·m·s); of a [`crate::RowLaw::Box`] alone.
    pub bounds: [[T; 2]; R],
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize> Inputs<T, N, D, C, R> {
    /// No change.
    #[must_use]
    pub const fn zero() -> Self {
        Self {
            free_impulse: zeros(),
            offsets: [const { zeros() }; C],
            friction: [T::ZERO; C],
            row_offsets: [T::ZERO; R],
            bounds: [[T::ZERO; 2]; R],
        }
    }
}

/// A change of a solution, or the weights of its parts in a sum. Unused entries are 0 in a change, and weights are not read there.
#[derive(Clone, Debug, PartialEq)]
pub struct Outputs<T, const N: usize, const D: usize, const C: usize, const R: usize = 0> {
    /// Generalised velocity `v`.
    pub velocity: SVector<T, N>,
    /// Contact impulses `r_i` (N·s), normal first, in the order of the scene.
    pub impulses: [SVector<T, D>; C],
    /// Impulses `λ_j` of joint rows (N·s, N·m·s).
    pub row_impulses: [T; R],
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize> Outputs<T, N, D, C, R> {
    /// No change.
    #[must_use]
    pub const fn zero() -> Self {
        Self { velocity: zeros(), impulses: [const { zeros() }; C], row_impulses: [T::ZERO; R] }
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Derivative<'_, T, N, D, C, R, S>
{
    /// The change of the solution for a change of the data. It takes `N² + 2 N m + u²` multiplications for `m` contact and joint rows in use,
    /// `u` of which hold.
    #[must_use]
    pub fn forward(&self, change: &Inputs<T, N, D, C, R>) -> Outputs<T, N, D, C, R> {
        let [mut momentum] = change.free_impulse.data.0;
        self.factor.whiten(&mut momentum);
        let mut impulses = self.direct_change(change);
        let b = self.right_side(change, &momentum, &impulses);
        if let Some((x, _)) = self.lu.solve(&b) {
            for (sum, &term) in impulses.iter_mut().zip(self.times(&x, Basis::Z).iter()) {
                *sum += term;
            }
        }
        let mut response = Outputs::zero();
        let [v] = &mut response.velocity.data.0;
        self.factor.velocity(&momentum, &impulses, v);
        for (i, physical, &impulse) in zip3(0..C, &mut response.impulses, &impulses.contacts) {
            *physical = self.scene.physical_impulse(i, impulse).into();
        }
        response.row_impulses = impulses.rows;
        response
    }

    /// The misfit of a change (dimensionless): the largest residual of the linearised laws, relative to their largest right-hand side. It is
    /// rounding if contacts and joint rows can keep their modes.
    ///
    /// In a hyperstatic scene offsets and Jacobians may change so that not all contacts can keep their modes: a fourth leg becomes shorter.
    /// Then there is no derivative, and [`Self::forward`] violates the equations that have no pivot.
    #[must_use]
    pub fn misfit(&self, change: &Inputs<T, N, D, C, R>) -> T {
        let [mut momentum] = change.free_impulse.data.0;
        self.factor.whiten(&mut momentum);
        let b = self.right_side(change, &momentum, &self.direct_change(change));
        let largest = b.max(0..D * C + R);
        let residual = self.lu.solve(&b).map_or(T::ZERO, |(_, residual)| residual);
        quotient(residual, largest)
    }

    /// The gradient of `Σ weight · change` of the solution with respect to the data, at the cost of [`Self::forward`] and `m²`
    /// multiplications.
    #[must_use]
    pub fn adjoint(&self, weights: &Outputs<T, N, D, C, R>) -> Inputs<T, N, D, C, R> {
        let [mut momentum] = weights.velocity.data.0;
        self.factor.whiten(&mut momentum);
        // The weights of impulses, including their part in the velocity. They change rows as velocities do, and the gradient by offsets as
        // impulses do: each is the factor of the other in a product.
        let mut weight = Stacked::zero();
        self.factor.contact_velocity(&momentum, &mut weight);
        for (i, sum, &term) in zip3(0..C, &mut weight.contacts, &weights.impulses) {
            add(sum, self.scene.scaled_velocity(i, term).as_slice());
        }
        add(&mut weight.rows, &weights.row_impulses);
        let c = self.times_transposed(&weight, Basis::Z);
        let y = self.lu.solve_transposed(&c).unwrap_or(Stacked::zero());
        // The gradient with respect to `q`.
        let mut offsets = self.times(&y, Basis::Y);
        offsets.iter_mut().for_each(|offset| *offset = -*offset);
        let mut product_of_w = Stacked::zero();
        if self.has_direct_change() {
            let (delassus, counts) = (self.factor.delassus(), self.scene.counts());
            delassus.times(&offsets, &mut product_of_w, counts);
        }

        let mut gradient = Inputs::zero();
        let [p] = &mut gradient.free_impulse.data.0;
        self.factor.velocity(&momentum, &offsets, p);
        for (i, physical, &offset) in zip3(0..C, &mut gradient.offsets, &offsets.contacts) {
            *physical = self.scene.physical_impulse(i, offset).into();
        }
        let mut unknown = 0;
        let (weights, products) = (&weight.contacts, &product_of_w.contacts);
        for (mu, law, weight, w) in zip4(&mut gradient.friction, &self.contacts, weights, products) {
            *mu = product(&law.impulse_per_mu, weight) + product(&law.impulse_per_mu, w);
            if law.equation_per_mu > T::ZERO {
                *mu += law.equation_per_mu * y.at(unknown).copied().unwrap_or(T::ZERO);
            }
            unknown += law.count;
        }
        gradient.row_offsets = offsets.rows;
        for (bounds, law, &weight, &w) in
            zip4(&mut gradient.bounds, &self.rows, &weight.rows, &product_of_w.rows)
        {
            *bounds = law.impulse_per_bound.map(|share| share * (weight + w));
        }
        gradient
    }

    /// Does an impulse depend directly on `mu` or on a bound: friction that slips, a row at its bound?
    fn has_direct_change(&self) -> bool {
        let mut contacts = self.contacts.iter();
        let mut rows = self.rows.iter();
        contacts.any(|law| law.impulse_per_mu != [T::ZERO; D])
            || rows.any(|law| law.impulse_per_bound != [T::ZERO; 2])
    }

    /// The direct change `d0` of impulses by `mu` and bounds.
    fn direct_change(&self, change: &Inputs<T, N, D, C, R>) -> Stacked<T, D, C, R> {
        let mut direct = Stacked::zero();
        for (direct, law, &mu) in zip3(&mut direct.contacts, &self.contacts, &change.friction) {
            *direct = law.impulse_per_mu.map(|share| share * mu);
        }
        for (direct, law, bounds) in zip3(&mut direct.rows, &self.rows, &change.bounds) {
            *direct = product(&law.impulse_per_bound, bounds);
        }
        direct
    }

    /// The right-hand side `k - Yᵀ (W d0 + dq)`, for a whitened change of the free impulse and the direct change `d0`.
    fn right_side(
        &self,
        change: &Inputs<T, N, D, C, R>,
        momentum: &[T; N],
        direct: &Stacked<T, D, C, R>,
    ) -> Stacked<T, D, C, R> {
        let (mut velocity, counts) = (Stacked::zero(), self.scene.counts());
        self.factor.contact_velocity(momentum, &mut velocity);
        for (i, sum, &offset) in zip3(0..C, &mut velocity.contacts, &change.offsets) {
            add(sum, self.scene.scaled_velocity(i, offset).as_slice());
        }
        add(&mut velocity.rows, &change.row_offsets);
        if direct.iter().any(|&direct| direct != T::ZERO) {
            let mut terms = Stacked::zero();
            self.factor.delassus().times(direct, &mut terms, counts);
            for (sum, &term) in velocity.iter_mut().zip(terms.iter()) {
                *sum += term;
            }
        }
        let mut b = self.times_transposed(&velocity, Basis::Y);
        b.iter_mut().for_each(|b| *b = -*b);
        let mut unknown = 0;
        for (law, &mu) in self.contacts.iter().zip(&change.friction) {
            if law.equation_per_mu > T::ZERO
                && let Some(b) = b.at_mut(unknown)
            {
                *b += law.equation_per_mu * mu;
            }
            unknown += law.count;
        }
        b
    }

    /// `Z x` or `Y x`, over all contacts and joint rows.
    pub(super) fn times(&self, x: &Stacked<T, D, C, R>, basis: Basis) -> Stacked<T, D, C, R> {
        let (mut sums, mut unknowns) = (Stacked::zero(), x.iter());
        for (sum, law) in sums.contacts.iter_mut().zip(&self.contacts) {
            for (vector, &x) in law.basis(basis).zip(&mut unknowns) {
                add(sum, &vector.map(|entry| entry * x));
            }
        }
        for (sum, law) in sums.rows.iter_mut().zip(&self.rows) {
            if law.count() > 0
                && let Some(&x) = unknowns.next()
            {
                *sum = law.scale * x;
            }
        }
        sums
    }

    /// `Zᵀ u` or `Yᵀ u`, over all unknowns.
    fn times_transposed(&self, u: &Stacked<T, D, C, R>, basis: Basis) -> Stacked<T, D, C, R> {
        let mut products = Stacked::zero();
        times_transposed(&self.contacts, &self.rows, u, basis, &mut products);
        products
    }
}

/// Fills `products` with `Zᵀ u` or `Yᵀ u`, over all unknowns.
pub(super) fn times_transposed<T: Real, const D: usize, const C: usize, const R: usize>(
    contacts: &[LinearContact<T, D>; C],
    rows: &[LinearRow<T>; R],
    u: &Stacked<T, D, C, R>,
    basis: Basis,
    products: &mut Stacked<T, D, C, R>,
) {
    let mut unknowns = products.iter_mut();
    for (u, law) in u.contacts.iter().zip(contacts) {
        for vector in law.basis(basis) {
            if let Some(unknown) = unknowns.next() {
                *unknown = product(vector, u);
            }
        }
    }
    for (&u, law) in u.rows.iter().zip(rows) {
        if law.count() > 0
            && let Some(unknown) = unknowns.next()
        {
            *unknown = law.scale * u;
        }
    }
}
