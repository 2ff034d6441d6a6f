//! Bounds on the rounding of the error of a solution.
//!
//! Each product and each sum is off by half an `eps` of what it gives at most (IEEE 754). A term of a sum of `n` products is part
//! of `n + 1` operations, so that the sum is off by `(n + 1) eps / 2` of the sum of the magnitudes of its terms (N. J. Higham,
//! *Accuracy and Stability of Numerical Algorithms*, section 3.1). By Cauchy-Schwarz in the norms of `M` and `W` is
//! `|M_ij|² <= M_ii M_jj` and `|H_aj|² <= W_aa M_jj`, if `M` is positive definite and `W` belongs to the same scene: [`bound`].
//!
//! Only if this cheap bound exceeds the tolerance, [`refine`] computes the sums again, as dot products that carry their error along
//! ([`crate::linalg::dot2`]). They are off by half an `eps` of what they give, and by the square of `(n + 1) eps / 2` of their terms.

use crate::cone::square;
use crate::laws::{Coulomb, Laws, Room};
use crate::linalg::dot2::Dot2;
use crate::linalg::hints::{opaque, opaque_mut, rolled};
use crate::linalg::sparsity::GROUP;
use crate::problem::dynamics::Dynamics;
use crate::problem::{ContactLaw, Problem};
use crate::scene::slot::Slot;
use crate::{Model, Real};
use nalgebra::SVector;

/// Squares of bounds on rounding.
#[derive(Clone, Copy)]
pub(crate) struct Rounding<T: Real, const C: usize, L: Laws = Coulomb> {
    /// That of `M v - M v_free - Hᵀ r`, in the unit of the dynamics.
    pub(crate) momentum: T,
    /// The same in the norm `Σ e_k² m / M_kk`.
    pub(crate) weighted: L::Room<T>,
    /// That of each `u_i = H_i v + w_i`, and that of its normal entry, (m/s)².
    pub(crate) velocities: [[T; 2]; C],
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
    // Half an `eps` for each operation that a term takes part in, squared.
    let precision = |operations: usize| {
        let share = T::EPSILON * T::count(operations) * T::literal(0.5);
        share * share
    };
    let mut velocities = [[T::ZERO; 2]; C];
    let contacts = problem.scene.supported().enumerate();
    let places = opaque_mut(&mut velocities).iter_mut().zip(contacts);
    for ((velocity, (i, (contact, support))), (law, r)) in places.zip(opaque(laws).iter().zip(r)) {
        rolled();
        let mut inertia = T::ZERO;
        if law.alpha > T::ZERO {
            inertia = T::count(D) / law.alpha;
        }
        let offset = problem.factor.scaled(i, contact.offset);
        // Columns of zeros take part in nothing.
        let columns = (GROUP * support.groups::<N>().count() + N % GROUP).max(1);
        let moved = energy / unit * T::count(columns);
        let mut bound =
            two * precision(columns + 4) * (square(offset.as_slice()) + inertia * moved);
        if problem.scene.slot(i).is_some_and(Slot::gives_way) {
            bound += two * precision(8) * square(&r.map(|r| inertia * r));
        }
        *velocity = [bound; 2];
        pushed += inertia * square(&r.map(|r| unit * r));
    }
    let terms = T::count(D * laws.len());
    let longest = N.max(D * laws.len());
    let noise = |free, sums| (two + T::ONE) * precision(longest + 2) * (free + sums);
    add_gap(problem, r, &mut velocities);
    let energy = energy * T::count(N);
    let least = (pushed * trace).min(momentum.pushed * unit * unit);
    let sums = energy * (unit * trace) + least * terms;
    let weighted = momentum.weighted.get().map(|weighted| {
        // `|M_kj|² <= M_kk M_jj`: what is weighted has a trace of `N`.
        let ratio = weighted.unit / unit;
        let sums = energy * ratio * weighted.unit + pushed * ratio * ratio * terms;
        noise(
            weighted.free,
            sums * T::count(N) * problem.scene.reference_mass(),
        )
    });
    Rounding {
        momentum: noise(momentum.plain.free, sums),
        weighted: weighted.map_or(L::Room::EMPTY, L::Room::with),
        velocities,
    }
}

