//! Proof that a scene has no solution: Farkas' lemma on the normal velocities.
//!
//! Coulomb's law asks for `H_N v + w_N >= 0`. No velocity does that if and only if some `d >= 0`
//! has `H_Nᵀ d = 0` and `w_N · d < 0` (two walls that close on a body).
//!
//! The search minimises `dᵀ W_NN d + (g·d + 1)²` over `d >= 0` with the active-set method of Lawson and
//! Hanson (1974). Inverse iteration then brings the minimiser to the null space of `W_NN`. Two checks
//! follow. By `|w_N · d| <= |v|_M |H_Nᵀ d|_{M⁻¹}` feasible velocities would have to exceed the offsets
//! 1e9-fold (f32: 17,000). And `H_Nᵀ d` is zero in each entry up to rounding, so that it is not a heavy
//! body that makes it small.

use crate::cone::split;
use crate::laws::Laws;
use crate::linalg::cholesky::{dot, factorise};
use crate::linalg::hints::{opaque, opaque_mut, rolled};
use crate::linalg::substitution::solve;
use crate::problem::Problem;
use crate::{Contact, Real};
use heapless::Vec;

/// Is a proof conceivable? Not if standing still satisfies all contacts.
pub(crate) fn is_conceivable<T: Real, const N: usize, const D: usize>(
    contacts: &[Contact<T, N, D>],
) -> bool {
    let mut offsets = contacts.iter().map(|contact| split(&contact.offset).0);
    offsets.any(|offset| offset < T::ZERO)
}

/// Looks for a `d` that proves the scene infeasible; `None` if there is none to be found.
#[inline(never)]
pub(crate) fn certificate<T: Real, const N: usize, const D: usize, const C: usize, L: Laws>(
    problem: &Problem<'_, T, N, D, C, L>,
) -> Option<[T; C]> {
    let contacts = problem.scene.contacts();
    let mut offset = [T::ZERO; C];
    for (offset, contact) in offset.iter_mut().zip(contacts) {
        rolled();
        *offset = contact.offset.iter().next().copied()?;
    }
    let mut gram = Gram {
        normal: [[T::ZERO; C]; C],
        offset,
    };
    // Beyond the contacts in use the factor has what an earlier scene left.
    let rows = problem.factor.delassus().iter().take(contacts.len());
    for (row, source) in gram.normal.iter_mut().zip(rows) {
        rolled();
        let source = source.first()?.iter().take(contacts.len());
        for (entry, block) in row.iter_mut().zip(source) {
            rolled();
            *entry = *block.first()?;
        }
    }
    let scale = gram.normalise();
    let fastest = gram
        .offset
        .iter()
        .fold(T::ZERO, |size, g| size.max(g.abs()));
    let mut d = gram.minimise(fastest)?;
    let support = gram.purify(&mut d)?;
    // What rounding left of W_NN d, taken away twice.
    for _ in 0..2 {
        let (mut left, _) = problem.factor.normal_products(&product(&d, &scale));
        left = product(&left, &scale);
        let correction = gram.solve(&support, T::ZERO, &gram.offset, &left)?;
        for (d, correction) in d.iter_mut().zip(correction) {
            rolled();
            *d = (*d - correction).max(T::ZERO);
        }
    }
    let d = product(&d, &scale);
    let approach = -dot(&d, &offset);
    let (_, leak) = problem.factor.normal_products(&d);
    let proportion = T::literal(1e9).min(T::literal(2e-3) / T::EPSILON);
    let is_strong = approach > T::ZERO && leak * proportion * fastest <= approach;
    (is_strong && cancels(contacts, &d)).then_some(d)
}

/// Is `H_Nᵀ d` zero in each entry, up to rounding or a billionth of the sum of `d` times the largest entry?
#[inline(never)]
fn cancels<T: Real, const N: usize, const D: usize, const C: usize>(
    contacts: &[Contact<T, N, D>],
    d: &[T; C],
) -> bool {
    let [mut sums, mut sizes] = [[T::ZERO; N]; 2];
    let mut total = T::ZERO;
    for (contact, &d) in contacts.iter().zip(d) {
        rolled();
        total += d;
        let columns = opaque(&contact.jacobian.data.0).iter();
        for (column, (sum, size)) in columns.zip(sums.iter_mut().zip(&mut sizes)) {
            rolled();
            let entry = column.first().copied().unwrap_or(T::ZERO);
            *sum += entry * d;
            *size = size.max(entry.abs());
        }
    }
    let share = T::literal(1e-9).max(T::literal(8.0) * T::EPSILON) * total;
    let mut entries = opaque(&sums).iter().zip(&sizes);
    entries.all(|(sum, &size)| sum.abs() <= share * size)
}

/// Entry by entry.
#[inline(never)]
fn product<T: Real, const C: usize>(x: &[T; C], y: &[T; C]) -> [T; C] {
    let mut product = *x;
    for (product, &y) in product.iter_mut().zip(y) {
        rolled();
        *product *= y;
    }
    product
}

/// The quadratic form of the search, over contacts scaled to unit effective mass.
struct Gram<T, const C: usize> {
    /// `W_NN` with a unit diagonal.
    normal: [[T; C]; C],
    /// `g`: `w_N` scaled likewise (square root of an energy).
    offset: [T; C],
}

