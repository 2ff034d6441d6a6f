//! Proof that a scene with joint rows has no solution: Farkas' lemma over all that is rigid.
//!
//! Contact normals and limits ask for `s >= 0`, equalities for `s = 0`. No velocity does that if and only if some `d`, not
//! negative on the former, has `H_Nᵀ d + Jᵀ d = 0` and `w_N · d + offset · d < 0`. Boxes, tangents and whatever gives way ask
//! for nothing. The search is that of [`super::infeasibility`], with equalities of either sign.

use crate::cone::split;
use crate::laws::{Laws, Room};
use crate::linalg::blocks::{ContactMatrix, ContactVector};
use crate::linalg::cholesky::dot;
use crate::linalg::hints::rolled;
use crate::problem::Problem;
use crate::problem::row_search::Search;
use crate::{Real, Scene};

/// What a row asks of its velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Demand {
    Nothing,
    NotNegative,
    Zero,
}

/// What each row of a slot asks for.
fn demands<T: Real, const N: usize, const D: usize, const C: usize, L: Laws>(
    scene: &Scene<T, N, D, C, L>,
    index: usize,
) -> [Demand; D] {
    let mut demands = [Demand::Nothing; D];
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
        demands(scene, i).into_iter().zip(offsets)
    });
    rows.any(|(demand, offset)| match demand {
        Demand::Nothing => false,
        Demand::NotNegative => offset < T::ZERO,
        Demand::Zero => offset != T::ZERO,
    })
}

/// Looks for a `d` that proves the scene infeasible, in the rows as they were given; `None` if there is none to be found.
#[inline(never)]
pub(crate) fn certificate<T: Real, const N: usize, const D: usize, const C: usize, L: Laws>(
    problem: &Problem<'_, T, N, D, C, L>,
) -> Option<ContactVector<T, D, C>> {
    let (scene, factor) = (problem.scene, problem.factor);
    let mut search = Search {
        demands: [[Demand::Nothing; D]; C],
        gram: [[[[T::ZERO; D]; C]; D]; C],
        offset: [[T::ZERO; D]; C],
    };
    let mut scales = [[T::ZERO; D]; C];
    for (i, contact) in scene.contacts().iter().enumerate() {
        let offset: [T; D] = factor.scaled(i, contact.offset).into();
        let demands = demands(scene, i);
        for (k, (&demand, &offset)) in demands.iter().zip(&offset).enumerate() {
            let inertia = *factor.delassus().get(i)?.get(k)?.get(i)?.get(k)?;
            if demand == Demand::Nothing || inertia <= T::ZERO {
                let unmet = offset < T::ZERO || demand == Demand::Zero && offset > T::ZERO;
                if demand != Demand::Nothing && unmet {
                    // Nothing moves it: it is the proof.
                    let mut alone = [[T::ZERO; D]; C];
                    *alone.get_mut(i)?.get_mut(k)? =
                        if offset < T::ZERO { T::ONE } else { -T::ONE };
                    return Some(alone);
                }
                continue;
            }
            let scale = T::ONE / inertia.square_root();
            *scales.get_mut(i)?.get_mut(k)? = scale;
            *search.demands.get_mut(i)?.get_mut(k)? = demand;
            *search.offset.get_mut(i)?.get_mut(k)? = offset * scale;
        }
    }
    normalised(factor.delassus(), &scales, &mut search.gram);
    let fastest = search.offset.as_flattened().iter();
    let fastest = fastest.fold(T::ZERO, |fastest, g| fastest.max(g.abs()));
    let mut d = search.minimise(fastest)?;
    search.purify(&mut d)?;
    // What rounding left of W d, taken away twice.
    for _ in 0..2 {
        let (left, _) = factor.row_products(&product(&d, &scales));
        search.correct(&mut d, &product(&left, &scales))?;
    }
    let approach = -dot(d.as_flattened(), search.offset.as_flattened());
    let impulse = product(&d, &scales);
    let (_, leak) = factor.row_products(&impulse);
    let proportion = T::literal(1e9).min(T::literal(2e-3) / T::EPSILON);
    let is_strong = approach > T::ZERO && leak * proportion * fastest <= approach;
    let mut proof = impulse;
    for (i, d) in proof.iter_mut().enumerate() {
        *d = factor.scaled(i, (*d).into()).into();
    }
    (is_strong && cancels(scene, &proof, &d)).then_some(proof)
}

