//! The velocities `u = H v + w`, and the second part of the error, `|M v - M v_free - Hᵀ r|`.

use crate::linalg::cholesky::{BLOCK, axpy, dot};
use crate::linalg::sparsity::{GROUP, add_columns, add_columns_and_sizes, add_products_and_sizes};
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::{at_least, larger, quotient, root_sum};
use crate::linalg::zip::{zip3, zip4, zip5};
use crate::real::Real;
use crate::scene::{JointRow, Scene};
use nalgebra::ComplexField;

/// Bytes of registers for the sums of a block. The sums of magnitudes take as many, and the terms a quarter of all registers: 128
/// bytes on a Cortex-M4F, 256 on a desktop (16 vectors of 16 bytes). So the sums take three eighths.
const SUMS: usize = if cfg!(target_os = "none") { 48 } else { 96 };

/// Norms of the momenta of a solution.
pub(crate) struct Dynamics<T: Real> {
    /// Euclidean norms.
    pub(crate) plain: Norms<T>,
    /// In a mixed scene norms `Σ e_k² / M_kk`, in which a light finger counts beside a heavy body.
    pub(crate) weighted: Option<Norms<T>>,
}

/// Squares of norms, in a unit in which neither `residual` nor `size` overflows or vanishes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Norms<T> {
    /// `|M v - M v_free - Hᵀ r|²`
    residual: T,
    /// The largest of `|M v_free|²`, `|M v|²` and `|Hᵀ r|²`, the denominator of the error.
    size: T,
    /// Square of the norm of the sums of the magnitudes of all terms.
    pub(crate) magnitude: T,
    pub(crate) unit: T,
}

/// The momenta of a solution.
struct Momenta<'a, T, const N: usize> {
    /// `M v_free`, of the velocities in use; the others are as long as there is room.
    free: &'a [T],
    /// `M v`
    inertia: [T; N],
    /// `Hᵀ r`
    pushed: [T; N],
    /// Sums of the magnitudes of the terms of `M v` and `Hᵀ r`.
    magnitudes: [T; N],
}

impl<T: Real> Norms<T> {
    /// Norms of momenta whose squares count with a weight for each dof.
    #[inline]
    fn of<const N: usize>(momenta: &Momenta<'_, T, N>, weight: impl Fn(usize) -> T + Copy) -> Self {
        let norms = Self::in_unit(momenta, T::ONE, weight);
        if norms.is_safe() {
            return norms;
        }
        // Twice the exponent of the unit: a bound on the exponent of each square.
        let mut exponent = None;
        for (k, &free, &inertia, &pushed) in zip4(0..N, momenta.free, &momenta.inertia, &momenta.pushed) {
            let largest = larger(T::ZERO, &[free, inertia, pushed], T::ONE);
            if largest > T::ZERO && largest.is_finite() {
                exponent = exponent.max(Some(2 * largest.exponent() + weight(k).exponent()));
            }
        }
        let unit = exponent.map_or(T::ONE, |exponent: i32| T::power_of_two(-(exponent >> 1)));
        Self::in_unit(momenta, unit, weight)
    }

    /// Norms of a momentum that balances but for rounding: `free` is `|M v_free|²`.
    pub(crate) fn balanced(free: T) -> Self {
        Self { residual: T::ZERO, size: free, magnitude: T::ZERO, unit: T::ONE }
    }

    /// Is the size so far from both ends of the range that no square has overflown, and none that counts has vanished?
    fn is_safe(&self) -> bool {
        let tiny = T::EPSILON * T::EPSILON * T::EPSILON;
        self.size > tiny && self.size * tiny < T::ONE
    }

    /// [`Self::of`] in this unit.
    #[cfg_attr(target_os = "none", inline(never))]
    fn in_unit<const N: usize>(momenta: &Momenta<'_, T, N>, unit: T, weight: impl Fn(usize) -> T) -> Self {
        let [mut residual, mut size_free, mut size_v, mut size_r, mut magnitude] = [T::ZERO; 5];
        for (k, &free, &inertia, &pushed, &terms) in
            zip5(0..N, momenta.free, &momenta.inertia, &momenta.pushed, &momenta.magnitudes)
        {
            let (free, inertia, pushed) = (unit * free, unit * inertia, unit * pushed);
            let (difference, weight) = (inertia - free - pushed, weight(k));
            let terms = unit * terms + free.abs();
            residual += difference * difference * weight;
            size_free += free * free * weight;
            size_v += inertia * inertia * weight;
            size_r += pushed * pushed * weight;
            magnitude += terms * terms * weight;
        }
        Self { residual, size: at_least(size_r, at_least(size_v, size_free)), magnitude, unit }
    }

