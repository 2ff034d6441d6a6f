//! Root-free dense Cholesky factorisation `A = Uᵀ D⁻¹ U` on row-major storage.
//!
//! `U` is lower triangular with the pivots `D` on its diagonal; their reciprocals stand in that
//! place, so that no solve divides and no square root is taken. (With roots, a change of units by
//! an odd power of two would change mantissas; without, it changes exponents only.) Only the lower
//! triangle is read and written, and sums run in one fixed order on every machine.
//!
//! Elimination runs from the last row to the first. Where the rows are the joints of a robot, its
//! base first, that leaves the zeros of the mass matrix zero (R. Featherstone, *Efficient
//! factorization of the joint-space inertia matrix for branched kinematic trees*, 2005), and rows
//! are not added where they are multiplied by zero.

use crate::Real;
use core::hint::black_box;

/// A slice of whose length the compiler knows nothing where flash counts: loops over dofs or contacts
/// that it unrolls are several times as large and hardly faster.
#[inline]
pub(crate) fn opaque<T>(slice: &[T]) -> &[T] {
    if cfg!(target_os = "none") {
        black_box(slice)
    } else {
        slice
    }
}

/// [`opaque`], to be written to.
#[inline]
pub(crate) fn opaque_mut<T>(slice: &mut [T]) -> &mut [T] {
    if cfg!(target_os = "none") {
        black_box(slice)
    } else {
        slice
    }
}

/// Keeps the loop around it from being unrolled where flash counts, at no instruction: a compiler
/// unrolls loops over dofs or contacts fourfold, which makes them larger and hardly faster.
#[inline]
pub(crate) fn rolled() {
    if cfg!(target_os = "none") {
        black_box(());
    }
}

/// Scalar product over the common length, in four running sums.
#[inline(never)]
pub(crate) fn dot<T: Real>(x: &[T], y: &[T]) -> T {
    let length = x.len().min(y.len());
    let (xs, x_rest) = x.get(..length).unwrap_or(x).as_chunks::<4>();
    let (ys, y_rest) = y.get(..length).unwrap_or(y).as_chunks::<4>();
    let mut sums = [T::ZERO; 4];
    for (x, y) in xs.iter().zip(ys) {
        rolled();
        for ((sum, &x), &y) in sums.iter_mut().zip(x).zip(y) {
            *sum += x * y;
        }
    }
    let mut rest = T::ZERO;
    for (&x, &y) in x_rest.iter().zip(y_rest) {
        rolled();
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
        rolled();
        for (y, &x) in y.iter_mut().zip(x) {
            *y += a * x;
        }
    }
    for (y, &x) in y_rest.iter_mut().zip(x_rest) {
        rolled();
        *y += a * x;
    }
}

/// Factorises the leading `n × n` block of `a` into `u`; row `i` starts at `i * stride`.
///
/// Fails with the row of the first pivot, from the last row on, that is not above `floor` times
/// the diagonal of `a`.
#[inline(never)]
pub(crate) fn factorise<T: Real>(
    a: &[T],
    stride: usize,
    n: usize,
    floor: T,
    u: &mut [T],
) -> Result<(), usize> {
    let u = u.get_mut(..n * stride).ok_or(n)?;
    for k in (0..n).rev() {
        let start = k * stride;
        let source = a.get(start..start + stride).ok_or(k)?;
        let (above, rest) = u.split_at_mut_checked(start + k + 1).ok_or(k)?;
        let row = above.get_mut(start..).ok_or(k)?;
        let rows = reaching(rest.get(stride - k - 1..).ok_or(k)?, stride, k);
        // From behind one diagonal entry to the next.
        let diagonals = rest.chunks_exact(stride.saturating_add(1));
        let below = rows.chunks_exact(stride.max(1)).zip(diagonals);
        let mut next = 0;
        while next <= k {
            // Six columns at a time, the last six of a row with some that are known already.
            let first = next.min(stride.saturating_sub(6));
            if let Some(sums) = reduced::<T, 6>(source, below.clone(), k, first) {
                let entries = row.get_mut(first..).unwrap_or_default();
                for (entry, sum) in entries.iter_mut().zip(sums) {
                    *entry = sum;
                }
                next = first + 6;
            } else {
                let [sum] = reduced(source, below.clone(), k, next).ok_or(k)?;
                *row.get_mut(next).ok_or(k)? = sum;
                next += 1;
            }
        }
        let pivot = row.last_mut().ok_or(k)?;
        // A NaN is no pivot either.
        let usable = *pivot > T::ZERO && *pivot > floor * *source.get(k).ok_or(k)?;
        if !usable {
            return Err(k);
        }
        *pivot = T::ONE / *pivot;
    }
    Ok(())
}

/// The rows below row `k` up to the last with an entry in its column: no fill-in comes beyond.
#[inline]
fn reaching<T: Real>(mut below: &[T], stride: usize, k: usize) -> &[T] {
    while let Some((rest, last)) = below
        .len()
        .checked_sub(stride)
        .and_then(|start| below.split_at_checked(start))
        && last.get(k) == Some(&T::ZERO)
    {
        rolled();
        below = rest;
    }
    below
}

/// `K` entries of row `k` from column `first` on, less what the rows below it take away; `None`
/// beyond the last column. With each of those rows comes what ends in its reciprocal pivot.
#[inline]
fn reduced<'a, T: Real, const K: usize>(
    source: &[T],
    below: impl Iterator<Item = (&'a [T], &'a [T])>,
    k: usize,
    first: usize,
) -> Option<[T; K]> {
    let mut sums = *source.get(first..)?.first_chunk::<K>()?;
    for (row, diagonal) in below {
        rolled();
        let factor = *row.get(k)? * *diagonal.last()?;
        for (sum, &entry) in sums.iter_mut().zip(row.get(first..)?.first_chunk::<K>()?) {
            *sum -= factor * entry;
        }
    }
    Some(sums)
}

#[cfg(test)]
mod tests;
