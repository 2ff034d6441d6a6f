//! Gaussian elimination by contacts and joint rows, kept so that more right-hand sides can be solved.
//!
//! A contact has up to `D` unknowns and a joint row one or none. Unknowns stand close together: those of contacts in the
//! contacts' entries of a vector, those of joint rows in the rows' entries. A contact's equations stand in its own rows of the
//! matrix, those of the joint rows in the first rows behind them. Pivots are sought within the equations of a contact, and
//! among those of all joint rows. The multipliers stay where they have eliminated. Of a symmetric matrix they are the rows that
//! eliminate, divided by their pivots (`L D Lᵀ`): pivots stay on the diagonal, and what stands above it is enough.

use crate::linalg::blocks::subtract_rows;
use crate::linalg::cholesky::dot;
use crate::linalg::stacked::{Stacked, StackedMatrix};
use crate::real::Real;
use contact::{divide, exchange, keep, multiply, own_columns, own_columns_mut, triangularise};
use core::ops::Range;

mod contact;

/// Where the unknowns stand in an eliminated matrix, and its pivots.
///
/// Unused equations of a contact that has others are zero, except in blocks that are not read.
#[derive(Clone, Debug)]
pub(crate) struct Elimination<T, const D: usize, const C: usize, const R: usize> {
    /// Where the columns of each contact end.
    ends: [usize; C],
    /// Unknowns of joint rows.
    rows: usize,
    /// Reciprocals of the pivots; 0 for a missing pivot of a contact that has others.
    reciprocals: Stacked<T, D, C, R>,
    /// Which equation of the contact, and which of the joint rows, was taken for each pivot.
    order: [[usize; D]; C],
    row_order: [usize; R],
}

impl<T: Real, const D: usize, const C: usize, const R: usize> Elimination<T, D, C, R> {
    pub(crate) const fn none() -> Self {
        Self {
            ends: [0; C],
            rows: 0,
            reciprocals: Stacked::zero(),
            order: [[0; D]; C],
            row_order: [0; R],
        }
    }

    /// Gives each contact its number of unknowns, and so many to joint rows.
    pub(crate) fn lay_out(&mut self, mut counts: impl Iterator<Item = usize>, rows: usize) {
        let mut last = 0;
        for end in &mut self.ends {
            last += counts.next().unwrap_or(0);
            *end = last;
        }
        self.rows = rows;
    }

    /// The columns of a contact.
    pub(crate) fn columns(&self, contact: usize) -> Range<usize> {
        let end = |i: usize| self.ends.get(i).copied().unwrap_or(0);
        end(contact.wrapping_sub(1))..end(contact)
    }

    /// Unknowns of contacts.
    fn contact_unknowns(&self) -> usize {
        self.ends.last().copied().unwrap_or(0)
    }

