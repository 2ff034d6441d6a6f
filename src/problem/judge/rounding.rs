//! Bounds on the rounding of the error of a solution.
//!
//! Each product and each sum is off by half an `eps` of what it gives at most (IEEE 754). A term of a sum of `n` products is part
//! of `n + 1` operations, so that the sum is off by `(n + 1) eps / 2` of the sum of the magnitudes of its terms (N. J. Higham,
//! *Accuracy and Stability of Numerical Algorithms*, section 3.1). Those sums are added up beside the sums themselves: [`bound`].
//!
//! Only if this bound exceeds the tolerance, [`refine`] computes the sums again, as dot products that carry their error along
//! ([`crate::linalg::dot2`]). They are off by half an `eps` of what they give, and by the square of `(n + 1) eps / 2` of their terms.

use crate::linalg::dot2::Dot2;
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::{precision, square};
use crate::problem::Problem;
use crate::problem::judge::dynamics::{Dynamics, Norms};
use crate::real::Real;
use crate::sets::Sets;
use crate::sets::energy::VelocityNoise;
use crate::solution::Model;

/// Squares of bounds on rounding.
#[derive(Clone, Copy)]
pub(crate) struct Rounding<T: Real, const C: usize, const R: usize> {
    /// That of `M v - M v_free - Hᵀ r`, in the unit of the dynamics.
    pub(crate) momentum: T,
    /// The same in the norm `Σ e_k² / M_kk`.
    pub(crate) weighted: T,
    /// That of each velocity.
    pub(crate) velocities: VelocityNoise<T, C, R>,
}

/// Operations that a velocity of compliance takes part in: a product of up to five, a sum, and those on the way to a momentum.
const COMPLIANCE: usize = 8;

/// Operations that a velocity takes part in once its terms are added up: on a surface compliance is added, and it is scaled; all are
/// multiplied by `alpha`; and where a relaxed contact slides its parts cancel.
fn operations_after<const D: usize>(has_surface: bool, model: Model) -> usize {
    let on_surface = if has_surface { 2 } else { 0 };
    let relaxed = match model {
        Model::Coulomb => 0,
        Model::ConvexRelaxation => 3 + usize::from(D > 3),
    };
    1 + on_surface + relaxed
}

/// Bounds from the sums of magnitudes: `sizes` of velocities without compliance, of impulses in rows that are not scaled.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn bound<
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize,
    const S: usize,
>(
    problem: &Problem<'_, T, N, D, C, R, S>,
    written: &Stacked<T, D, C, R>,
    sizes: &Stacked<T, D, C, R>,
    momentum: &mut Dynamics<T>,
) -> Rounding<T, C, R> {
    let (scene, sets) = (problem.scene, &problem.sets);
    let mut velocities = VelocityNoise {
        contacts: [[T::ZERO; 2]; C],
        rows: [T::ZERO; R],
    };
    let sources = sizes.contacts.iter().zip(&written.contacts).enumerate();
    let sources = sources.take(sets.contacts().len());
    for (bound, (i, (sizes, r))) in velocities.contacts.iter_mut().zip(sources) {
        let scaling = scene.scaling(i);
        let after = operations_after::<D>(scaling.is_some(), problem.model);
        let own = precision::<T>(N + 1 + after);
        let mut bounds = sizes.map(|size| own * size);
        if let Some(scaling) = scaling {
            for (bound, added) in bounds.iter_mut().zip(scaling.compliance_velocity(r)) {
                *bound += precision::<T>(COMPLIANCE) * added.abs();
            }
        }
        *bound = squares(&scene.scale(i, bounds));
    }
    let sources = scene
        .rows()
        .iter()
        .zip(sizes.rows.iter().zip(&written.rows));
    let own = precision::<T>(N + 3);
    for (bound, (row, (&size, &r))) in velocities.rows.iter_mut().zip(sources) {
        let added = precision::<T>(COMPLIANCE) * (row.compliance * r).abs();
        *bound = square(&[own * size + added]);
    }
    // A term of `M v` or of `Hᵀ r` takes part in a sum of its own, and in two more.
    let share = precision::<T>(N.max(rows(sets)) + 3);
    let noise = |norms: &mut Norms<T>| {
        let noise = share * share * norms.magnitude;
        norms.compare_with_less(noise);
        noise
    };
    Rounding {
        momentum: noise(&mut momentum.plain),
        weighted: momentum.weighted.as_mut().map_or(T::ZERO, noise),
        velocities,
    }
}

