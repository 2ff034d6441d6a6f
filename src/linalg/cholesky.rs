//! Root-free dense Cholesky factorisation `A = Lᵀ D⁻¹ L` on row-major storage.
//!
//! `L` is a lower triangle with the pivots `D` on its diagonal. The code stores the reciprocals of the
//! pivots there, so no solve divides. It takes no square root: if a unit changes by an odd power of two, a root changes
//! mantissas; without roots exponents alone change. The upper triangles of `A` and `L` affect no result. Sums run in one fixed
//! order on every machine.
//!
//! Elimination runs from the last row to the first. If the rows are the joints of a robot, base first, the zeros of the mass matrix
//! stay zero (R. Featherstone, *Efficient factorization of the joint-space inertia matrix for branched kinematic trees*, 2005). Rows
//! that would be multiplied by zero are skipped.

use crate::linalg::zip::zip3;
use crate::real::Real;

/// Scalar product over the common length, in four running sums.
#[inline(never)]
pub(crate) fn dot<T: Real>(x: &[T], y: &[T]) -> T {
    let length = x.len().min(y.len());
    let (xs, x_rest) = x.get(..length).unwrap_or(x).as_chunks::<4>();
    let (ys, y_rest) = y.get(..length).unwrap_or(y).as_chunks::<4>();
    let mut sums = [T::ZERO; 4];
    for (x, y) in xs.iter().zip(ys) {
        for (sum, &x, &y) in zip3(&mut sums, x, y) {
            *sum += x * y;
        }
    }
    let mut rest = T::ZERO;
    for (&x, &y) in x_rest.iter().zip(y_rest) {
        rest += x * y;
    }
    let [a, b, c, d] = sums;
    (a + b) + (c + d) + rest
}

/// `y += a x` over the common length.
#[inline(never)]
pub(crate) fn axpy<T: Real>(a: T, x: &[T], y: &mut [T]) {
    let length = x.len().min(y.len());
    let (xs, x_rest) = x.get(..length).unwrap_or(x).as_chunks::<4>();
    let (ys, y_rest) = y.split_at_mut_checked(length & !3).unwrap_or_default();
    for (y, x) in ys.as_chunks_mut::<4>().0.iter_mut().zip(xs) {
        for (y, &x) in y.iter_mut().zip(x) {
            *y += a * x;
        }
    }
    for (y, &x) in y_rest.iter_mut().zip(x_rest) {
        *y += a * x;
    }
}

/// Number of entries of a row, of a solution or of a product that are computed at a time: their sums stay in registers.
pub(crate) const BLOCK: usize = 6;

/// Factorises the first `n` rows and columns of `a` into `l`, and fills `envelope` with the row of the last nonzero entry of each column of `l`. The strict upper
/// triangle of `l` is undefined afterwards.
///
/// Rows are eliminated from the last to the first. The error is the first row whose pivot is not above `floor` times the diagonal
/// entry of `a`, or has a reciprocal that overflows.
#[inline(never)]
pub(crate) fn factorise<T: Real, const N: usize>(
    (a, n): (&[[T; N]; N], usize),
    floor: T,
    l: &mut [[T; N]; N],
    envelope: &mut [usize; N],
) -> Result<(), usize> {
    for k in (0..N).rev() {
        let Some(count) = n.checked_sub(k + 1) else { continue };
        let (above, below) = l.split_at_mut_checked(k + 1).ok_or(k)?;
        let (row, source) = (above.last_mut().ok_or(k)?, a.get(k).ok_or(k)?);
        let below = reaching(below.get(..count).ok_or(k)?, k);
        *envelope.get_mut(k).ok_or(k)? = k + below.len();
        let mut next = 0;
        while next <= k {
            if N < BLOCK {
                reduce::<T, N, 1>(source, below, k, next, row).ok_or(k)?;
                next += 1;
            } else {
                // The last block repeats some columns, so that all blocks have the same size.
                let first = next.min(N - BLOCK);
                reduce::<T, N, BLOCK>(source, below, k, first, row).ok_or(k)?;
                next = first + BLOCK;
            }
        }
        let pivot = row.get_mut(k).ok_or(k)?;
        // NaN fails both tests, and a number whose reciprocal overflows fails the first.
        let least = T::least_normal() * T::literal(0.25);
        let usable = *pivot > least && *pivot > floor * *source.get(k).ok_or(k)?;
        if !usable {
            return Err(k);
        }
        *pivot = T::ONE / *pivot;
    }
    Ok(())
}

/// For each column of a factor the row of its last nonzero entry.
pub(crate) fn envelope<T: Real, const N: usize>(l: &[[T; N]; N], n: usize) -> [usize; N] {
    let mut envelope = [usize::MAX; N];
    for (k, last) in envelope.iter_mut().enumerate().take(n) {
        let below = l.get(k + 1..n).unwrap_or_default();
        *last = k + reaching(below, k).len();
    }
    envelope
}

/// The rows below row `k` up to the last one with an entry in column `k`. Rows behind it change nothing in row `k`.
#[inline]
fn reaching<T: Real, const N: usize>(mut below: &[[T; N]], k: usize) -> &[[T; N]] {
    while let Some((last, rest)) = below.split_last()
        && last.get(k) == Some(&T::ZERO)
    {
        below = rest;
    }
    below
}

/// Computes `K` entries of row `k` of the factor from column `first` on: those of `a`, reduced by the rows below.
#[inline]
fn reduce<T: Real, const N: usize, const K: usize>(
    source: &[T; N],
    below: &[[T; N]],
    k: usize,
    first: usize,
    row: &mut [T; N],
) -> Option<()> {
    let mut sums = *source.get(first..)?.first_chunk::<K>()?;
    for (pivot, others) in (k + 1..N).zip(below) {
        let factor = *others.get(k)? * *others.get(pivot)?;
        for (sum, &entry) in sums.iter_mut().zip(others.get(first..)?.first_chunk::<K>()?) {
            *sum -= factor * entry;
        }
    }
    *row.get_mut(first..)?.first_chunk_mut::<K>()? = sums;
    Some(())
}

#[cfg(test)]
mod tests;
