//! Proof that a scene has no solution: Farkas' lemma over all that is rigid.
//!
//! Coulomb's law asks for `H_N v + w_N >= 0`, limits for as much of their rows, equalities for zero. No velocity does that if
//! and only if some `d`, not negative but on equalities, has `H_Nᵀ d + Jᵀ d = 0` and `w_N · d + offset · d < 0` (two walls
//! that close on a body). Boxes, tangents and whatever gives way ask for nothing.
//!
//! Two checks follow the search. By `|w · d| <= |v|_M |Hᵀ d|_{M⁻¹}` feasible velocities would have to exceed the offsets
//! 1e9-fold (f32: 4,200). And `Hᵀ d` is zero in each entry up to rounding, so that it is not a heavy body that makes it
//! small.
//!
//! A proof has `K` rows a slot: 1 where there are contacts alone, `D` where there are joint rows.

use crate::laws::Laws;
use crate::linalg::blocks::{ContactMatrix, ContactVector};
use crate::linalg::cholesky::dot;
use crate::linalg::hints::{opaque, rolled};
use crate::problem::Problem;
use crate::problem::proof_search::{Demand, Search};
use crate::{Real, Scene};

/// What each row of a slot asks for.
fn demands<T: Real, const N: usize, const D: usize, const C: usize, L: Laws, const K: usize>(
    scene: &Scene<T, N, D, C, L>,
    index: usize,
) -> [Demand; K] {
    let mut demands = [Demand::Nothing; K];
    let Some(slot) = scene.slot(index) else {
        // A contact that is rigid.
        if let Some(normal) = demands.first_mut() {
            *normal = Demand::NotNegative;
        }
        return demands;
    };
    let rigid = slot.compliance.map(|compliance| compliance == T::ZERO);
    for (k, (demand, rigid)) in demands.iter_mut().zip(rigid).enumerate() {
        let Some(rows) = &slot.rows else {
            if k == 0 && rigid {
                *demand = Demand::NotNegative;
            }
            continue;
        };
        let bounds = rows.bounds.get(k).filter(|_| rigid && k < rows.count);
        *demand = match bounds {
            Some([lower, upper]) if !upper.is_finite() && lower.is_finite() => Demand::NotNegative,
            Some([lower, _]) if !lower.is_finite() => Demand::Zero,
            _ => Demand::Nothing,
        };
    }
    demands
}

/// Is there anything to be proved? Not if standing still meets all demands.
pub(crate) fn is_conceivable<T: Real, const N: usize, const D: usize, const C: usize, L: Laws>(
    scene: &Scene<T, N, D, C, L>,
) -> bool {
    let slots = scene.contacts().iter().enumerate();
    let mut rows = slots.flat_map(|(i, contact)| {
        let offsets: [T; D] = contact.offset.into();
        demands::<T, N, D, C, L, D>(scene, i)
            .into_iter()
            .zip(offsets)
    });
    rows.any(|(demand, offset)| match demand {
        Demand::Nothing => false,
        Demand::NotNegative => offset < T::ZERO,
        Demand::Zero => offset != T::ZERO,
    })
}

/// Looks for a `d` that proves the scene infeasible, in the rows as they were given; `None` if there is none to be found.
#[inline(never)]
pub(crate) fn certificate<
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    L: Laws,
    const K: usize,