/// The share of the tolerance that bounds without sums of magnitudes may take.
const CRUDE: f64 = 0.125;

/// Bounds without sums of magnitudes, from the diagonals of `M` and `W` alone, in double precision and without joint rows; `None` if they
/// may be too much of the tolerance.
///
/// `M` and `W = H M⁻¹ Hᵀ` are positive semidefinite: `|M_ik| <= sqrt(M_ii M_kk)` and `|H_ak| <= sqrt(W_aa M_kk)`. With
/// `S = Σ_k sqrt(M_kk) |v_k|` and `P = Σ_a sqrt(W_aa) |r_a|` the magnitudes of the terms of a momentum are then at most
/// `sqrt(M_kk) (S + P) + |f_k|`, and those of a velocity `sqrt(W_aa) S + |w_a|`.
#[inline]
pub(crate) fn crude<
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize,
    const S: usize,
>(
    problem: &Problem<'_, T, N, D, C, R, S>,
    v: &[T; N],
    r: &Stacked<T, D, C, R>,
    tolerance: T,
) -> Option<Rounding<T, C, R>> {
    let (scene, sets, [free]) = (problem.scene, &problem.sets, &problem.free_impulse.data.0);
    // Single precision has too few digits for them.
    let usable = T::EPSILON < T::literal(1e-10)
        && !scene.is_mixed()
        && problem.factor.uncertainty() < T::literal(0.1);
    if !usable {
        return None;
    }
    let (mut trace, mut energy) = (T::ZERO, T::ZERO);
    let columns = scene.mass().data.0.iter().zip(v).enumerate();
    for (k, (column, &v)) in columns {
        let mass = column.get(k).copied().unwrap_or(T::ZERO);
        trace += mass;
        energy += mass * (v * v);
    }
    let free = square(free);
    // Squares of `S` and `P`, by Cauchy and Schwarz, and twice as large: for their own rounding, and that of `W`.
    let moved = T::count(2 * N) * energy;
    let own = precision::<T>(N + 1 + operations_after::<D>(false, problem.model));
    let own = T::literal(2.0) * own * own;
    let mut velocities = VelocityNoise {
        contacts: [[T::ONE; 2]; C],
        rows: [T::ONE; R],
    };
    let mut pushed = T::ZERO;
    let sources = sets
        .contacts()
        .iter()
        .zip(scene.contacts())
        .zip(&r.contacts);
    for (bound, ((set, contact), r)) in velocities.contacts.iter_mut().zip(sources) {
        let inverse = set.inverse_mass();
        pushed += inverse * square(r);
        *bound = [own * (square(&<[T; D]>::from(contact.offset)) + inverse * moved); 2];
    }
    let pushed = T::count(2 * C) * pushed;
    // Of a sum of three the square is at most three times the sum of their squares.
    let share = precision::<T>(N.max(rows(sets)) + 3);
    let terms = T::literal(3.0) * (trace * (moved + pushed) + free);
    let noise = share * share * terms;
    let tiny = T::EPSILON * T::EPSILON * T::EPSILON;
    let enough = T::literal(CRUDE) * tolerance;
    let is_safe = energy > tiny && free > tiny && terms * tiny < T::ONE;
    (is_safe && noise <= enough * enough * free).then_some(Rounding {
        momentum: noise,
        weighted: T::ZERO,
        velocities,
    })
}

/// Rows of contacts and joint rows in use.
fn rows<T: Real, const D: usize, const C: usize, const R: usize>(sets: &Sets<T, D, C, R>) -> usize {
    D * sets.contacts().len() + sets.rows().len()
}

