//! Vectors and matrices over up to `C` contacts, with a block of `D` rows for each contact.

use crate::linalg::stacked::Stacked;
use crate::real::Real;
use core::array::from_fn;
use core::ops::Range;

/// A vector in contact space.
pub(crate) type ContactVector<T, const D: usize, const C: usize> = [[T; D]; C];

/// A square matrix in contact space, row by row.
pub(crate) type ContactMatrix<T, const D: usize, const C: usize> = [[ContactVector<T, D, C>; D]; C];

/// The block `A_ij` of contacts `i` and `j`.
#[inline]
pub(crate) fn block<T: Real, const D: usize, const C: usize>(
    matrix: &ContactMatrix<T, D, C>,
    i: usize,
    j: usize,
) -> Option<[[T; D]; D]> {
    let rows = matrix.get(i)?.each_ref();
    let entries = |row: &ContactVector<T, D, C>| row.get(j).copied().unwrap_or([T::ZERO; D]);
    (j < C).then(|| rows.map(entries))
}

/// Replaces the block `A_ij`; `None` if there is no such block.
#[inline]
pub(crate) fn set_block<T: Real, const D: usize, const C: usize>(
    matrix: &mut ContactMatrix<T, D, C>,
    i: usize,
    j: usize,
    block: &[[T; D]; D],
) -> Option<()> {
    for (row, entries) in matrix.get_mut(i)?.iter_mut().zip(block) {
        *row.get_mut(j)? = *entries;
    }
    Some(())
}

/// The entries on the diagonal of a matrix.
#[inline]
pub(crate) fn diagonal_of<T: Real, const N: usize>(matrix: &[[T; N]; N]) -> impl Iterator<Item = T> {
    let rows = matrix.iter().enumerate();
    rows.map(|(k, row)| row.get(k).copied().unwrap_or(T::ZERO))
}

/// `Bᵀ` for a block.
#[inline]
pub(crate) fn transpose<T: Real, const D: usize>(block: &[[T; D]; D]) -> [[T; D]; D] {
    let mut transposed = [[T::ZERO; D]; D];
    for (a, row) in block.iter().enumerate() {
        for (column, &entry) in transposed.iter_mut().zip(row) {
            if let Some(target) = column.get_mut(a) {
                *target = entry;
            }
        }
    }
    transposed
}

/// `B⁻¹` of a symmetric block of up to three rows, by cofactors and one division. It is zero if the block has more rows, or is so
/// nearly singular that rounding would spoil the inverse.
#[inline]
pub(crate) fn inverse<T: Real, const D: usize>(block: &[[T; D]; D]) -> [[T; D]; D] {
    // The block is extended to three rows by those of a unit matrix.
    let entry = |i: usize, j: usize| {
        let (i, j) = (i % 3, j % 3);
        let unit = if i == j { T::ONE } else { T::ZERO };
        let entry = block.get(i).and_then(|row| row.get(j));
        entry.copied().unwrap_or(unit)
    };
    let cofactor = |i: usize, j: usize| {
        entry(i + 1, j + 1) * entry(i + 2, j + 2) - entry(i + 1, j + 2) * entry(i + 2, j + 1)
    };
    let diagonal = entry(0, 0) * entry(1, 1) * entry(2, 2);
    let determinant = (0..3).fold(T::ZERO, |sum, j| sum + entry(0, j) * cofactor(0, j));
    let regular = D <= 3 && determinant > T::literal(4096.0) * T::EPSILON * diagonal;
    let shrink = if regular { T::ONE / determinant } else { T::ZERO };
    from_fn(|i| from_fn(|j| shrink * cofactor(i, j)))
}

/// `y = Aᵀ x`, where `x` and `y` have the same number of contacts.
///
/// Rows of `A` are read as columns of `Aᵀ`, four contacts at a time, so that the sums stay in registers.
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

/// Blocks of `Aᵀ x` for `B` contacts from index `first` on; `None` if `A` has fewer.
#[inline]
fn columns<T: Real, const D: usize, const C: usize, const B: usize>(
    matrix: &ContactMatrix<T, D, C>,
    first: usize,
    x: &[[T; D]],
) -> Option<ContactVector<T, D, B>> {
    let mut sums = [[T::ZERO; D]; B];
    let rows = matrix.as_flattened().iter().zip(x.as_flattened());
    for (row, &x) in rows {
        let row = row.get(first..)?.first_chunk::<B>()?;
        for (sums, row) in sums.iter_mut().zip(row) {
            for (sum, &entry) in sums.iter_mut().zip(row) {
                *sum += entry * x;
            }
        }
    }
    Some(sums)
}

/// `row -= Σ_d factors[d] rows[d]` in the ranges `contacts` and `joints` of columns.
#[inline(always)]
#[allow(clippy::inline_always)] // a call would pass the factors through memory, and wait for them
pub(crate) fn subtract_rows<T: Real, const D: usize, const C: usize, const R: usize, const K: usize>(
    row: &mut Stacked<T, D, C, R>,
    factors: &[T; K],
    rows: &[Stacked<T, D, C, R>; K],
    contacts: Range<usize>,
    joints: Range<usize>,
) {
    let target = row.contacts.as_flattened_mut();
    for k in contacts.start..contacts.end.min(D * C) {
        subtract(target.get_mut(k), factors, rows, |row| row.contacts.as_flattened().get(k));
    }
    for k in joints.start..joints.end.min(R) {
        subtract(row.rows.get_mut(k), factors, rows, |row| row.rows.get(k));
    }
}

/// `entry -= Σ_d factors[d] entry(rows[d])`
#[inline(always)]
#[allow(clippy::inline_always)] // as above
pub(crate) fn subtract<T: Real, const D: usize, V>(
    target: Option<&mut T>,
    factors: &[T; D],
    rows: &[V; D],
    entry: impl Fn(&V) -> Option<&T>,
) {
    if let Some(target) = target {
        let mut sum = *target;
        for (&factor, row) in factors.iter().zip(rows) {
            sum -= factor * entry(row).copied().unwrap_or(T::ZERO);
        }
        *target = sum;
    }
}

/// `x · y` over the rows of one contact.
#[inline]
pub(crate) fn product<T: Real, const D: usize>(x: &[T; D], y: &[T; D]) -> T {
    x.iter().zip(y).fold(T::ZERO, |sum, (&x, &y)| sum + x * y)
}

/// `xᵀ A` for rows of one contact.
#[inline]
pub(crate) fn row_times<T: Real, const D: usize, const L: usize>(x: &[T; D], block: &[[T; L]; D]) -> [T; L] {
    let mut sums = [T::ZERO; L];
    for (&x, row) in x.iter().zip(block) {
        for (sum, &entry) in sums.iter_mut().zip(row) {
            *sum += x * entry;
        }
    }
    sums
}

#[cfg(test)]
mod tests;
