//! Gaussian elimination of the equations of contacts and joint rows, with solves for any number of right-hand sides.
//!
//! The matrix is the transpose of that of the equations: a row has the entries of one unknown. So both substitutions of a solve add
//! multiples of rows, where dot products of rows would be one call each.
//!
//! A contact has up to `D` unknowns, a joint row one or none. Unknowns have no gaps: those of contacts fill the first entries of
//! `Stacked::contacts`, those of joint rows the first entries of `Stacked::rows`. The unknowns of contact `k` are the first rows of
//! block `k` of the matrix, those of joint rows the first rows of `StackedMatrix::rows`. A pivot is chosen among the rows of one
//! contact, or among those of all joint rows. Multipliers overwrite the entries that they eliminate.
//!
//! A symmetric matrix is factorised as `L D Lᵀ`. Its pivots stay on the diagonal. Its multipliers are the eliminating rows
//! divided by their pivots. Its blocks below the diagonal blocks are not read.

use crate::linalg::blocks::subtract_rows;
use crate::linalg::stacked::{Stacked, StackedMatrix};
use crate::linalg::zip::zip3;
use crate::real::Real;
use contact::{
    columns_from, columns_from_mut, exchange, multipliers, store_multipliers, symmetric_multipliers,
    triangularise,
};
use core::mem::swap;
use core::ops::Range;

mod contact;

/// Layout of the unknowns and pivots of an eliminated matrix.
///
/// If a contact has fewer than `D` unknowns, its unused rows are zero, except in blocks that are not read.
#[derive(Clone, Debug)]
pub(crate) struct Elimination<T, const D: usize, const C: usize, const R: usize> {
    /// End of the range of columns of each contact.
    ends: [usize; C],
    /// Number of unknowns of joint rows.
    rows: usize,
    /// Reciprocals of the pivots; 0 for an unused row of a contact.
    reciprocals: Stacked<T, D, C, R>,
    /// Index of the row of the contact that was exchanged with each pivot row.
    order: [[usize; D]; C],
    /// The same of joint rows.
    row_order: [usize; R],
}

impl<T: Real, const D: usize, const C: usize, const R: usize> Elimination<T, D, C, R> {
    /// A layout without unknowns.
    pub(crate) const fn none() -> Self {
        Self { ends: [0; C], rows: 0, reciprocals: Stacked::zero(), order: [[0; D]; C], row_order: [0; R] }
    }

    /// Sets the numbers of unknowns of the contacts and of all joint rows together.
    pub(crate) fn lay_out(&mut self, mut counts: impl Iterator<Item = usize>, rows: usize) {
        let mut last = 0;
        for end in &mut self.ends {
            last += counts.next().unwrap_or(0);
            *end = last;
        }
        self.rows = rows;
    }

    /// Range of the columns of a contact.
    pub(crate) fn columns(&self, contact: usize) -> Range<usize> {
        let end = |i: usize| self.ends.get(i).copied().unwrap_or(0);
        end(contact.wrapping_sub(1))..end(contact)
    }

    /// Number of unknowns of contacts.
    fn contact_unknowns(&self) -> usize {
        self.ends.last().copied().unwrap_or(0)
    }

    /// Factorises a matrix; `None` if a pivot vanishes or is NaN. If the matrix is `symmetric` (positive definite up to
    /// rounding), its blocks below the diagonal blocks are not read.
    #[inline(never)]
    pub(crate) fn factorise(
        &mut self,
        matrix: &mut StackedMatrix<T, D, C, R>,
        symmetric: bool,
    ) -> Option<()> {
        let last = self.contact_unknowns();
        for k in 0..C {
            let columns = self.columns(k);
            if columns.is_empty() {
                continue;
            }
            let (start, end) = (columns.start, columns.end);
            let (done, below) = matrix.contacts.split_at_mut_checked(k + 1)?;
            let rows = done.last_mut()?;
            let reciprocals = self.reciprocals.contacts.get_mut(k)?;
            let order = self.order.get_mut(k)?;
            triangularise(rows, columns, [last, self.rows], reciprocals, order, symmetric)?;
            let mut block = [[T::ZERO; D]; D];
            for (block, row) in block.iter_mut().zip(&*rows) {
                *block = columns_from(row, start)?;
            }
            let mut before = end;
            for (others, &until) in below.iter_mut().zip(self.ends.get(k + 1..)?) {
                for (column, row) in (before..until).zip(others) {
                    let eliminated = columns_from_mut(row, start)?;
                    let (factors, first) = if symmetric {
                        let entry =
                            |row: &Stacked<T, D, C, R>| row.contacts.as_flattened().get(column).copied();
                        (symmetric_multipliers(rows, entry, reciprocals), before)
                    } else {
                        (multipliers(eliminated, &block, reciprocals), end)
                    };
                    store_multipliers(eliminated, &factors, end - start);
                    subtract_rows(row, &factors, rows, first..last, 0..self.rows);
                }
                before = until;
            }
            for (column, row) in matrix.rows.iter_mut().enumerate().take(self.rows) {
                let eliminated = columns_from_mut(row, start)?;
                // The columns of contacts of a joint row of a symmetric matrix are not read.
                let (factors, first) = if symmetric {
                    let entry = |row: &Stacked<T, D, C, R>| row.rows.get(column).copied();
                    (symmetric_multipliers(rows, entry, reciprocals), last)
                } else {
                    (multipliers(eliminated, &block, reciprocals), end)
                };
                store_multipliers(eliminated, &factors, end - start);
                subtract_rows(row, &factors, rows, first..last, 0..self.rows);
            }
        }
        self.factorise_rows(&mut matrix.rows, symmetric)
    }