/// Computes `u = H v + w` and `M v - M v_free - Hᵀ r` again, with twice the digits, of impulses in scaled rows and in rows that
/// are not; `cheap` are the bounds of [`bound`]. Returns the bounds that are left.
#[inline(never)]
pub(crate) fn refine<T: Real, const N: usize, const D: usize, const C: usize, L: Laws>(
    problem: &Problem<'_, T, N, D, C, L>,
    v: &[T; N],
    [scaled, r]: [&[[T; D]]; 2],
    (u, momentum): (&mut [[T; D]], &mut Dynamics<T, L>),
    cheap: &Rounding<T, C, L>,
) -> Rounding<T, C, L> {
    let (mass, [free]) = (&problem.scene.mass().data.0, &problem.free_impulse.data.0);
    let half = T::EPSILON * T::literal(0.5);
    let mut gaps = free.map(|free| Dot2::of(-free));
    for (column, &v) in opaque(mass).iter().zip(v) {
        rolled();
        for (gap, &mass) in gaps.iter_mut().zip(opaque(column)) {
            rolled();
            if mass != T::ZERO {
                gap.add(mass, v);
            }
        }
    }
    let mut velocities = cheap.velocities;
    let contacts = opaque(problem.scene.contacts()).iter().enumerate();
    let places = opaque_mut(&mut velocities).iter_mut().zip(u);
    for (((bound, u), (i, contact)), r) in places.zip(contacts).zip(r) {
        rolled();
        let mut sums = <[T; D]>::from(contact.offset).map(Dot2::of);
        let columns = contact.jacobian.data.0.iter();
        for ((&v, column), gap) in opaque(v).iter().zip(columns).zip(&mut gaps) {
            rolled();
            if *column == [T::ZERO; D] {
                continue;
            }
            for ((sum, &h), &r) in sums.iter_mut().zip(column).zip(r) {
                sum.add(h, v);
                gap.add(-h, r);
            }
        }
        let values = sums.map(Dot2::value);
        if !values.iter().all(T::is_finite) {
            continue; // too large to be halved
        }
        *u = values;
        // Once here, and on the way to a momentum; where a relaxed contact slides its parts cancel.
        let times = if problem.model == Model::Coulomb {
            2
        } else {
            5
        };
        let mut rounded = SVector::from(values).abs() * T::count(times);
        if let Some(slot) = problem.scene.slot(i) {
            // A product of up to four, and a sum.
            for (rounded, given) in rounded.iter_mut().zip(slot.given_way(r)) {
                *rounded += given.abs() * T::literal(5.0);
            }
        }
        let left = T::count(N + 4) * bound[0].square_root();
        let bounds = problem
            .factor
            .scaled(i, rounded)
            .map(|size| half * (size + left));
        *bound = [
            square(bounds.as_slice()),
            square(bounds.as_slice().get(..1).unwrap_or_default()),
        ];
    }
    add_gap(problem, scaled, &mut velocities);
    let gaps = gaps.map(Dot2::value);
    if !gaps.iter().all(T::is_finite) {
        return Rounding {
            velocities,
            ..*cheap
        };
    }
    let left = half * T::count(N + D * problem.laws().len() + 3);
    let left = |cheap: T| left * left * cheap;
    momentum.replace_gaps(problem.scene, &gaps);
    let rounded = |residual: T| half * half * residual;
    let two = T::ONE + T::ONE;
    let weighted = momentum.weighted.get().zip(cheap.weighted.get());
    let weighted = weighted.map(|(norms, &cheap)| two * (left(cheap) + rounded(norms.residual())));
    Rounding {
        momentum: two * (left(cheap.momentum) + rounded(momentum.plain.residual())),
        weighted: weighted.map_or(L::Room::EMPTY, L::Room::with),
        velocities,
    }
}

/// Adds to squares of bounds on velocities by how much a `W` that was given moves more than `H Hᵀ`:
/// `|W_ab - H_a·H_b| <= gap sqrt(W_aa W_bb)`.
#[inline]
fn add_gap<T: Real, const N: usize, const D: usize, const C: usize, L: Laws>(
    problem: &Problem<'_, T, N, D, C, L>,
    r: &[[T; D]],
    velocities: &mut [[T; 2]; C],
) {
    let gap = problem.scene.delassus_gap();
    if gap == T::ZERO {
        return;
    }
    let inertia = |law: &ContactLaw<T, D, L>| {
        if law.alpha > T::ZERO {
            T::count(D) / law.alpha
        } else {
            T::ZERO
        }
    };
    let mut speed = T::ZERO;
    for (law, r) in problem.laws().iter().zip(r) {
        let sum = r.iter().fold(T::ZERO, |sum, r| sum + r.abs());
        speed += gap * inertia(law).square_root() * sum;
    }
    for (velocity, law) in velocities.iter_mut().zip(problem.laws()) {
        // Of a sum of two the square is at most twice the sum of their squares.
        let gap = inertia(law) * (speed * speed);
        *velocity = velocity.map(|bound| (bound + gap) * T::literal(2.0));
    }
}

#[cfg(test)]
mod tests;