    /// Factorises; `None` if a pivot vanishes or is no number. Of a matrix that is `symmetric` (and positive definite,
    /// but for rounding) what stands below the diagonal is not read.
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
            triangularise(
                rows,
                columns,
                [last, self.rows],
                reciprocals,
                order,
                symmetric,
            )?;
            let mut block = [[T::ZERO; D]; D];
            for (block, row) in block.iter_mut().zip(&*rows) {
                *block = own_columns(row, start)?;
            }
            let mut before = end;
            for (others, &until) in below.iter_mut().zip(self.ends.get(k + 1..)?) {
                for (column, row) in (before..until).zip(others) {
                    let own = own_columns_mut(row, start)?;
                    let (factors, first) = if symmetric {
                        let entry = |row: &Stacked<T, D, C, R>| {
                            row.contacts.as_flattened().get(column).copied()
                        };
                        (multiply(rows, entry, reciprocals), before)
                    } else {
                        (divide(own, &block, reciprocals), end)
                    };
                    keep(own, &factors, end - start);
                    subtract_rows(row, &factors, rows, first..last, 0..self.rows);
                }
                before = until;
            }
            for (column, row) in matrix.rows.iter_mut().enumerate().take(self.rows) {
                let own = own_columns_mut(row, start)?;
                let (factors, first) = if symmetric {
                    let entry = |row: &Stacked<T, D, C, R>| row.rows.get(column).copied();
                    (multiply(rows, entry, reciprocals), last)
                } else {
                    (divide(own, &block, reciprocals), end)
                };
                keep(own, &factors, end - start);
                // What stands before its own column is not read of a symmetric matrix.
                subtract_rows(row, &factors, rows, first..last, 0..self.rows);
            }
        }
        self.factorise_rows(&mut matrix.rows, symmetric)
    }

    /// Were all pivots positive?
    pub(crate) fn is_positive(&self) -> bool {
        let contacts = self.reciprocals.contacts.iter().enumerate();
        let mut contacts = contacts.flat_map(|(i, own)| own.iter().take(self.columns(i).len()));
        let mut rows = self.reciprocals.rows.iter().take(self.rows);
        contacts.all(|&pivot| pivot > T::ZERO) && rows.all(|&pivot| pivot > T::ZERO)
    }

    /// Eliminates among the joint rows.
    fn factorise_rows(
        &mut self,
        rows: &mut [Stacked<T, D, C, R>; R],
        symmetric: bool,
    ) -> Option<()> {
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
                let own = if symmetric {
                    source.get(i)?
                } else {
                    row.rows.get(k)?
                };
                let factor = *own * reciprocal;
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

    /// Solves for a right-hand side, which the solution replaces.
    #[inline(never)]
    pub(crate) fn solve(
        &self,
        matrix: &StackedMatrix<T, D, C, R>,
        b: &mut Stacked<T, D, C, R>,
    ) -> Option<()> {
        // Behind the last column there may be anything.
        let joints = b.rows.get_mut(..self.rows)?;
        let b = b.contacts.as_flattened_mut();
        let b = b.get_mut(..self.contact_unknowns())?;
        for (k, (rows, order)) in matrix.contacts.iter().zip(&self.order).enumerate() {
            let columns = self.columns(k);
            let own = b.get_mut(columns.clone())?;
            for (p, &taken) in order.iter().enumerate() {
                if p < taken && taken < own.len() {
                    own.swap(p, taken);
                }
            }
            for p in 0..columns.len() {
                let (done, rest) = b.split_at_mut_checked(columns.start + p)?;
                *rest.first_mut()? -= dot(rows.get(p)?.contacts.as_flattened(), done);
            }
        }
        for (k, &taken) in self.row_order.iter().enumerate().take(self.rows) {
            if k < taken && taken < joints.len() {
                joints.swap(k, taken);
            }
        }
        for (k, row) in matrix.rows.iter().enumerate().take(self.rows) {
            let (done, rest) = joints.split_at_mut_checked(k)?;
            *rest.first_mut()? -= dot(row.contacts.as_flattened(), b) + dot(&row.rows, done);
        }
        for (k, row) in matrix.rows.iter().enumerate().take(self.rows).rev() {
            let (head, solved) = joints.split_at_mut_checked(k + 1)?;
            let entry = head.last_mut()?;
            let rest = dot(row.rows.get(k + 1..)?, solved);
            *entry = (*entry - rest) * *self.reciprocals.rows.get(k)?;
        }
        for k in (0..C).rev() {
            let (rows, reciprocals) = (matrix.contacts.get(k)?, self.reciprocals.contacts.get(k)?);
            let columns = self.columns(k);
            for p in (0..columns.len()).rev() {
                let behind = columns.start + p + 1;
                let (head, solved) = b.split_at_mut_checked(behind)?;
                let entry = head.last_mut()?;
                let row = rows.get(p)?;
                let mut rest = dot(row.contacts.as_flattened().get(behind..)?, solved);
                if R > 0 {
                    rest += dot(&row.rows, joints);
                }
                *entry = (*entry - rest) * *reciprocals.get(p)?;
            }
        }
        Some(())
    }
}

#[cfg(test)]
mod tests;
