//! Vectors and matrices over the contacts: one block of `D` rows a contact, room for `C` contacts.

use crate::Real;
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

/// Inverse of the block of one contact, by Gauss-Jordan elimination with row pivoting; `None` if a
/// pivot vanishes or is no number.
#[inline(never)]
pub(crate) fn invert<T: Real, const D: usize>(block: &[[T; D]; D]) -> Option<[[T; D]; D]> {
    let mut left = *block;
    let mut right = [[T::ZERO; D]; D];
    for (i, row) in right.iter_mut().enumerate() {
        *row.get_mut(i)? = T::ONE;
    }
    for p in 0..D {
        let mut pivot = (*left.get(p)?, *right.get(p)?);
        for (left, right) in left.iter_mut().zip(&mut right).skip(p + 1) {
            if left.get(p)?.abs() > pivot.0.get(p)?.abs() {
                mem::swap(left, &mut pivot.0);
                mem::swap(right, &mut pivot.1);
            }
        }
        let size = *pivot.0.get(p)?;
        let usable = size.abs() > T::ZERO;
        if !usable {
            return None;
        }
        let reciprocal = T::ONE / size;
        pivot = (
            pivot.0.map(|x| x * reciprocal),
            pivot.1.map(|x| x * reciprocal),
        );
        for (i, (left, right)) in left.iter_mut().zip(&mut right).enumerate() {
            if i == p {
                (*left, *right) = pivot;
                continue;
            }
            let factor = *left.get(p)?;
            for (entry, pivot) in left.iter_mut().zip(pivot.0) {
                *entry -= factor * pivot;
            }
            for (entry, pivot) in right.iter_mut().zip(pivot.1) {
                *entry -= factor * pivot;
            }
        }
    }
    Some(right)
}

/// `xᵀ A` for the block of one contact.
#[inline]
pub(crate) fn row_times<T: Real, const D: usize>(x: &[T; D], block: &[[T; D]; D]) -> [T; D] {
    let mut sums = [T::ZERO; D];
    for (&x, row) in x.iter().zip(block) {
        for (sum, &entry) in sums.iter_mut().zip(row) {
            *sum += x * entry;
        }
    }
    sums
}
