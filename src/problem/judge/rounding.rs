//! Bounds on the rounding of the error of a solution; [`crate::guide::error`] lists them.
//!
//! Each product and each sum is off by at most `eps / 2` of its result (IEEE 754). A term of a sum of `n` products and an offset takes part
//! in `n + 1` operations, so the sum is off by at most `(n + 1) eps / 2` of the sum of the magnitudes of its terms (C.-P. Jeannerod and S. M.
//! Rump, 2013). `judge/dynamics.rs` computes these sums of magnitudes beside the sums.
//!
//! If the error with a bound exceeds the tolerance, [`Problem::sum_exactly`] computes the sums again as dot products that carry their
//! error along ([`crate::linalg::dot2`]). These are off by `eps / 2` of their result, and at most
//! `(n + 4) (n + 1 + k) (eps / 2)²` of the magnitudes of their terms, if `k` operations follow. Each of these adds `eps / 2` of
//! the result.

use crate::linalg::dot2::Dot2;
use crate::linalg::sparsity::add_columns;
use crate::linalg::stacked::Stacked;
use crate::linalg::sum::Sum;
use crate::linalg::vector::{rounding_bound, square};
use crate::linalg::zip::{zip3, zip4, zip5};
use crate::problem::Problem;
use crate::problem::judge::dynamics::Dynamics;
use crate::real::Real;
use crate::sets::Sets;
use crate::sets::energy::VelocityNoise;
use crate::solution::Model;

/// Squares of bounds on rounding.
#[derive(Clone, Copy)]
pub(crate) struct Rounding<T: Real, const C: usize, const R: usize> {
    /// Of `M v - M v_free - Hᵀ r`, in the unit of [`Dynamics::plain`].
    pub(crate) momentum: T,
    /// Of the same in the norm `Σ e_k² / M_kk`, in the unit of [`Dynamics::weighted`].
    pub(crate) weighted: T,
    /// Of the velocities of contacts and joint rows.
    pub(crate) velocities: VelocityNoise<T, C, R>,
}

/// Number of operations in which a velocity of compliance takes part: a product of up to five factors, a sum, and the operations on
/// its way to a momentum.
const COMPLIANCE: usize = 8;

/// Number of operations in which a velocity takes part after the sum of its terms: one product by `alpha`; on a surface the sum with
/// the velocity of compliance and the scaling; in the relaxation the cancellation of the parts of a sliding contact.
pub(super) fn operations_after<const D: usize>(has_surface: bool, model: Model) -> usize {
    let on_surface = if has_surface { 2 } else { 0 };
    let relaxed = match model {
        Model::Coulomb => 0,
        Model::ConvexRelaxation => 3 + usize::from(D > 3),
    };
    1 + on_surface + relaxed
}

impl<T: Real, const C: usize, const R: usize> Rounding<T, C, R> {
    /// Bounds that are still to be written. (Zeros would call `memset`.)
    pub(crate) fn unset() -> Self {
        let velocities = VelocityNoise { contacts: [[T::ONE; 2]; C], rows: [T::ONE; R] };
        Self { momentum: T::ONE, weighted: T::ONE, velocities }
    }