    /// Second part of the error, `|M v - M v_free - Hᵀ r| / max(|M v_free|, |M v|, |Hᵀ r|)`. `noise` is the square of a bound on the
    /// rounding of its numerator, in the same unit.
    pub(crate) fn error(&self, noise: T) -> T {
        root_sum(self.residual, noise, self.size)
    }

    /// `|M v - M v_free - Hᵀ r|²`
    pub(crate) fn residual(&self) -> T {
        self.residual
    }

    /// Replaces the residual by that of the differences `M v - M v_free - Hᵀ r`.
    fn replace_residual(&mut self, differences: &[T], weight: impl Fn(usize) -> T) {
        self.residual = T::ZERO;
        for (k, &difference) in differences.iter().enumerate() {
            let difference = self.unit * difference;
            self.residual += difference * difference * weight(k);
        }
    }

    /// Reduces the size by a bound on its rounding, this share of the magnitudes. Returns the square of the bound.
    pub(crate) fn reduce_size(&mut self, share: T) -> T {
        let noise = share * share * self.magnitude;
        // The root of a quotient, which does not depend on the unit.
        let rest = (T::ONE - quotient(noise, self.size).square_root()).max(T::ZERO);
        self.size *= rest * rest;
        noise
    }

    /// Sets the least size, a square in the unit.
    pub(crate) fn set_least_size(&mut self, least: T) {
        self.size = self.size.max(least);
    }
}

impl<T: Real> Dynamics<T> {
    /// Replaces the residuals by those of the differences `M v - M v_free - Hᵀ r`.
    pub(crate) fn replace_residual<const N: usize>(&mut self, mass: &[[T; N]; N], differences: &[T]) {
        self.plain.replace_residual(differences, |_| T::ONE);
        if let Some(weighted) = &mut self.weighted {
            weighted.replace_residual(differences, weights(mass));
        }
    }
}

/// `1 / M_kk`
fn weights<T: Real, const N: usize>(mass: &[[T; N]; N]) -> impl Fn(usize) -> T + Copy {
    move |k| {
        let diagonal = mass.get(k).and_then(|column| column.get(k)).copied();
        T::ONE / diagonal.unwrap_or(T::ONE)
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Scene<T, N, D, C, R, S>
{
    /// Fills `u` with `H v + w`, without compliance, in a scene without joint rows.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn contact_velocities(&self, v: &[T; N], u: &mut Stacked<T, D, C, R>) {
        let n = self.velocities();
        let (groups, last) = v.as_chunks::<GROUP>();
        for (contact, support, u) in zip3(self.contacts(), self.supports(), &mut u.contacts) {
            let mut velocity: [T; D] = contact.offset.into();
            let (columns, rest) = contact.jacobian.data.0.as_chunks::<GROUP>();
            for group in support.groups::<N>(n) {
                if let (Some(columns), Some(v)) = (columns.get(group), groups.get(group)) {
                    add_columns(columns, v, &mut velocity);
                }
            }
            add_columns(rest, last, &mut velocity);
            *u = velocity;
        }
    }

    /// Fills `u` with `H v + w`, without compliance, and `sizes` with the sums of the magnitudes of its terms.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn velocities_and_sizes(
        &self,
        v: &[T; N],
        u: &mut Stacked<T, D, C, R>,
        sizes: &mut Stacked<T, D, C, R>,
    ) {
        let n = self.velocities();
        // As many as in a kernel of this size: `dot` sums them in the same groups.
        let in_use = v.get(..n).unwrap_or_default();
        for (row, u, size) in zip3(self.rows(), &mut u.rows, &mut sizes.rows) {
            (*u, *size) = row_velocity(row, in_use);
        }
        let (groups, last) = v.as_chunks::<GROUP>();
        for (contact, support, u, size) in
            zip4(self.contacts(), self.supports(), &mut u.contacts, &mut sizes.contacts)
        {
            let mut velocity: [T; D] = contact.offset.into();
            let mut terms = velocity.map(ComplexField::abs);
            let (columns, rest) = contact.jacobian.data.0.as_chunks::<GROUP>();
            for group in support.groups::<N>(n) {
                if let (Some(columns), Some(v)) = (columns.get(group), groups.get(group)) {
                    add_columns_and_sizes(columns, v, &mut velocity, &mut terms);
                }
            }
            add_columns_and_sizes(rest, last, &mut velocity, &mut terms);
            (*u, *size) = (velocity, terms);
        }
    }

    /// The dynamics of the velocity `v` and the impulses `r`, which are in physical rows.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn dynamics(&self, free: &[T; N], v: &[T; N], r: &Stacked<T, D, C, R>) -> Dynamics<T> {
        let mass = &self.mass().data.0;
        let n = self.velocities();
        let mut momenta = Momenta {
            free: free.get(..n).unwrap_or_default(),
            inertia: [T::ONE; N], // all of it is overwritten, and zeros would call memset
            pushed: [T::ZERO; N],
            magnitudes: [T::ONE; N],
        };
        let Momenta { inertia, pushed, magnitudes, .. } = &mut momenta;
        multiply((mass, n), v, inertia, magnitudes);
        for (row, &r) in self.rows().iter().zip(&r.rows) {
            if r != T::ZERO {
                let [entries] = &row.row.data.0;
                axpy(r, entries, pushed);
                for (magnitude, &entry) in magnitudes.iter_mut().zip(entries) {
                    *magnitude += (r * entry).abs();
                }
            }
        }
        let (pushed, last_pushed) = pushed.as_chunks_mut::<GROUP>();
        let (magnitudes, last_magnitudes) = magnitudes.as_chunks_mut::<GROUP>();
        for (contact, support, r) in zip3(self.contacts(), self.supports(), &r.contacts) {
            let (columns, rest) = contact.jacobian.data.0.as_chunks::<GROUP>();
            for group in support.groups::<N>(n) {
                let (pushed, magnitudes) = (pushed.get_mut(group), magnitudes.get_mut(group));
                if let (Some(columns), Some(pushed), Some(magnitudes)) =
                    (columns.get(group), pushed, magnitudes)
                {
                    add_products_and_sizes(columns, *r, pushed, magnitudes);
                }
            }
            add_products_and_sizes(rest, *r, last_pushed, last_magnitudes);
        }
        let is_mixed = self.is_mixed();
        Dynamics {
            plain: Norms::of(&momenta, |_| T::ONE),
            weighted: is_mixed.then(|| Norms::of(&momenta, weights(mass))),
        }
    }
}

