//! The velocities `u = H v + w`, and the second part of the error, `|M v - M v_free - Hᵀ r|`.

use crate::linalg::cholesky::dot;
use crate::linalg::dot2::Dot2;
use crate::linalg::sparsity::add_products;
use crate::linalg::stacked::Stacked;
use crate::linalg::sum::{SizedSum, Sum, multiply_sized};
use crate::linalg::vector::{at_least, larger, quotient, root_sum};
use crate::linalg::zip::{zip3, zip4};
use crate::real::Real;
use crate::scene::{JointRow, Scene};

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
    /// `Hᵀ r`, with the magnitudes of the terms of both.
    pushed: [SizedSum<T>; N],
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
            let largest = larger(T::ZERO, &[free, inertia, pushed.sum], T::ONE);
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
        for (k, &free, &inertia, pushed) in zip4(0..N, momenta.free, &momenta.inertia, &momenta.pushed) {
            let terms = pushed.size;
            let (free, inertia, pushed) = (unit * free, unit * inertia, unit * pushed.sum);
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
    pub(crate) fn contact_velocities(&self, v: &[T; N], u: &mut Stacked<T, D, C, R>) {
        for (contact, support, u) in zip3(self.contacts(), self.supports(), &mut u.contacts) {
            let mut velocity: [T; D] = contact.offset.into();
            support.add_product((&contact.jacobian.data.0, self.velocities()), v, &mut velocity);
            *u = velocity;
        }
    }

    /// Fills `u` with `H v + w`, without compliance, and `sizes` with the sums of the magnitudes of its terms.
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
        for (contact, support, u, size) in
            zip4(self.contacts(), self.supports(), &mut u.contacts, &mut sizes.contacts)
        {
            let mut velocity = <[T; D]>::from(contact.offset).map(SizedSum::of);
            support.add_product((&contact.jacobian.data.0, n), v, &mut velocity);
            (*u, *size) = (velocity.map(|u| u.sum), velocity.map(|u| u.size));
        }
    }

    /// The dynamics of the velocity `v` and the impulses `r`, which are in physical rows.
    pub(crate) fn dynamics(&self, free: &[T; N], v: &[T; N], r: &Stacked<T, D, C, R>) -> Dynamics<T> {
        let mass = &self.mass().data.0;
        let n = self.velocities();
        let mut momenta = Momenta {
            free: free.get(..n).unwrap_or_default(),
            inertia: [T::ONE; N], // all of it is overwritten, and zeros would call memset
            pushed: [SizedSum { sum: T::ZERO, size: T::ONE }; N],
        };
        let Momenta { inertia, pushed, .. } = &mut momenta;
        multiply_sized((mass, n), v, (inertia, pushed));
        for (row, &r) in self.rows().iter().zip(&r.rows) {
            if r != T::ZERO {
                for (pushed, &entry) in pushed.iter_mut().zip(&row.row) {
                    pushed.add(entry, r);
                }
            }
        }
        for (contact, support, r) in zip3(self.contacts(), self.supports(), &r.contacts) {
            support.add_transposed_product((&contact.jacobian.data.0, n), *r, pushed);
        }
        let is_mixed = self.is_mixed();
        Dynamics {
            plain: Norms::of(&momenta, |_| T::ONE),
            weighted: is_mixed.then(|| Norms::of(&momenta, weights(mass))),
        }
    }

    /// Adds `Hᵀ r` to sums in twice the digits. `r` is in physical rows.
    #[inline]
    pub(crate) fn add_momentum(&self, r: &Stacked<T, D, C, R>, sums: &mut [Dot2<T>; N]) {
        for (contact, &r) in self.contacts().iter().zip(&r.contacts) {
            add_products(&contact.jacobian.data.0, r, sums);
        }
        for (row, &r) in self.rows().iter().zip(&r.rows) {
            for (sum, &entry) in sums.iter_mut().zip(&row.row) {
                sum.add(entry, r);
            }
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

#[cfg(test)]
mod tests;