    /// Second part of the error, the larger of both norms of a momentum.
    pub(crate) fn momentum_error(&self, dynamics: &Dynamics<T>) -> T {
        let plain = dynamics.plain.error(self.momentum);
        dynamics.weighted.as_ref().map_or(plain, |weighted| plain.max(weighted.error(self.weighted)))
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Problem<'_, T, N, D, C, R, S>
{
    /// Bounds on velocities from the sums `sizes` of the magnitudes of their terms, without compliance. The impulses `written` are in
    /// physical rows.
    pub(crate) fn velocity_rounding(
        &self,
        written: &Stacked<T, D, C, R>,
        sizes: &Stacked<T, D, C, R>,
        bounds: &mut VelocityNoise<T, C, R>,
    ) {
        let (scene, sets, n) = (self.scene, &self.sets, self.scene.velocities());
        let used = 0..sets.contacts().len();
        for (i, bound, sizes, r) in zip4(used, &mut bounds.contacts, &sizes.contacts, &written.contacts) {
            let scaling = scene.scaling(i);
            let after = operations_after::<D>(scaling.is_some(), self.model);
            let share = rounding_bound::<T>(n + 1 + after);
            let mut bounds = sizes.map(|size| share * size);
            if let Some(scaling) = scaling {
                for (bound, added) in bounds.iter_mut().zip(scaling.compliance_velocity(r)) {
                    *bound += rounding_bound::<T>(COMPLIANCE) * added.abs();
                }
            }
            *bound = squares(&scene.scaled_velocity(i, bounds));
        }
        let share = rounding_bound::<T>(n + 3);
        for (bound, row, &size, &r) in zip4(&mut bounds.rows, scene.rows(), &sizes.rows, &written.rows) {
            let added = rounding_bound::<T>(COMPLIANCE) * (row.compliance * r).abs();
            *bound = square(&[share * size + added]);
        }
    }

    /// Bounds on momenta from the sums of the magnitudes of their terms.
    #[inline]
    pub(crate) fn momentum_rounding(&self, dynamics: &mut Dynamics<T>, rounding: &mut Rounding<T, C, R>) {
        // A term of `M v` or of `Hᵀ r` takes part in one of these sums, and in two more.
        let share = rounding_bound::<T>(self.scene.velocities().max(rows(&self.sets)) + 3);
        rounding.momentum = dynamics.plain.reduce_size(share);
        rounding.weighted = dynamics.weighted.as_mut().map_or(T::ZERO, |norms| norms.reduce_size(share));
    }

    /// Computes `u = H v + w` with the velocities of compliance, and `M v_free + Hᵀ r - M v`, again with twice the digits. It replaces
    /// the bounds of [`Self::velocity_rounding`] and [`Self::momentum_rounding`] by those of the new sums.
    #[inline(never)]
    pub(crate) fn sum_exactly(
        &self,
        v: &[T; N],
        written: &Stacked<T, D, C, R>,
        (u, dynamics): (&mut Stacked<T, D, C, R>, &mut Dynamics<T>),
        rounding: &mut Rounding<T, C, R>,
    ) {
        let [free] = &self.free_impulse.data.0;
        let (mass, n) = (&self.scene.mass().data.0, self.scene.velocities());
        let bounds = &mut rounding.velocities;
        self.sum_contacts_exactly(v, written, u, bounds);
        self.sum_rows_exactly(v, written, u, bounds);
        let mut differences = free.map(Dot2::of);
        for (column, &v) in mass.iter().zip(v).take(n) {
            for (difference, &mass) in differences.iter_mut().zip(column) {
                difference.add(mass, -v);
            }
        }
        self.scene.add_momentum(written, &mut differences);
        let differences = differences.map(Dot2::value);
        let differences = differences.get(..n).unwrap_or_default();
        if !differences.iter().all(T::is_finite) {
            return;
        }
        dynamics.replace_residual(mass, differences);
        // Here all terms stand in one sum. `(a + b)² <= 2 (a² + b²)`
        let half = T::EPSILON * T::literal(0.5);
        let share = rounding_bound::<T>(n + rows(&self.sets) + 3);
        let norms = [Some(&dynamics.plain), dynamics.weighted.as_ref()];
        [rounding.momentum, rounding.weighted] = norms.map(|norms| {
            norms.map_or(T::ZERO, |norms| {
                let (rounded, share) = (half * half * norms.residual(), share * share);
                T::literal(2.0) * (share * share * norms.magnitude + rounded)
            })
        });
    }

    /// The part of [`Self::sum_exactly`] for the velocities of contacts.
    #[inline]
    fn sum_contacts_exactly(
        &self,
        v: &[T; N],
        written: &Stacked<T, D, C, R>,
        u: &mut Stacked<T, D, C, R>,
        bounds: &mut VelocityNoise<T, C, R>,
    ) {
        let (scene, half) = (self.scene, T::EPSILON * T::literal(0.5));
        for (i, bound, u, contact, r) in
            zip5(0..C, &mut bounds.contacts, &mut u.contacts, scene.contacts(), &written.contacts)
        {
            let mut sums = <[T; D]>::from(contact.offset).map(Dot2::of);
            add_columns(&contact.jacobian.data.0, v, &mut sums);
            let values = sums.map(Dot2::value);
            if !values.iter().all(T::is_finite) {
                continue; // too large for a product in twice the digits
            }
            *u = values;
            let scaling = scene.scaling(i);
            let times = 1 + operations_after::<D>(scaling.is_some(), self.model);
            let mut rounded = values.map(|value| value.abs() * T::count(times));
            if let Some(scaling) = scaling {
                for (rounded, u, added) in zip3(&mut rounded, u, scaling.compliance_velocity(r)) {
                    *u += added;
                    *rounded += added.abs() * T::count(COMPLIANCE);
                }
            }
            let second_order = T::count(self.scene.velocities() + 4) * bound[0].square_root();
            let sizes = scene.scaled_velocity(i, rounded);
            *bound = squares(&sizes.map(|size| half * (size + second_order)));
        }
    }

    /// The part of [`Self::sum_exactly`] for the velocities of joint rows.
    #[inline]
    fn sum_rows_exactly(
        &self,
        v: &[T; N],
        written: &Stacked<T, D, C, R>,
        u: &mut Stacked<T, D, C, R>,
        bounds: &mut VelocityNoise<T, C, R>,
    ) {
        for (bound, u, row, &r) in zip4(&mut bounds.rows, &mut u.rows, self.scene.rows(), &written.rows) {
            let mut sum = Dot2::of(row.offset);
            for (&v, &h) in v.iter().zip(&row.row) {
                sum.add(h, v);
            }
            let value = sum.value();
            if value.is_finite() {
                let added = row.compliance * r;
                *u = value + added;
                let rounded = value.abs() * T::literal(3.0) + added.abs() * T::count(COMPLIANCE);
                let second_order = T::count(self.scene.velocities() + 4) * bound.square_root();
                let half = T::EPSILON * T::literal(0.5);
                *bound = square(&[half * (rounded + second_order)]);
            }
        }
    }
}

/// Number of rows of contacts and joint rows in use.
pub(super) fn rows<T: Real, const D: usize, const C: usize, const R: usize>(
    sets: &Sets<T, D, C, R>,
) -> usize {
    D * sets.contacts().len() + sets.rows().len()
}

/// Square of the norm of all rows of a contact, and of the normal row.
fn squares<T: Real, const D: usize>(bounds: &[T; D]) -> [T; 2] {
    [square(bounds), square(bounds.get(..1).unwrap_or_default())]
}

#[cfg(test)]
mod tests;