    /// Are all pivots positive?
    pub(crate) fn is_positive(&self) -> bool {
        let contacts = self.reciprocals.contacts.iter().enumerate();
        let mut contacts = contacts.flat_map(|(i, pivots)| {
            let count = self.columns(i).len();
            pivots.iter().take(count)
        });
        let mut rows = self.reciprocals.rows.iter().take(self.rows);
        contacts.all(|&pivot| pivot > T::ZERO) && rows.all(|&pivot| pivot > T::ZERO)
    }

    /// Factorises the equations of joint rows, after elimination of the contacts.
    fn factorise_rows(&mut self, rows: &mut [Stacked<T, D, C, R>; R], symmetric: bool) -> Option<()> {
        for k in 0..self.rows {
            let mut pivot = k;
            if !symmetric {
                let size = |i: usize| rows.get(i)?.rows.get(k).map(|&entry: &T| entry.abs());
                for i in k + 1..self.rows {
                    if size(i)? > size(pivot)? {
                        pivot = i;
                    }
                }
            }
            *self.row_order.get_mut(k)? = pivot;
            if k < pivot && pivot < R {
                exchange(rows, k, pivot)?;
            }
            let (done, below) = rows.split_at_mut_checked(k + 1)?;
            let source = done.last()?.rows;
            let reciprocal = T::ONE / *source.get(k)?;
            let usable = reciprocal.is_finite() && reciprocal.abs() > T::ZERO;
            if !usable {
                return None;
            }
            *self.reciprocals.rows.get_mut(k)? = reciprocal;
            for (i, row) in (k + 1..self.rows).zip(below) {
                let eliminated = if symmetric { source.get(i)? } else { row.rows.get(k)? };
                let factor = *eliminated * reciprocal;
                *row.rows.get_mut(k)? = factor;
                let first = if symmetric { i } else { k + 1 };
                let entries = row.rows.get_mut(first..self.rows)?;
                for (entry, &source) in entries.iter_mut().zip(source.get(first..)?) {
                    *entry -= factor * source;
                }
            }
        }
        Some(())
    }

    /// Solves the equations, those of the transposed matrix, for the right-hand side `b`, and replaces it by the solution.
    #[inline(never)]
    pub(crate) fn solve(
        &self,
        matrix: &StackedMatrix<T, D, C, R>,
        b: &mut Stacked<T, D, C, R>,
    ) -> Option<()> {
        let last = self.contact_unknowns();
        for (k, rows, reciprocals) in zip3(0..C, &matrix.contacts, &self.reciprocals.contacts) {
            let Range { start, end } = self.columns(k);
            if start == end {
                continue;
            }
            let known = columns_from_mut(b, start)?;
            // The factor 0 leaves out unused rows.
            let mut found = [T::ZERO; D];
            for (p, row, &reciprocal) in zip3(start..end, rows, reciprocals) {
                let entry = *known.get(p - start)? * reciprocal;
                *found.get_mut(p - start)? = entry;
                let row = columns_from(row, start)?;
                for (q, known, &u) in zip3(start..end, &mut *known, &row) {
                    if q > p {
                        *known -= entry * u;
                    }
                }
            }
            store_multipliers(known, &found, end - start);
            subtract_rows(b, &found, rows, end..last, 0..self.rows);
        }
        for (k, row) in matrix.rows.iter().enumerate().take(self.rows) {
            let (entry, behind) = b.rows.get_mut(k..self.rows)?.split_first_mut()?;
            *entry *= *self.reciprocals.rows.get(k)?;
            for (behind, &u) in behind.iter_mut().zip(row.rows.get(k + 1..)?) {
                *behind -= *entry * u;
            }
        }
        for (k, row) in matrix.rows.iter().enumerate().take(self.rows).rev() {
            let entry = *b.rows.get(k)?;
            subtract_rows(b, &[entry], core::array::from_ref(row), 0..last, 0..k);
        }
        for (k, &taken) in self.row_order.iter().enumerate().take(self.rows).rev() {
            if let Ok([one, other]) = b.rows.get_disjoint_mut([k, taken]) {
                swap(one, other);
            }
        }
        for k in (0..C).rev() {
            let (rows, order) = (matrix.contacts.get(k)?, self.order.get(k)?);
            let Range { start, end } = self.columns(k);
            if start == end {
                continue;
            }
            let known = columns_from_mut(b, start)?;
            let mut found = [T::ZERO; D];
            for p in (0..end - start).rev() {
                let entry = *known.get(p)?;
                *found.get_mut(p)? = entry;
                let row = columns_from(rows.get(p)?, start)?;
                for (known, &l) in known.iter_mut().zip(&row).take(p) {
                    *known -= entry * l;
                }
            }
            for p in (0..end - start).rev() {
                if let Ok([one, other]) = known.get_disjoint_mut([p, *order.get(p)?]) {
                    swap(one, other);
                }
            }
            subtract_rows(b, &found, rows, 0..start, 0..0);
        }
        Some(())
    }
}

#[cfg(test)]
mod tests;
