//! Bounds on the rounding of the error of a solution.
//!
//! A sum of products is trusted to `eps` times the sum of their magnitudes, which also covers a scene
//! that was rounded to this number type. By Cauchy-Schwarz in the norms of `M` and `W`,
//! `|M_ij|² <= M_ii M_jj` and `|H_aj|² <= W_aa M_jj`, if `M` is positive definite and `W` belongs to the same
//! scene. First this cheap upper bound; only if it exceeds the tolerance, the sums themselves.

use crate::Real;
use crate::cone::square;
use crate::laws::{Coulomb, Laws, Room};
use crate::linalg::hints::{opaque, opaque_mut, rolled};
use crate::problem::Problem;
use crate::problem::dynamics::Dynamics;
use crate::scene::slot::Slot;

/// Squares of bounds on rounding.
pub(crate) struct Rounding<T: Real, const C: usize, L: Laws = Coulomb> {
    /// That of `M v - M v_free - Hᵀ r`, in the unit of the dynamics.
    pub(crate) momentum: T,
    /// The same in the norm `Σ e_k² / M_kk`.
    pub(crate) weighted: L::Room<T>,
    /// That of each `u_i = H_i v + w_i`, (m/s)².
    pub(crate) velocities: [T; C],
}

/// Bounds on the sums of magnitudes, of impulses in scaled rows.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn bound<T: Real, const N: usize, const D: usize, const C: usize, L: Laws>(
    problem: &Problem<'_, T, N, D, C, L>,
    v: &[T; N],
    r: &[[T; D]],
    momentum: &Dynamics<T, L>,
) -> Rounding<T, C, L> {
    let (laws, mass) = (problem.laws(), &problem.scene.mass().data.0);
    let unit = momentum.plain.unit;
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
    let contacts = opaque(problem.scene.contacts()).iter().enumerate();
    let places = opaque_mut(&mut velocities).iter_mut().zip(contacts);
    for ((velocity, (i, contact)), (law, r)) in places.zip(opaque(laws).iter().zip(r)) {
        rolled();
        let mut inertia = T::ZERO;
        if law.alpha > T::ZERO {
            inertia = T::count(D) / law.alpha;
        }
        let offset = problem.factor.scaled(i, contact.offset);
        *velocity = two * precision * (square(offset.as_slice()) + inertia * squares);
        if problem.scene.slot(i).is_some_and(Slot::gives_way) {
            *velocity += two * precision * square(&r.map(|r| inertia * r));
        }
        pushed += inertia * square(&r.map(|r| unit * r));
    }
    let terms = T::count(D * laws.len());
    let noise = |free, sums| (two + T::ONE) * precision * (free + sums);
    let sums = energy * (unit * trace) + pushed * trace * terms;
    let weighted = momentum.weighted.get().map(|weighted| {
        // `|M_kj|² <= M_kk M_jj`: what is weighted has a trace of `N`.
        let ratio = weighted.unit / unit;
        let sums = energy * ratio * weighted.unit + pushed * ratio * ratio * terms;
        noise(weighted.free, sums * T::count(N))
    });
    Rounding {
        momentum: noise(momentum.plain.free, sums),
        weighted: weighted.map_or(L::Room::EMPTY, L::Room::with),
        velocities,
    }
}

/// The sums of magnitudes themselves, of impulses in rows that are not scaled.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn count<T: Real, const N: usize, const D: usize, const C: usize, L: Laws>(
    problem: &Problem<'_, T, N, D, C, L>,
    v: &[T; N],
    r: &[[T; D]],
    momentum: &Dynamics<T, L>,
) -> Rounding<T, C, L> {
    let (mass, [free]) = (&problem.scene.mass().data.0, &problem.free_impulse.data.0);
    let mut terms = [T::ZERO; N];
    for (column, &v) in opaque(mass).iter().zip(v) {
        rolled();
        for (terms, &mass) in terms.iter_mut().zip(opaque(column)) {
            rolled();
            *terms += (mass * v).abs();
        }
    }
    let mut velocities = [T::ZERO; C];
    let contacts = opaque(problem.scene.contacts()).iter().enumerate();
    let places = opaque_mut(&mut velocities).iter_mut().zip(contacts);
    for ((velocity, (i, contact)), r) in places.zip(r) {
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
        if let Some(slot) = problem.scene.slot(i) {
            for (magnitude, given) in magnitude.iter_mut().zip(slot.given_way(r)) {
                *magnitude += given.abs();
            }
        }
        let magnitude = problem.factor.scaled(i, magnitude.into());
        *velocity = T::EPSILON * T::EPSILON * square(magnitude.as_slice());
    }
    let (unit, other) = (momentum.plain.unit, momentum.weighted.get());
    let (mut noises, mut weighted) = (T::ZERO, T::ZERO);
    for (k, (&terms, &free)) in opaque(&terms).iter().zip(free).enumerate() {
        rolled();
        let noise = T::EPSILON * unit * (terms + free.abs());
        noises += noise * noise;
        if let (Some(other), Some(&mass)) = (other, mass.get(k).and_then(|column| column.get(k))) {
            let noise = T::EPSILON * (other.unit / mass.square_root()) * (terms + free.abs());
            weighted += noise * noise;
        }
    }
    Rounding {
        momentum: noises,
        weighted: other.map_or(L::Room::EMPTY, |_| L::Room::with(weighted)),
        velocities,
    }
}

#[cfg(test)]
mod tests;
