//! The search for a proof that a scene has no solution, see [`super::infeasibility`].
//!
//! It minimises `dᵀ W d + (g·d + 1)²` over the `d` that demands allow with the active-set method of Lawson and Hanson (1974).
//! Inverse iteration then brings the minimiser to the null space of `W`.

use crate::Real;
use crate::linalg::blocks::{ContactMatrix, ContactVector};
use crate::linalg::cholesky::dot;
use crate::linalg::hints::rolled;

/// What a row asks of its velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Demand {
    Nothing,
    NotNegative,
    Zero,
}

/// The quadratic form of the search, over the first `K` rows of each slot, scaled to unit effective mass.
pub(super) struct Search<T, const K: usize, const C: usize> {
    pub(super) demands: [[Demand; K]; C],
    /// `W` with a unit diagonal, of the rows that ask for anything.
    pub(super) gram: ContactMatrix<T, K, C>,
    /// `g`: offsets scaled likewise.
    pub(super) offset: ContactVector<T, K, C>,
}

/// Rows that are not zero in `d`.
type Support<const K: usize, const C: usize> = [[bool; K]; C];

impl<T: Real, const K: usize, const C: usize> Search<T, K, C> {
    fn row(&self, i: usize) -> Option<&[T]> {
        Some(self.gram.as_flattened().get(i)?.as_flattened())
    }

    /// Minimises `dᵀ W d + (g·d / size + 1)²` over the `d` that demands allow; `None` if that stays near 1.
    #[inline(never)]
    pub(super) fn minimise(&self, size: T) -> Option<ContactVector<T, K, C>> {
        let mut d = [[T::ZERO; K]; C];
        let mut support = [[false; K]; C];
        let mut g = self.offset;
        for g in g.as_flattened_mut() {
            rolled();
            *g /= size;
        }
        for _ in 0..4 * C * K {
            rolled();
            let entries = d.as_flattened();
            let rounding = entries.iter().fold(T::ONE, |sum, d| sum + d.abs()) * T::EPSILON;
            let approach = T::ONE + dot(g.as_flattened(), entries);
            let mut entering = (rounding * T::literal(64.0), None);
            let rows = self.demands.as_flattened().iter().zip(g.as_flattened());
            for (i, (&demand, &g)) in rows.enumerate() {
                rolled();
                let slope = -(dot(self.row(i)?, entries) + g * approach);
                let descent = match demand {
                    Demand::Nothing => T::ZERO,
                    Demand::NotNegative => slope,
                    Demand::Zero => slope.abs(),
                };
                if descent > entering.0 && !*support.as_flattened().get(i)? {
                    entering = (descent, Some(i));
                }
            }
            let Some(index) = entering.1 else { break };
            *support.as_flattened_mut().get_mut(index)? = true;
            self.descend(&mut d, &mut support, &g, rounding);
        }
        (T::ONE + dot(g.as_flattened(), d.as_flattened()) <= T::literal(0.999)).then_some(d)
    }

    /// Goes to the minimiser on the support, and out of it what becomes negative and may not.
    fn descend(
        &self,
        d: &mut ContactVector<T, K, C>,
        support: &mut Support<K, C>,
        g: &ContactVector<T, K, C>,
        rounding: T,
    ) {
        while let Some(minimiser) = self.solve(support, T::ONE, g, g) {
            rolled();
            let mut length = T::ONE;
            let rows = self.demands.as_flattened().iter();
            let pairs = d.as_flattened().iter().zip(minimiser.as_flattened());
            for (demand, (&d, &target)) in rows.zip(pairs) {
                rolled();
                // `minimiser` is that of `-g`.
                let leaves = *demand == Demand::NotNegative && -target <= T::ZERO && d > T::ZERO;
                if leaves {
                    length = length.min(d / (d + target));
                }
            }
            let mut left = false;
            let rows = self.demands.as_flattened().iter();
            let rows = rows.zip(support.as_flattened_mut());
            let pairs = d
                .as_flattened_mut()
                .iter_mut()
                .zip(minimiser.as_flattened());
            for ((demand, used), (d, &target)) in rows.zip(pairs) {
                rolled();
                *d += (-target - *d) * length;
                if *used && *demand == Demand::NotNegative && *d <= rounding {
                    (*used, left) = (false, true);
                }
                if !*used {
                    *d = T::ZERO;
                }
            }
            if !left {
                break;
            }
        }
    }

