//! The nonzero columns of a contact Jacobian.
//!
//! A contact moves the base of a robot and one of its limbs, or two bodies of a pile. The other columns are zero: half of them on a
//! quadruped. Products with the Jacobian take groups of three columns, because joints and bodies come in threes, and skip groups of
//! zeros.

use crate::linalg::zip::zip3;
use crate::real::Real;
use core::iter::from_fn;

/// Number of columns in a group.
pub(crate) const GROUP: usize = 3;

/// Number of groups that have a bit in [`Support`]; later groups count as nonzero.
const KNOWN: usize = 16;

/// The groups of columns that are not all zero, one bit a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Support {
    bits: u16,
}

impl Support {
    /// No column.
    pub(crate) const fn none() -> Self {
        Self { bits: 0 }
    }

    /// All columns.
    pub(crate) const fn all() -> Self {
        Self { bits: u16::MAX }
    }

    /// The support of a matrix of `N` columns, from the indices of its nonzero columns.
    #[inline]
    pub(crate) fn of<const N: usize>(columns: impl Iterator<Item = usize>) -> Self {
        if is_dense(N) {
            return Self::all();
        }
        let mut bits = 0;
        for column in columns {
            let group = column.div_euclid(GROUP);
            if group < KNOWN {
                bits |= 1 << group;
            }
        }
        Self { bits }
    }

    /// The groups of `N` columns that may have entries; columns from `n` on have none.
    #[inline]
    pub(crate) fn groups<const N: usize>(self, n: usize) -> impl Iterator<Item = usize> + Clone {
        let count = N.div_euclid(GROUP);
        let mut bits = if is_dense(N) { u16::MAX } else { self.bits };
        if count < KNOWN {
            bits &= (1 << count) - 1;
        }
        let known = from_fn(move || {
            let group = bits.trailing_zeros();
            bits &= bits.checked_sub(1)?;
            usize::try_from(group).ok()
        });
        // The bits end at `n` by themselves. Where there are no others this is an empty range, whatever `n`.
        let end = if count > KNOWN { count.min(n.div_ceil(GROUP)) } else { count };
        known.chain(KNOWN..end)
    }
}

/// `sums += Σ_j g_j column_j`
#[inline]
pub(crate) fn add_columns<T: Real, const D: usize>(columns: &[[T; D]], g: &[T], sums: &mut [T; D]) {
    for (column, &g) in columns.iter().zip(g) {
        for (sum, &entry) in sums.iter_mut().zip(column) {
            *sum += entry * g;
        }
    }
}

/// `sums += Σ_j |g_j| |column_j|`
#[inline]
pub(crate) fn add_sizes<T: Real, const D: usize>(columns: &[[T; D]], g: &[T], sums: &mut [T; D]) {
    for (column, &g) in columns.iter().zip(g) {
        for (sum, &entry) in sums.iter_mut().zip(column) {
            *sum += (entry * g).abs();
        }
    }
}

/// `g_j += r · column_j`
#[inline]
pub(crate) fn add_products<T: Real, const D: usize>(columns: &[[T; D]], r: [T; D], g: &mut [T]) {
    for (g, column) in g.iter_mut().zip(columns) {
        let mut sum = *g;
        for (r, &entry) in r.into_iter().zip(column) {
            sum += r * entry;
        }
        *g = sum;
    }
}

/// [`add_columns`], and adds the magnitudes of the terms to `sizes`.
#[inline]
pub(crate) fn add_columns_and_sizes<T: Real, const D: usize>(
    columns: &[[T; D]],
    g: &[T],
    sums: &mut [T; D],
    sizes: &mut [T; D],
) {
    for (column, &g) in columns.iter().zip(g) {
        for (sum, size, &entry) in zip3(&mut *sums, &mut *sizes, column) {
            let product = entry * g;
            *sum += product;
            *size += product.abs();
        }
    }
}

/// [`add_products`], and adds the magnitudes of the terms to `sizes`.
#[inline]
pub(crate) fn add_products_and_sizes<T: Real, const D: usize>(
    columns: &[[T; D]],
    r: [T; D],
    g: &mut [T],
    sizes: &mut [T],
) {
    for (g, size, column) in zip3(g, sizes, columns) {
        let (mut sum, mut terms) = (*g, *size);
        for (r, &entry) in r.into_iter().zip(column) {
            let product = r * entry;
            sum += product;
            terms += product.abs();
        }
        (*g, *size) = (sum, terms);
    }
}

/// Are all groups used without a test? With fewer than three groups the test does not pay.
const fn is_dense(columns: usize) -> bool {
    columns < 3 * GROUP
}

#[cfg(test)]
mod tests;
