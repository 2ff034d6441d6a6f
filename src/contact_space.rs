//! Vectors and matrices over the contacts: one block of `D` rows a contact, room for `C` contacts.

use crate::Real;
use crate::cholesky::{axpy, rolled};

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
    let mut rest = y;
    let mut first = 0;
    while let Some((y, others)) = rest.split_first_mut() {
        if let Some([one, more @ ..]) = columns::<T, D, C, 4>(matrix, first, x) {
            *y = one;
            for (y, sums) in others.iter_mut().zip(&more) {
                rolled();
                *y = *sums;
            }
            rest = others.get_mut(3..).unwrap_or_default();
            first += 4;
        } else {
            let Some([sums]) = columns(matrix, first, x) else {
                return;
            };
            *y = sums;
            rest = others;
            first += 1;
        }
    }
}

/// Rows of `Aᵀ x` for `B` contacts from `first` on, if `A` has room for as many.
#[inline]
fn columns<T: Real, const D: usize, const C: usize, const B: usize>(
    matrix: &ContactMatrix<T, D, C>,
    first: usize,
    x: &[[T; D]],
) -> Option<ContactVector<T, D, B>> {
    let mut sums = [[T::ZERO; D]; B];
    let rows = matrix.as_flattened().iter().zip(x.as_flattened());
    for (row, &x) in rows {
        rolled();
        let row = row.get(first..)?.first_chunk::<B>()?;
        for (sums, row) in sums.iter_mut().zip(row) {
            for (sum, &entry) in sums.iter_mut().zip(row) {
                *sum += entry * x;
            }
        }
    }
    Some(sums)
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

/// Gaussian elimination among the rows of contact `k`, which makes its diagonal block upper
/// triangular; from contact `first` to `last`. Gives the reciprocals of the pivots.
///
/// `None` if a pivot vanishes or is no number.
#[inline(never)]
pub(crate) fn triangularise<T: Real, const D: usize, const C: usize>(
    rows: &mut [ContactVector<T, D, C>; D],
    k: usize,
    first: usize,
    last: usize,
) -> Option<[T; D]> {
    let mut reciprocals = [T::ZERO; D];
    for (p, reciprocal) in reciprocals.iter_mut().enumerate() {
        let (above, below) = rows.split_at_mut_checked(p + 1)?;
        let pivot_row = above.last()?;
        let pivot = *pivot_row.get(k)?.get(p)?;
        let usable = pivot.abs() > T::ZERO;
        if !usable {
            return None;
        }
        *reciprocal = T::ONE / pivot;
        let source = pivot_row.get(first..last)?.as_flattened();
        for row in below {
            let factor = *row.get(k)?.get(p)? * *reciprocal;
            axpy(
                -factor,
                source,
                row.get_mut(first..last)?.as_flattened_mut(),
            );
        }
    }
    Some(reciprocals)
}

/// Solves `U x = y` in place for the upper triangle of the diagonal block of contact `k`.
pub(crate) fn back_substitute<T: Real, const D: usize, const C: usize>(
    rows: &[ContactVector<T, D, C>; D],
    k: usize,
    reciprocals: &[T; D],
    x: &mut [T; D],
) -> Option<()> {
    for (p, row) in rows.iter().enumerate().rev() {
        let (head, solved) = x.split_at_mut_checked(p + 1)?;
        let entry = head.last_mut()?;
        for (&u, &x) in row.get(k)?.get(p + 1..)?.iter().zip(&*solved) {
            *entry -= u * x;
        }
        *entry *= *reciprocals.get(p)?;
    }
    Some(())
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