/// Squares of all rows of a contact, and of the normal one.
fn squares<T: Real, const D: usize>(bounds: &[T; D]) -> [T; 2] {
    [square(bounds), square(bounds.get(..1).unwrap_or_default())]
}

/// Computes `u = H v + w`, with what compliance adds, and `M v - M v_free - Hᵀ r` again, with twice the digits; the bounds of [`bound`]
/// become those that are left.
#[inline(never)]
pub(crate) fn refine<
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize,
    const S: usize,
>(
    problem: &Problem<'_, T, N, D, C, R, S>,
    v: &[T; N],
    written: &Stacked<T, D, C, R>,
    (u, momentum): (&mut Stacked<T, D, C, R>, &mut Dynamics<T>),
    rounding: &mut Rounding<T, C, R>,
) {
    let (scene, [free]) = (problem.scene, &problem.free_impulse.data.0);
    let mass = &scene.mass().data.0;
    let half = T::EPSILON * T::literal(0.5);
    let mut gaps = free.map(|free| Dot2::of(-free));
    for (column, &v) in mass.iter().zip(v) {
        for (gap, &mass) in gaps.iter_mut().zip(column) {
            if mass != T::ZERO {
                gap.add(mass, v);
            }
        }
    }
    let velocities = &mut rounding.velocities;
    let places = velocities.contacts.iter_mut().zip(&mut u.contacts);
    let sources = scene.contacts().iter().enumerate().zip(&written.contacts);
    for ((bound, u), ((i, contact), r)) in places.zip(sources) {
        let mut sums = <[T; D]>::from(contact.offset).map(Dot2::of);
        let columns = contact.jacobian.data.0.iter();
        for ((&v, column), gap) in v.iter().zip(columns).zip(&mut gaps) {
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
        let scaling = scene.scaling(i);
        let times = 1 + operations_after::<D>(scaling.is_some(), problem.model);
        let mut rounded = values.map(|value| value.abs() * T::count(times));
        if let Some(scaling) = scaling {
            let added = u.iter_mut().zip(scaling.compliance_velocity(r));
            for (rounded, (u, added)) in rounded.iter_mut().zip(added) {
                *u += added;
                *rounded += added.abs() * T::count(COMPLIANCE);
            }
        }
        let left = T::count(N + 4) * bound[0].square_root();
        let bounds = scene.scale(i, rounded).map(|size| half * (size + left));
        *bound = squares(&bounds);
    }
    let places = velocities.rows.iter_mut().zip(&mut u.rows);
    for ((bound, u), (row, &r)) in places.zip(scene.rows().iter().zip(&written.rows)) {
        let mut sum = Dot2::of(row.offset);
        for ((&v, &h), gap) in v.iter().zip(row.row.iter()).zip(&mut gaps) {
            if h != T::ZERO {
                sum.add(h, v);
                gap.add(-h, r);
            }
        }
        let value = sum.value();
        if value.is_finite() {
            let added = row.compliance * r;
            *u = value + added;
            let rounded = value.abs() * T::literal(3.0) + added.abs() * T::count(COMPLIANCE);
            let left = T::count(N + 4) * bound.square_root();
            *bound = square(&[half * (rounded + left)]);
        }
    }
    let gaps = gaps.map(Dot2::value);
    if !gaps.iter().all(T::is_finite) {
        return;
    }
    // Here all terms stand in one sum.
    let left = precision::<T>(N + rows(&problem.sets) + 3);
    momentum.replace_gaps(mass, &gaps);
    // Of a sum of two the square is at most twice the sum of their squares.
    let norms = [Some(&momentum.plain), momentum.weighted.as_ref()];
    [rounding.momentum, rounding.weighted] = norms.map(|norms| {
        norms.map_or(T::ZERO, |norms| {
            let (rounded, left) = (half * half * norms.residual(), left * left);
            T::literal(2.0) * (left * left * norms.magnitude + rounded)
        })
    });
}

#[cfg(test)]
mod tests;
