//! Elimination among the equations of one contact, and its multipliers in other equations.

use crate::linalg::stacked::Stacked;
use crate::linalg::zip::zip3;
use crate::real::Real;
use core::mem::swap;
use core::ops::Range;

/// The `D` entries of a row from column `start` on.
#[inline]
pub(super) fn columns_from<T: Real, const D: usize, const C: usize, const R: usize>(
    row: &Stacked<T, D, C, R>,
    start: usize,
) -> Option<[T; D]> {
    let entries = row.contacts.as_flattened().get(start..)?;
    entries.first_chunk::<D>().copied()
}

/// [`columns_from`], mutable.
#[inline]
pub(super) fn columns_from_mut<T: Real, const D: usize, const C: usize, const R: usize>(
    row: &mut Stacked<T, D, C, R>,
    start: usize,
) -> Option<&mut [T; D]> {
    let entries = row.contacts.as_flattened_mut().get_mut(start..)?;
    entries.first_chunk_mut::<D>()
}

/// Writes the first `count` multipliers over the entries that they have eliminated.
#[inline]
pub(super) fn store_multipliers<T: Real, const D: usize>(
    eliminated: &mut [T; D],
    factors: &[T; D],
    count: usize,
) {
    for (p, entry, &factor) in zip3(0..D, eliminated, factors) {
        if p < count {
            *entry = factor;
        }
    }
}

/// Multipliers of a symmetric matrix: the entries of a contact's equations in one column, divided by their pivots.
#[inline]
pub(super) fn symmetric_multipliers<T: Real, const D: usize, V>(
    rows: &[V; D],
    entry: impl Fn(&V) -> Option<T>,
    reciprocals: &[T; D],
) -> [T; D] {
    let mut factors = *reciprocals;
    for (factor, row) in factors.iter_mut().zip(rows) {
        *factor *= entry(row).unwrap_or(T::ZERO);
    }
    factors
}

/// Multipliers `x U⁻¹` that eliminate the entries `x`, with `U` above the diagonal of `block` and the reciprocals of its diagonal.
#[inline]
pub(super) fn multipliers<T: Real, const D: usize>(
    x: &[T; D],
    block: &[[T; D]; D],
    reciprocals: &[T; D],
) -> [T; D] {
    let mut quotient = *x;
    for (p, row, &reciprocal) in zip3(0..D, block, reciprocals) {
        let mut factor = T::ZERO;
        if let Some(entry) = quotient.get_mut(p) {
            *entry *= reciprocal;
            factor = *entry;
        }
        for (q, x, &u) in zip3(0..D, &mut quotient, row) {
            if q > p {
                *x -= factor * u;
            }
        }
    }
    quotient
}

/// Eliminates among the rows of one contact: first in the columns of the contact, then in those behind, up to the columns `last` of
/// contacts and `last_row` of joint rows.
#[inline(never)]
pub(super) fn triangularise<T: Real, const D: usize, const C: usize, const R: usize>(
    rows: &mut [Stacked<T, D, C, R>; D],
    columns: Range<usize>,
    [last, last_row]: [usize; 2],
    reciprocals: &mut [T; D],
    order: &mut [usize; D],
    symmetric: bool,
) -> Option<()> {
    let count = columns.len();
    let mut block = [[T::ZERO; D]; D];
    for (block, row) in block.iter_mut().zip(&*rows) {
        *block = columns_from(row, columns.start)?;
    }
    *reciprocals = [T::ZERO; D];
    for (p, reciprocal, taken) in zip3(0..count, reciprocals, order) {
        // Unused rows are zero, and never chosen.
        let (mut largest, mut index) = (T::ZERO, p);
        let end = if symmetric { p + 1 } else { D };
        for i in p..end {
            let size = block.get(i)?.get(p)?.abs();
            if size > largest {
                (largest, index) = (size, i);
            }
        }
        *taken = index;
        if index != p && index < D {
            exchange(rows, p, index)?;
            block.swap(p, index);
        }
        let source = *block.get(p)?;
        *reciprocal = T::ONE / *source.get(p)?;
        let usable = largest > T::ZERO && reciprocal.abs() > T::ZERO;
        if !usable {
            return None;
        }
        for i in p + 1..D {
            let row = block.get_mut(i)?;
            let factor = *row.get(p)? * *reciprocal;
            for (q, entry, &source) in zip3(0..D, &mut *row, &source) {
                if q > p {
                    *entry -= factor * source;
                }
            }
            *row.get_mut(p)? = factor;
        }
    }
    for (row, block) in rows.iter_mut().zip(&block).take(count) {
        let entries = row.contacts.as_flattened_mut();
        *entries.get_mut(columns.start..)?.first_chunk_mut::<D>()? = *block;
    }
    for (i, row) in block.iter_mut().enumerate() {
        for (p, factor) in row.iter_mut().enumerate() {
            if p >= i || i >= count {
                *factor = T::ZERO;
            }
        }
    }
    for k in columns.start + D..last.min(D * C) {
        eliminate_column(rows, &block, |row| row.contacts.as_flattened_mut().get_mut(k));
    }
    for k in 0..last_row {
        eliminate_column(rows, &block, |row| row.rows.get_mut(k));
    }
    Some(())
}

/// Exchanges the row `one` and the row `behind`, a later one, entry by entry: a `swap` of such large values would link `memmove`.
#[cfg_attr(target_os = "none", inline(never))]
pub(super) fn exchange<T, const D: usize, const C: usize, const R: usize>(
    rows: &mut [Stacked<T, D, C, R>],
    one: usize,
    behind: usize,
) -> Option<()> {
    let (before, rest) = rows.split_at_mut_checked(behind)?;
    let (one, other) = (before.get_mut(one)?, rest.first_mut()?);
    let contacts = one.contacts.as_flattened_mut().iter_mut();
    for (x, y) in contacts.zip(other.contacts.as_flattened_mut()) {
        swap(x, y);
    }
    for (x, y) in one.rows.iter_mut().zip(&mut other.rows) {
        swap(x, y);
    }
    Some(())
}

/// Eliminates in one column behind those of the contact, with the multipliers of its block.
#[inline]
fn eliminate_column<T: Real, const D: usize, V>(
    rows: &mut [V; D],
    factors: &[[T; D]; D],
    entry: impl Fn(&mut V) -> Option<&mut T>,
) {
    let mut x = [T::ZERO; D];
    for (i, row, factors) in zip3(0..D, rows, factors) {
        if let Some(entry) = entry(row) {
            for (&x, &factor) in x.iter().zip(factors).take(i) {
                *entry -= factor * x;
            }
            if let Some(x) = x.get_mut(i) {
                *x = *entry;
            }
        }
    }
}