    /// Inverse iteration on the support of `d`: what is not in the null space dies out.
    #[inline(never)]
    pub(super) fn purify(&self, d: &mut ContactVector<T, K, C>) -> Option<()> {
        let support = support(d);
        for _ in 0..3 {
            normalise(d);
            *d = self.solve(&support, T::ZERO, &self.offset, d)?;
        }
        normalise(d);
        for d in d.as_flattened_mut() {
            rolled();
            if d.abs() < T::EPSILON * T::literal(64.0) {
                *d = T::ZERO;
            }
        }
        let mut rows = d.as_flattened().iter().zip(self.demands.as_flattened());
        let allowed = |(&d, demand): (&T, &Demand)| *demand == Demand::Zero || d >= T::ZERO;
        rows.all(allowed).then_some(())
    }

    /// Takes away what gives this product with `W`.
    pub(super) fn correct(
        &self,
        d: &mut ContactVector<T, K, C>,
        left: &ContactVector<T, K, C>,
    ) -> Option<()> {
        let correction = self.solve(&support(d), T::ZERO, &self.offset, left)?;
        let rows = self.demands.as_flattened().iter();
        let entries = d.as_flattened_mut().iter_mut().zip(rows);
        for ((d, demand), &correction) in entries.zip(correction.as_flattened()) {
            rolled();
            *d -= correction;
            if *demand != Demand::Zero {
                *d = (*d).max(T::ZERO);
            }
        }
        Some(())
    }

    /// Solves `(W + weight g gᵀ + δI) x = b` on a support by `L D Lᵀ`, zero elsewhere.
    #[inline(never)]
    fn solve(
        &self,
        support: &Support<K, C>,
        weight: T,
        g: &ContactVector<T, K, C>,
        b: &ContactVector<T, K, C>,
    ) -> Option<ContactVector<T, K, C>> {
        let (support, g) = (support.as_flattened(), g.as_flattened());
        let count = support.iter().filter(|&&used| used).count();
        let ridge = T::EPSILON * T::count(4 * count);
        let mut factor = [[[[T::ZERO; K]; C]; K]; C];
        let rows = factor.as_flattened_mut();
        let mut solution = *b;
        let x = solution.as_flattened_mut();
        for i in 0..support.len() {
            rolled();
            if !*support.get(i)? {
                *x.get_mut(i)? = T::ZERO;
                continue;
            }
            let (done, rest) = rows.split_at_mut_checked(i)?;
            let row = rest.first_mut()?.as_flattened_mut();
            for (j, entry) in row.iter_mut().enumerate().take(i + 1) {
                if *support.get(j)? {
                    *entry = *self.row(i)?.get(j)? + weight * *g.get(i)? * *g.get(j)?;
                }
            }
            *row.get_mut(i)? += ridge;
            // Row i of L D, then of L; the reciprocals of D on the diagonal.
            for j in (0..i).filter(|&j| support.get(j) == Some(&true)) {
                let other = done.get(j)?.as_flattened();
                let sum = dot(row.get(..j)?, other.get(..j)?);
                *row.get_mut(j)? -= sum;
            }
            let mut pivot = *row.get(i)?;
            for j in (0..i).filter(|&j| support.get(j) == Some(&true)) {
                let scaled = *row.get(j)?;
                let entry = scaled * *done.get(j)?.as_flattened().get(j)?;
                pivot -= scaled * entry;
                *row.get_mut(j)? = entry;
            }
            if pivot <= T::ZERO || !pivot.is_finite() {
                return None;
            }
            *row.get_mut(i)? = T::ONE / pivot;
            let known = dot(row.get(..i)?, x.get(..i)?);
            *x.get_mut(i)? -= known;
        }
        for i in (0..support.len()).rev() {
            rolled();
            if !*support.get(i)? {
                continue;
            }
            let row = rows.get(i)?.as_flattened();
            *x.get_mut(i)? *= *row.get(i)?;
            let mut entry = *x.get(i)?;
            for (k, below) in rows.iter().enumerate().skip(i + 1) {
                if *support.get(k)? {
                    entry -= *below.as_flattened().get(i)? * *x.get(k)?;
                }
            }
            *x.get_mut(i)? = entry;
        }
        Some(solution)
    }
}

/// Rows that are not zero.
#[inline(never)]
fn support<T: Real, const K: usize, const C: usize>(d: &ContactVector<T, K, C>) -> Support<K, C> {
    d.map(|d| d.map(|d| d != T::ZERO))
}

/// Scales to a largest entry of 1.
#[inline(never)]
fn normalise<T: Real, const K: usize, const C: usize>(d: &mut ContactVector<T, K, C>) {
    let entries = d.as_flattened().iter();
    let largest = entries.fold(T::ZERO, |largest, d| largest.max(d.abs()));
    for d in d.as_flattened_mut() {
        rolled();
        *d /= largest;
    }
}
