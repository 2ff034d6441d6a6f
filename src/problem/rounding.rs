//! Bounds on the rounding of the error of a solution.
//!
//! A sum of products is trusted to `eps` times the sum of their magnitudes, which also covers a scene
//! that was rounded to this number type. By Cauchy-Schwarz in the norms of `M` and `W`,
//! `|M_ij|² <= M_ii M_jj` and `|H_aj|² <= W_aa M_jj`, if `M` is positive definite and `W` belongs to the same
//! scene. First this cheap upper bound; only if it exceeds the tolerance, the sums themselves.

use crate::cone::square;
use crate::laws::Laws;
use crate::linalg::hints::{opaque, opaque_mut, rolled};
use crate::problem::ContactLaw;
use crate::problem::dynamics::Dynamics;
use crate::{Contact, Real};

/// Squares of bounds on rounding.
pub(crate) struct Rounding<T, const C: usize> {
    /// That of `M v - M v_free - Hᵀ r`, in the given unit.
    pub(crate) momentum: T,
    /// That of each `u_i = H_i v + w_i`, (m/s)².
    pub(crate) velocities: [T; C],
}

/// Bounds on the sums of magnitudes.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn bound<T: Real, const N: usize, const D: usize, const C: usize, L: Laws>(
    laws: &[ContactLaw<T, D, L>],
    mass: &[[T; N]; N],
    contacts: &[Contact<T, N, D>],
    v: &[T; N],
    r: &[[T; D]],
    momentum: &Dynamics<T>,
) -> Rounding<T, C> {
    let unit = momentum.unit;
    // `Σ M_jj`, `Σ M_jj v_j²` and `Σ W_aa r_a²`, with as many units as keep them near 1.
    let [mut trace, mut energy, mut pushed] = [T::ZERO; 3];
    for (j, (column, &v)) in opaque(mass).iter().zip(v).enumerate() {
        rolled();
        let mass = column.get(j).copied().unwrap_or(T::ZERO);
        trace += mass;
        energy += unit * mass * v * v;
    }
    let two = T::ONE + T::ONE;
    let precision = T::EPSILON * T::EPSILON;
    let energy = energy * T::count(N);
    let squares = energy / unit; // over `W_aa`
    let mut velocities = [T::ZERO; C];
    let places = opaque_mut(&mut velocities).iter_mut().zip(opaque(contacts));
    for ((velocity, contact), (law, r)) in places.zip(opaque(laws).iter().zip(r)) {
        rolled();
        let mut inertia = T::ZERO;
        if law.alpha > T::ZERO {
            inertia = T::count(D) / law.alpha;
        }
        *velocity = two * precision * (square(contact.offset.as_slice()) + inertia * squares);
        pushed += inertia * square(&r.map(|r| unit * r));
    }
    let sums = energy * (unit * trace) + pushed * trace * T::count(D * laws.len());
    Rounding {
        momentum: (two + T::ONE) * precision * (momentum.free + sums),
        velocities,
    }
}

/// The sums of magnitudes themselves.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn count<T: Real, const N: usize, const D: usize, const C: usize>(
    mass: &[[T; N]; N],
    contacts: &[Contact<T, N, D>],
    free: &[T; N],
    v: &[T; N],
    r: &[[T; D]],
    unit: T,
) -> Rounding<T, C> {
    let mut terms = [T::ZERO; N];
    for (column, &v) in opaque(mass).iter().zip(v) {
        rolled();
        for (terms, &mass) in terms.iter_mut().zip(opaque(column)) {
            rolled();
            *terms += (mass * v).abs();
        }
    }
    let mut velocities = [T::ZERO; C];
    let places = opaque_mut(&mut velocities).iter_mut().zip(opaque(contacts));
    for ((velocity, contact), r) in places.zip(r) {
        rolled();
        let mut magnitude: [T; D] = contact.offset.abs().into();
        let columns = contact.jacobian.data.0.iter();
        for ((&v, column), terms) in opaque(v).iter().zip(columns).zip(&mut terms) {
            rolled();
            for ((magnitude, &h), &r) in magnitude.iter_mut().zip(column).zip(r) {
                *magnitude += (h * v).abs();
                *terms += (h * r).abs();
            }
        }
        *velocity = T::EPSILON * T::EPSILON * square(&magnitude);
    }
    let mut momentum = T::ZERO;
    for (&terms, &free) in opaque(&terms).iter().zip(free) {
        rolled();
        let noise = T::EPSILON * unit * (terms + free.abs());
        momentum += noise * noise;
    }
    Rounding {
        momentum,
        velocities,
    }
}

#[cfg(test)]
mod tests;