/// Velocity `row · v + offset` of a joint row, without compliance, and the sum of the magnitudes of its terms.
#[inline]
fn row_velocity<T: Real, const N: usize>(row: &JointRow<T, N>, v: &[T]) -> (T, T) {
    let [entries] = &row.row.data.0;
    let mut size = row.offset.abs();
    for (&entry, &v) in entries.iter().zip(v) {
        size += (entry * v).abs();
    }
    (dot(entries, v) + row.offset, size)
}

/// Fills `products` with `M v`, and `magnitudes` with the sums of the magnitudes of its terms.
#[inline]
fn multiply<T: Real, const N: usize>(
    (mass, n): (&[[T; N]; N], usize),
    v: &[T; N],
    products: &mut [T; N],
    magnitudes: &mut [T; N],
) {
    let mass = mass.get(..n).unwrap_or_default();
    if N * size_of::<T>() <= SUMS {
        return multiply_rows::<T, N, N>(mass, 0, v, products, magnitudes);
    }
    // The last block repeats some rows, so that all blocks have the same size.
    let (mut first, last) = (0, n.saturating_sub(BLOCK));
    while first < last + BLOCK {
        multiply_rows::<T, N, BLOCK>(mass, first.min(last), v, products, magnitudes);
        first += BLOCK;
    }
}

/// `K` entries of [`multiply`] from row `first` on.
#[inline]
fn multiply_rows<T: Real, const N: usize, const K: usize>(
    mass: &[[T; N]],
    first: usize,
    v: &[T; N],
    products: &mut [T; N],
    magnitudes: &mut [T; N],
) {
    let mut sums = [[T::ZERO; 2]; K];
    // A slice, since a loop over the array would be unrolled, with more sums than registers.
    for (column, &v) in mass.iter().zip(v) {
        let Some(column) = column.get(first..).and_then(<[T]>::first_chunk::<K>) else {
            break;
        };
        for ([sum, size], &mass) in sums.iter_mut().zip(column) {
            let product = mass * v;
            *sum += product;
            *size += product.abs();
        }
    }
    let products = products.get_mut(first..).unwrap_or_default();
    let magnitudes = magnitudes.get_mut(first..).unwrap_or_default();
    for (product, magnitude, [sum, size]) in zip3(products, magnitudes, sums) {
        (*product, *magnitude) = (sum, size);
    }
}

#[cfg(test)]
mod tests;
