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
use crate::linalg::dot2::Dot2;
use crate::linalg::sparsity::GROUP;
use crate::linalg::stacked::Stacked;
use crate::problem::Problem;
use crate::problem::judge::dynamics::Dynamics;
use crate::scene::Scaling;
use crate::sets::energy::VelocityNoise;
use crate::{Model, Real};

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

/// Half an `eps` for each operation that a term takes part in, squared.
fn precision<T: Real>(operations: usize) -> T {
    let share = T::EPSILON * T::count(operations) * T::literal(0.5);
    share * share
}

/// Of a sum of two the square is at most twice the sum of their squares.
const TWO: f64 = 2.0;

/// Bounds on the sums of magnitudes, of impulses in scaled rows.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn bound<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    problem: &Problem<'_, T, N, D, C, R>,
    v: &[T; N],
    r: &Stacked<T, D, C, R>,
    momentum: &Dynamics<T>,
) -> Rounding<T, C, R> {
    let (sets, mass) = (&problem.sets, &problem.scene.mass().data.0);
    let unit = momentum.plain.unit;
    // `Σ M_jj`, `Σ M_jj v_j²` and `Σ W_aa r_a²`, with as many units as keep them near 1.
    let [mut trace, mut energy, mut pushed] = [T::ZERO; 3];
    for (j, (column, &v)) in mass.iter().zip(v).enumerate() {
        let mass = column.get(j).copied().unwrap_or(T::ZERO);
        trace += mass;
        energy += unit * mass * v * v;
    }
    let two = T::literal(TWO);
    let mut velocities = VelocityNoise {
        contacts: [[T::ZERO; 2]; C],
        rows: [T::ZERO; R],
    };
    let contacts = problem.scene.supported().enumerate();
    let places = velocities.contacts.iter_mut().zip(contacts);
    let sources = sets.contacts().iter().zip(&r.contacts);
    for ((velocity, (i, (contact, support))), (set, r)) in places.zip(sources) {
        let inertia = set.inverse_mass();
        let offset = problem.scene.scale(i, contact.offset.into());
        // Columns of zeros take part in nothing.
        let columns = (GROUP * support.groups::<N>().count() + N % GROUP).max(1);
        let moved = energy / unit * T::count(columns);
        let mut bound = two * precision(columns + 4) * (square(&offset) + inertia * moved);
        let scaling = problem.scene.scaling(i);
        if scaling.is_some_and(Scaling::is_compliant) {
            bound += two * precision(8) * square(&r.map(|r| inertia * r));
        }
        *velocity = [bound; 2];
        pushed += inertia * square(&r.map(|r| unit * r));
    }
    let rows = problem.scene.rows().iter().zip(sets.rows());
    for (velocity, ((row, set), &r)) in velocities.rows.iter_mut().zip(rows.zip(&r.rows)) {
        if set.alpha <= T::ZERO {
            continue;
        }
        let moved = energy / unit * T::count(N) / set.alpha;
        *velocity = two * precision(N + 4) * (row.offset * row.offset + moved);
        if row.compliance > T::ZERO {
            *velocity += two * precision(8) * square(&[r / set.alpha]);
        }
        pushed += square(&[unit * r]) / set.alpha;
    }
    let terms = D * sets.contacts().len() + sets.rows().len();
    let longest = N.max(terms);
    let noise = |free, sums| (two + T::ONE) * precision(longest + 2) * (free + sums);
    add_gap(problem, r, &mut velocities);
    let energy = energy * T::count(N);
    let terms = T::count(terms);
    let least = (pushed * trace).min(momentum.pushed * unit * unit);
    let sums = energy * (unit * trace) + least * terms;
    let weighted = momentum.weighted.map(|weighted| {
        // `|M_kj|² <= M_kk M_jj`: what is weighted has a trace of `N`.
        let ratio = weighted.unit / unit;
        let sums = energy * ratio * weighted.unit + pushed * ratio * ratio * terms;
        noise(weighted.free, sums * T::count(N))
    });
    Rounding {
        momentum: noise(momentum.plain.free, sums),
        weighted: weighted.unwrap_or(T::ZERO),
        velocities,
    }
}

/// Computes `u = H v + w` and `M v - M v_free - Hᵀ r` again, with twice the digits, of impulses in scaled rows and in rows that
/// are not; `cheap` are the bounds of [`bound`]. Returns the bounds that are left.
#[inline(never)]
pub(crate) fn refine<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    problem: &Problem<'_, T, N, D, C, R>,
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
            // A product of up to four, and a sum.
            for (rounded, added) in rounded.iter_mut().zip(scaling.compliance_velocity(r)) {
                *rounded += added.abs() * T::literal(5.0);
            }
        }
        let left = T::count(N + 4) * bound[0].square_root();
        let bounds = scene.scale(i, rounded).map(|size| half * (size + left));
        *bound = [square(&bounds), square(bounds.get(..1).unwrap_or_default())];
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
                value.abs() * T::literal(TWO) + (row.compliance * r).abs() * T::literal(5.0);
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
    let terms = D * problem.sets.contacts().len() + problem.sets.rows().len();
    let left = half * T::count(N + terms + 3);
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
fn add_gap<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    problem: &Problem<'_, T, N, D, C, R>,
    r: &Stacked<T, D, C, R>,
    velocities: &mut VelocityNoise<T, C, R>,
) {
    let gap = problem.scene.delassus_gap();
    if gap == T::ZERO {
        return;
    }
    let sets = &problem.sets;
    let row_inertia = |alpha: T| {
        if alpha > T::ZERO {
            T::ONE / alpha
        } else {
            T::ZERO
        }
    };
    let mut speed = T::ZERO;
    for (set, r) in sets.contacts().iter().zip(&r.contacts) {
        let sum = r.iter().fold(T::ZERO, |sum, r| sum + r.abs());
        speed += gap * set.inverse_mass().square_root() * sum;
    }
    for (set, &r) in sets.rows().iter().zip(&r.rows) {
        speed += gap * row_inertia(set.alpha).square_root() * r.abs();
    }
    let two = T::literal(TWO);
    for (velocity, set) in velocities.contacts.iter_mut().zip(sets.contacts()) {
        let gap = set.inverse_mass() * (speed * speed);
        *velocity = velocity.map(|bound| (bound + gap) * two);
    }
    for (velocity, set) in velocities.rows.iter_mut().zip(sets.rows()) {
        *velocity = (*velocity + row_inertia(set.alpha) * (speed * speed)) * two;
    }
}

#[cfg(test)]
mod tests;