/// The Gram matrix of rows scaled to unit effective mass.
fn normalised<T: Real, const D: usize, const C: usize>(
    delassus: &ContactMatrix<T, D, C>,
    scales: &ContactVector<T, D, C>,
    gram: &mut ContactMatrix<T, D, C>,
) {
    let columns = scales.as_flattened();
    let sources = delassus.as_flattened().iter().zip(columns);
    for (row, (source, &factor)) in gram.as_flattened_mut().iter_mut().zip(sources) {
        rolled();
        let entries = row.as_flattened_mut().iter_mut().zip(columns);
        for ((entry, &scale), &source) in entries.zip(source.as_flattened()) {
            // Beyond the slots in use the factor has what an earlier scene left.
            if factor > T::ZERO && scale > T::ZERO {
                *entry = factor * scale * source;
            }
        }
    }
}

/// Is `H_Nᵀ d + Jᵀ d` zero, but for a billionth of what one row would be, or for rounding? Rows are weighed by their effective
/// mass, as `weights` are `d` of.
#[inline(never)]
fn cancels<T: Real, const N: usize, const D: usize, const C: usize, L: Laws>(
    scene: &Scene<T, N, D, C, L>,
    d: &ContactVector<T, D, C>,
    weights: &ContactVector<T, D, C>,
) -> bool {
    let [mut sums, mut sizes] = [[T::ZERO; N]; 2];
    let mut total = T::ZERO;
    for ((contact, d), weights) in scene.contacts().iter().zip(d).zip(weights) {
        rolled();
        total += weights
            .iter()
            .fold(T::ZERO, |sum, weight| sum + weight.abs());
        for (column, (sum, size)) in contact
            .jacobian
            .data
            .0
            .iter()
            .zip(sums.iter_mut().zip(&mut sizes))
        {
            for ((&entry, &d), &weight) in column.iter().zip(d).zip(weights) {
                *sum += entry * d;
                if weight != T::ZERO {
                    *size = size.max((entry * d / weight).abs());
                }
            }
        }
    }
    let share = T::literal(1e-9).max(T::literal(8.0) * T::EPSILON) * total;
    let masses = scene.mass().data.0.iter().enumerate();
    let mut entries = sums.iter().zip(&sizes).zip(masses);
    entries.all(|((sum, &size), (j, column))| {
        // An entry that is rounding beside the mass is none.
        let mass = column.get(j).copied().unwrap_or(T::ZERO);
        sum.abs() <= share * (size + mass.square_root() * T::literal(1e-6))
    })
}

/// Entry by entry.
fn product<T: Real, const D: usize, const C: usize>(
    x: &ContactVector<T, D, C>,
    y: &ContactVector<T, D, C>,
) -> ContactVector<T, D, C> {
    let mut product = *x;
    let entries = product.as_flattened_mut().iter_mut();
    for (entry, &y) in entries.zip(y.as_flattened()) {
        *entry *= y;
    }
    product
}

impl<T: Real, const N: usize, const D: usize, const C: usize, L: Laws> Problem<'_, T, N, D, C, L> {
    /// The proof's entry of a slot's normal.
    pub(crate) fn normal_of(&self, slot: usize, d: &[T; D]) -> T {
        match self.laws().get(slot).and_then(|law| law.rows.get()) {
            Some(_) => T::ZERO,
            None => split(&(*d).into()).0,
        }
    }
}