impl<T: Real, const C: usize> Gram<T, C> {
    /// Scales to a unit diagonal; a contact that nothing moves is scaled by 1.
    #[inline(never)]
    fn normalise(&mut self) -> [T; C] {
        let mut scale = [T::ONE; C];
        for (i, (row, scale)) in self.normal.iter().zip(&mut scale).enumerate() {
            rolled();
            let inertia = row.get(i).copied().unwrap_or(T::ZERO);
            if inertia > T::ZERO {
                *scale = T::ONE / inertia.square_root();
            }
        }
        for ((row, offset), factor) in self.normal.iter_mut().zip(&mut self.offset).zip(scale) {
            rolled();
            *offset *= factor;
            for (entry, scale) in row.iter_mut().zip(scale) {
                rolled();
                *entry *= factor * scale;
            }
        }
        scale
    }

    /// Minimises `dᵀ W_NN d + (g·d / size + 1)²` over `d >= 0`; `None` if that stays near 1.
    #[inline(never)]
    fn minimise(&self, size: T) -> Option<[T; C]> {
        let mut d = [T::ZERO; C];
        let mut support = Vec::<usize, C>::new();
        let mut g = self.offset;
        for g in &mut g {
            *g /= size;
        }
        for _ in 0..4 * C {
            // The contact that would reduce the objective most, if any does.
            let rounding = d.iter().fold(T::ONE, |sum, &d| sum + d) * T::EPSILON;
            let approach = T::ONE + dot(&g, &d);
            let mut entering = (rounding * T::literal(64.0), None);
            for (i, (row, &g)) in self.normal.iter().zip(&g).enumerate() {
                rolled();
                let descent = -(dot(row, &d) + g * approach);
                if descent > entering.0 && !support.contains(&i) {
                    entering = (descent, Some(i));
                }
            }
            let Some(index) = entering.1 else { break };
            let _ = support.push(index);
            // Back inside as long as the minimiser on the support has negative entries.
            while let Some(minimiser) = self.solve(&support, T::ONE, &g, &g) {
                let mut length = T::ONE;
                for (&d, &target) in d.iter().zip(&minimiser) {
                    rolled();
                    // `minimiser` is that of `-g`.
                    if -target <= T::ZERO && d > T::ZERO {
                        length = length.min(d / (d + target));
                    }
                }
                for (d, target) in d.iter_mut().zip(minimiser) {
                    rolled();
                    *d += (-target - *d) * length;
                }
                let before = support.len();
                support.retain(|&i| d.get(i).is_some_and(|&d| d > rounding));
                for (i, d) in d.iter_mut().enumerate() {
                    rolled();
                    if !support.contains(&i) {
                        *d = T::ZERO;
                    }
                }
                if support.len() == before {
                    break;
                }
            }
        }
        (T::ONE + dot(&g, &d) <= T::literal(0.999)).then_some(d)
    }

    /// Inverse iteration on the support of `d`, which it returns: what is not in the null space
    /// dies out.
    #[inline(never)]
    fn purify(&self, d: &mut [T; C]) -> Option<Vec<usize, C>> {
        let mut support = Vec::<usize, C>::new();
        for (i, _) in d.iter().enumerate().filter(|&(_, &d)| d > T::ZERO) {
            rolled();
            let _ = support.push(i);
        }
        for _ in 0..3 {
            let largest = d.iter().fold(T::ZERO, |largest, d| largest.max(d.abs()));
            for d in d.iter_mut() {
                rolled();
                *d /= largest;
            }
            *d = self.solve(&support, T::ZERO, &self.offset, d)?;
        }
        let largest = d.iter().fold(T::ZERO, |largest, d| largest.max(d.abs()));
        for d in d.iter_mut() {
            rolled();
            *d /= largest;
            if d.abs() < T::EPSILON * T::literal(64.0) {
                *d = T::ZERO;
            }
        }
        d.iter().all(|&d| d >= T::ZERO).then_some(support)
    }

    /// Solves `(W_NN + weight g gᵀ + δI) x = b` on a support, zero elsewhere.
    #[inline(never)]
    fn solve(&self, support: &[usize], weight: T, g: &[T; C], b: &[T; C]) -> Option<[T; C]> {
        let ridge = T::EPSILON * T::count(4 * support.len());
        let mut matrix = [[T::ZERO; C]; C];
        let mut x = [T::ZERO; C];
        for (k, (row, x)) in opaque_mut(&mut matrix).iter_mut().zip(&mut x).enumerate() {
            rolled();
            let Some(&i) = support.get(k) else {
                // A unit row, of an unknown that there is not.
                *row.get_mut(k)? = T::ONE;
                continue;
            };
            *x = *b.get(i)?;
            for (entry, &j) in row.iter_mut().zip(support) {
                rolled();
                *entry = *self.normal.get(i)?.get(j)? + weight * *g.get(i)? * *g.get(j)?;
                if i == j {
                    *entry += ridge;
                }
            }
        }
        let mut factor = [[T::ZERO; C]; C];
        factorise(&matrix, T::ZERO, &mut factor, &mut [0; C]).ok()?;
        solve(&factor, &mut x);
        let mut solution = [T::ZERO; C];
        for (&i, &x) in opaque(support).iter().zip(&x) {
            rolled();
            *solution.get_mut(i)? = x;
        }
        Some(solution)
    }
}
