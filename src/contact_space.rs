//! Vectors and matrices over the contacts: one block of `D` rows a contact, room for `C` contacts.

use crate::Real;
use crate::cholesky::axpy;
use core::mem;

/// A vector in contact space.
pub(crate) type ContactVector<T, const D: usize, const C: usize> = [[T; D]; C];

/// A square matrix in contact space, row by row.
pub(crate) type ContactMatrix<T, const D: usize, const C: usize> = [[ContactVector<T, D, C>; D]; C];

/// `y = Aᵀ x` over the contacts of `y`, of which `x` has as many.
///
/// Rows of `A` are read as columns of `Aᵀ`, four contacts of each at a time, so that the sums stay
/// in registers.
#[inline(never)]
pub(crate) fn multiply_transposed<T: Real, const D: usize, const C: usize>(
    matrix: &ContactMatrix<T, D, C>,
    x: &[[T; D]],
    y: &mut [[T; D]],
) {
    for (k, y) in y.chunks_mut(4).enumerate() {
        if 4 * k + 4 <= C {
            let sums = columns::<T, D, C, 4>(matrix, 4 * k, x);
            for (y, sums) in y.iter_mut().zip(sums) {
                *y = sums;
            }
        } else {
            for (i, y) in y.iter_mut().enumerate() {
                let [sums] = columns::<T, D, C, 1>(matrix, 4 * k + i, x);
                *y = sums;
            }
        }
    }
}

/// Rows of `Aᵀ x` for `B` contacts from `first` on.
#[inline]
fn columns<T: Real, const D: usize, const C: usize, const B: usize>(
    matrix: &ContactMatrix<T, D, C>,
    first: usize,
    x: &[[T; D]],
) -> ContactVector<T, D, B> {
    let mut sums = [[T::ZERO; D]; B];
    let rows = matrix.as_flattened().iter().zip(x.as_flattened());
    for (row, &x) in rows {
        let Some(row) = row.get(first..).and_then(<[_]>::first_chunk::<B>) else {
            continue;
        };
        for (sums, row) in sums.iter_mut().zip(row) {
            for (sum, &entry) in sums.iter_mut().zip(row) {
                *sum += entry * x;
            }
        }
    }
    sums
}

/// `row -= Σ_d factors[d] rows[d]` from scalar column `first` on, up to `last`.
#[inline(never)]
pub(crate) fn subtract_rows<T: Real, const D: usize, const C: usize>(
    row: &mut ContactVector<T, D, C>,
    factors: &[T; D],
    rows: &[ContactVector<T, D, C>; D],
    first: usize,
    last: usize,
) {
    let row = row.as_flattened_mut();
    for k in first..last.min(D * C) {
        if let Some(entry) = row.get_mut(k) {
            let mut sum = *entry;
            for (&factor, row) in factors.iter().zip(rows) {
                sum -= factor * row.as_flattened().get(k).copied().unwrap_or(T::ZERO);
            }
            *entry = sum;
        }
    }
}

/// Gauss-Jordan elimination of the diagonal block of contact `k` among its rows, in place: from
/// contact `first` to `last` they are multiplied by the inverse of that block, which takes its
/// place.
///
/// With a right-hand side the pivots are sought in the columns of the block, and its entries change
/// places with the rows; it is not multiplied. `None` if a pivot vanishes or is no number.
#[inline(never)]
pub(crate) fn normalise<T: Real, const D: usize, const C: usize>(
    rows: &mut [ContactVector<T, D, C>; D],
    k: usize,
    first: usize,
    last: usize,
    mut rhs: Option<&mut [T; D]>,
) -> Option<()> {
    for p in 0..D {
        if let Some(rhs) = &mut rhs {
            let size = |row: &ContactVector<T, D, C>| Some(row.get(k)?.get(p)?.abs());
            let (mut largest, mut index) = (T::ZERO, p);
            for (i, row) in rows.iter().enumerate().skip(p) {
                let size = size(row)?;
                if size > largest {
                    (largest, index) = (size, i);
                }
            }
            // `slice::swap` would be a reachable panic.
            if let (Some((upper, lower)), Some((left, right))) = (
                rows.split_at_mut_checked(index),
                rhs.split_at_mut_checked(index),
            ) && let (Some(one), Some(other)) = (upper.get_mut(p), lower.first_mut())
                && let (Some(left), Some(right)) = (left.get_mut(p), right.first_mut())
            {
                mem::swap(one, other);
                mem::swap(left, right);
            }
        }
        let (above, rest) = rows.split_at_mut_checked(p)?;
        let (pivot_row, below) = rest.split_first_mut()?;
        let pivot = pivot_row.get_mut(k)?.get_mut(p)?;
        let usable = pivot.abs() > T::ZERO;
        if !usable {
            return None;
        }
        let reciprocal = T::ONE / *pivot;
        *pivot = T::ONE;
        let pivot_row = pivot_row.get_mut(first..last)?.as_flattened_mut();
        for entry in &mut *pivot_row {
            *entry *= reciprocal;
        }
        for row in above.iter_mut().chain(below) {
            let factor = mem::replace(row.get_mut(k)?.get_mut(p)?, T::ZERO);
            axpy(
                -factor,
                pivot_row,
                row.get_mut(first..last)?.as_flattened_mut(),
            );
        }
    }
    Some(())
}
