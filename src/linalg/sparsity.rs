//! The nonzero columns of a contact Jacobian.
//!
//! A contact moves the base of a robot and one of its limbs, or two bodies of a pile. The other columns are zero: half of them on a
//! quadruped. Products with the Jacobian take groups of three columns, because joints and bodies come in threes, and skip groups of
//! zeros.

use crate::linalg::sum::Sum;
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

    /// Adds `J g` to `sums`. `J` has these columns, of which `n` are in use.
    #[inline]
    pub(crate) fn add_product<T: Real, A: Sum<T>, const N: usize, const D: usize>(
        self,
        (columns, n): (&[[T; D]; N], usize),
        g: &[T; N],
        sums: &mut [A; D],
    ) {
        let (columns, rest) = columns.as_chunks::<GROUP>();
        let (g, last) = g.as_chunks::<GROUP>();
        for group in self.groups::<N>(n) {
            if let (Some(columns), Some(g)) = (columns.get(group), g.get(group)) {
                add_columns(columns, g, sums);
            }
        }
        add_columns(rest, last, sums);
    }

    /// Adds `Jᵀ r` to `sums`. `J` has these columns, of which `n` are in use.
    #[inline]
    pub(crate) fn add_transposed_product<T: Real, A: Sum<T>, const N: usize, const D: usize>(
        self,
        (columns, n): (&[[T; D]; N], usize),
        r: [T; D],
        sums: &mut [A; N],
    ) {
        let (columns, rest) = columns.as_chunks::<GROUP>();
        let (sums, last) = sums.as_chunks_mut::<GROUP>();
        for group in self.groups::<N>(n) {
            if let (Some(columns), Some(sums)) = (columns.get(group), sums.get_mut(group)) {
                add_products(columns, r, sums);
            }
        }
        add_products(rest, r, last);
    }
}

/// `sums += Σ_j g_j column_j`
#[inline]
pub(crate) fn add_columns<T: Real, A: Sum<T>, const D: usize>(
    columns: &[[T; D]],
    g: &[T],
    sums: &mut [A; D],
) {
    for (column, &g) in columns.iter().zip(g) {
        for (sum, &entry) in sums.iter_mut().zip(column) {
            sum.add(entry, g);
        }
    }
}

/// `g_j += r · column_j`
#[inline]
pub(crate) fn add_products<T: Real, A: Sum<T>, const D: usize>(columns: &[[T; D]], r: [T; D], g: &mut [A]) {
    for (g, column) in g.iter_mut().zip(columns) {
        let mut sum = *g;
        for (r, &entry) in r.into_iter().zip(column) {
            sum.add(entry, r);
        }
        *g = sum;
    }
}

/// Are all groups used without a test? With fewer than three groups the test does not pay.
const fn is_dense(columns: usize) -> bool {
    columns < 3 * GROUP
}

#[cfg(test)]
mod tests;
