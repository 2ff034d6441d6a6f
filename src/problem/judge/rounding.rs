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
use crate::linalg::vector::square;
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

/// Half an `eps` for each operation that a term takes part in.
fn precision<T: Real>(operations: usize) -> T {
    T::EPSILON * T::count(operations) * T::literal(0.5)
}

/// Of a sum of two the square is at most twice the sum of their squares.
const TWO: f64 = 2.0;

/// Operations that a velocity of compliance takes part in: a product of up to four, a sum, and those on the way to a momentum.
const COMPLIANCE: usize = 8;

/// Operations that a term of a momentum takes part in, at most.
fn longest<T: Real, const D: usize, const C: usize, const R: usize>(
    sets: &Sets<T, D, C, R>,
    velocities: usize,
) -> usize {
    velocities + D * sets.contacts().len() + sets.rows().len() + 3
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
    [scaled, r]: [&Stacked<T, D, C, R>; 2],
    sizes: &Stacked<T, D, C, R>,
    momentum: &Dynamics<T>,
) -> Rounding<T, C, R> {
    let (scene, sets) = (problem.scene, &problem.sets);
    let mut velocities = VelocityNoise {
        contacts: [[T::ZERO; 2]; C],
        rows: [T::ZERO; R],
    };
    // Products and sums, scales, and on the way to a momentum, where parts of a relaxed contact that slides cancel.
    let own = precision::<T>(N + 6);
    let sources = sizes.contacts.iter().zip(&r.contacts).enumerate();
    let sources = sources.take(sets.contacts().len());
    for (bound, (i, (sizes, r))) in velocities.contacts.iter_mut().zip(sources) {
        let mut bounds = sizes.map(|size| own * size);
        if let Some(scaling) = scene.scaling(i) {
            for (bound, added) in bounds.iter_mut().zip(scaling.compliance_velocity(r)) {
                *bound += precision::<T>(COMPLIANCE) * added.abs();
            }
        }
        *bound = squares(&scene.scale(i, bounds));
    }
    let sources = scene.rows().iter().zip(sizes.rows.iter().zip(&r.rows));
    for (bound, (row, (&size, &r))) in velocities.rows.iter_mut().zip(sources) {
        let added = precision::<T>(COMPLIANCE) * (row.compliance * r).abs();
        *bound = square(&[own * size + added]);
    }
    add_gap(problem, scaled, &mut velocities);
    let share = precision::<T>(longest(sets, N));
    let noise = |norms: &Norms<T>| share * share * norms.magnitude;
    Rounding {
        momentum: noise(&momentum.plain),
        weighted: momentum.weighted.as_ref().map_or(T::ZERO, noise),
        velocities,
    }
}

/// Squares of all rows of a contact, and of the normal one.
fn squares<T: Real, const D: usize>(bounds: &[T; D]) -> [T; 2] {
    [square(bounds), square(bounds.get(..1).unwrap_or_default())]
}

/// Computes `u = H v + w` and `M v - M v_free - Hᵀ r` again, with twice the digits, of impulses in scaled rows and in rows that
/// are not; `cheap` are the bounds of [`bound`]. Returns the bounds that are left.
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
    [scaled, r]: [&Stacked<T, D, C, R>; 2],
    (u, momentum): (&mut Stacked<T, D, C, R>, &mut Dynamics<T>),
    cheap: &Rounding<T, C, R>,
) -> Rounding<T, C, R> {
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
    let mut velocities = cheap.velocities;
    let places = velocities.contacts.iter_mut().zip(&mut u.contacts);
    let sources = scene.contacts().iter().enumerate().zip(&r.contacts);
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
        // Once here, and on the way to a momentum; where a relaxed contact slides its parts cancel.
        let times = if problem.model == Model::Coulomb {
            2
        } else {
            5
        };
        let mut rounded = values.map(|value| value.abs() * T::count(times));
        if let Some(scaling) = scene.scaling(i) {
            for (rounded, added) in rounded.iter_mut().zip(scaling.compliance_velocity(r)) {
                *rounded += added.abs() * T::count(COMPLIANCE);
            }
        }
        let left = T::count(N + 4) * bound[0].square_root();
        let bounds = scene.scale(i, rounded).map(|size| half * (size + left));
        *bound = squares(&bounds);
    }
    let places = velocities.rows.iter_mut().zip(&mut u.rows);
    for ((bound, u), (row, &r)) in places.zip(scene.rows().iter().zip(&r.rows)) {
        let mut sum = Dot2::of(row.offset);
        for ((&v, &h), gap) in v.iter().zip(row.row.iter()).zip(&mut gaps) {
            if h != T::ZERO {
                sum.add(h, v);
                gap.add(-h, r);
            }
        }
        let value = sum.value();
        if value.is_finite() {
            *u = value;
            let rounded =
                value.abs() * T::literal(2.0) + (row.compliance * r).abs() * T::count(COMPLIANCE);
            let left = T::count(N + 4) * bound.square_root();
            *bound = square(&[half * (rounded + left)]);
        }
    }
    add_gap(problem, scaled, &mut velocities);
    let gaps = gaps.map(Dot2::value);
    if !gaps.iter().all(T::is_finite) {
        return Rounding {
            velocities,
            ..*cheap
        };
    }
    let left = precision::<T>(longest(&problem.sets, N));
    let left = |cheap: T| left * left * cheap;
    momentum.replace_gaps(mass, &gaps);
    let rounded = |residual: T| half * half * residual;
    let two = T::literal(TWO);
    let weighted = momentum
        .weighted
        .map(|norms| two * (left(cheap.weighted) + rounded(norms.residual())));
    Rounding {
        momentum: two * (left(cheap.momentum) + rounded(momentum.plain.residual())),
        weighted: weighted.unwrap_or(T::ZERO),
        velocities,
    }
}

/// Adds to squares of bounds on velocities by how much a `W` that was given moves more than `H Hᵀ`:
/// `|W_ab - H_a·H_b| <= gap sqrt(W_aa W_bb)`.
#[inline]
fn add_gap<
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize,
    const S: usize,
>(
    problem: &Problem<'_, T, N, D, C, R, S>,
    r: &Stacked<T, D, C, R>,
    velocities: &mut VelocityNoise<T, C, R>,
) {
    let gap = problem.scene.delassus_gap();
    if gap == T::ZERO {
        return;
    }
    let sets = &problem.sets;
    let mut speed = T::ZERO;
    for (set, r) in sets.contacts().iter().zip(&r.contacts) {
        let sum = r.iter().fold(T::ZERO, |sum, r| sum + r.abs());
        speed += gap * set.inverse_mass().square_root() * sum;
    }
    for (set, &r) in sets.rows().iter().zip(&r.rows) {
        speed += gap * set.inverse_mass().square_root() * r.abs();
    }
    let two = T::literal(TWO);
    for (velocity, set) in velocities.contacts.iter_mut().zip(sets.contacts()) {
        let gap = set.inverse_mass() * (speed * speed);
        *velocity = velocity.map(|bound| (bound + gap) * two);
    }
    for (velocity, set) in velocities.rows.iter_mut().zip(sets.rows()) {
        *velocity = (*velocity + set.inverse_mass() * (speed * speed)) * two;
    }
}

#[cfg(test)]
mod tests;