>(
    problem: &Problem<'_, T, N, D, C, L>,
) -> Option<ContactVector<T, K, C>> {
    let (scene, factor) = (problem.scene, problem.factor);
    let mut search = Search {
        demands: [[Demand::Nothing; K]; C],
        gram: [[[[T::ZERO; K]; C]; K]; C],
        offset: [[T::ZERO; K]; C],
    };
    let mut scales = [[T::ZERO; K]; C];
    let mass = scene.reference_mass();
    for (i, contact) in scene.contacts().iter().enumerate() {
        rolled();
        let offset: [T; D] = factor.scaled(i, contact.offset).into();
        let demands: [Demand; K] = demands(scene, i);
        for (k, (&demand, &offset)) in demands.iter().zip(&offset).enumerate() {
            let inertia = *factor.delassus().get(i)?.get(k)?.get(i)?.get(k)?;
            if demand == Demand::Nothing || inertia <= T::ZERO {
                let unmet = offset < T::ZERO || demand == Demand::Zero && offset > T::ZERO;
                if demand != Demand::Nothing && unmet {
                    // Nothing moves it: it is the proof.
                    let mut alone = [[T::ZERO; K]; C];
                    *alone.get_mut(i)?.get_mut(k)? =
                        if offset < T::ZERO { T::ONE } else { -T::ONE };
                    return Some(alone);
                }
                continue;
            }
            let scale = T::ONE / (inertia * mass).square_root();
            *scales.get_mut(i)?.get_mut(k)? = scale;
            *search.demands.get_mut(i)?.get_mut(k)? = demand;
            *search.offset.get_mut(i)?.get_mut(k)? = offset * scale;
        }
    }
    normalised(factor.delassus(), mass, &scales, &mut search.gram);
    let fastest = search.offset.as_flattened().iter();
    let fastest = fastest.fold(T::ZERO, |fastest, g| {
        rolled();
        fastest.max(g.abs())
    });
    let mut d = search.minimise(fastest)?;
    search.purify(&mut d)?;
    // What rounding left of W d, taken away twice.
    for _ in 0..2 {
        let (left, _) = factor.row_products(&product(&d, &scales), mass);
        search.correct(&mut d, &product(&left, &scales))?;
    }
    let approach = -dot(d.as_flattened(), search.offset.as_flattened());
    let mut proof = product(&d, &scales);
    let (_, mut leak) = factor.row_products(&proof, mass);
    for d in d.as_flattened() {
        rolled();
        leak += d.abs() * T::literal(0.25) * T::EPSILON; // what rounding may hide
    }
    let proportion = T::literal(1e9).min(T::literal(5e-4) / T::EPSILON);
    let is_strong = approach > T::ZERO && leak * proportion * fastest <= approach;
    for (i, d) in proof.iter_mut().enumerate() {
        rolled();
        for (d, &scale) in d.iter_mut().zip(factor.scales(i).into_iter().flatten()) {
            *d *= scale;
        }
    }
    (is_strong && cancels(scene, &proof, &d)).then_some(proof)
}

/// The Gram matrix of rows, times the reference mass, with a unit diagonal.
fn normalised<T: Real, const D: usize, const C: usize, const K: usize>(
    delassus: &ContactMatrix<T, D, C>,
    mass: T,
    scales: &ContactVector<T, K, C>,
    gram: &mut ContactMatrix<T, K, C>,
) {
    let rows = delassus.iter().zip(scales).zip(gram);
    let rows = rows.flat_map(|((sources, scales), rows)| sources.iter().zip(scales).zip(rows));
    for ((source, &factor), row) in rows {
        rolled();
        for ((entries, scales), source) in row.iter_mut().zip(scales).zip(source) {
            rolled();
            for ((entry, &scale), &source) in entries.iter_mut().zip(scales).zip(source) {
                // Beyond the slots in use the factor has what an earlier scene left.
                if factor > T::ZERO && scale > T::ZERO {
                    *entry = factor * scale * (source * mass);
                }
            }
        }
    }
}

/// Is `H_Nᵀ d + Jᵀ d` zero, but for a billionth of what one row would be, or for rounding? Rows are weighed by their effective
/// mass, as `weights` are `d` of.
#[inline(never)]
fn cancels<T: Real, const N: usize, const D: usize, const C: usize, L: Laws, const K: usize>(
    scene: &Scene<T, N, D, C, L>,
    d: &ContactVector<T, K, C>,
    weights: &ContactVector<T, K, C>,
) -> bool {
    let [mut sums, mut sizes] = [[T::ZERO; N]; 2];
    let mut total = T::ZERO;
    for ((contact, d), weights) in scene.contacts().iter().zip(d).zip(weights) {
        rolled();
        total += weights
            .iter()
            .fold(T::ZERO, |sum, weight| sum + weight.abs());
        let columns = opaque(&contact.jacobian.data.0).iter();
        for (column, (sum, size)) in columns.zip(sums.iter_mut().zip(&mut sizes)) {
            rolled();
            for ((&entry, &d), &weight) in column.iter().zip(d).zip(weights) {
                *sum += entry * d;
                if weight != T::ZERO {
                    *size = size.max((entry * d / weight).abs());
                }
            }
        }
    }
    let share = T::literal(1e-9).max(T::literal(8.0) * T::EPSILON) * total;
    let (masses, reference) = (
        scene.mass().data.0.iter().enumerate(),
        scene.reference_mass(),
    );
    let mut entries = opaque(&sums).iter().zip(&sizes).zip(masses);
    entries.all(|((sum, &size), (j, column))| {
        rolled();
        // An entry that is rounding beside the mass is none.
        let mass = column.get(j).copied().unwrap_or(T::ZERO) / reference;
        sum.abs() <= share * (size + mass.square_root() * T::literal(1e-6))
    })
}

/// Entry by entry.
#[inline(never)]
fn product<T: Real, const K: usize, const C: usize>(
    x: &ContactVector<T, K, C>,
    y: &ContactVector<T, K, C>,
) -> ContactVector<T, K, C> {
    let mut product = *x;
    let entries = product.as_flattened_mut().iter_mut();
    for (entry, &y) in entries.zip(y.as_flattened()) {
        rolled();
        *entry *= y;
    }
    product
}
