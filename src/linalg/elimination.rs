//! Gaussian elimination by contacts, kept so that more right-hand sides can be solved.
//!
//! A contact has up to `D` unknowns: as many rows in its place, and columns close to those of the
//! contacts before. Pivots are sought within the rows of a contact. The multipliers stay where
//! they have eliminated. Of a symmetric matrix they are the rows that eliminate, divided by their pivots
//! (`L D Lᵀ`): pivots stay on the diagonal, and the blocks above it are enough.

use crate::Real;
use crate::linalg::blocks::{ContactMatrix, ContactVector, subtract_rows};
use crate::linalg::cholesky::dot;
use crate::linalg::hints::rolled;
use core::array::from_fn;
use core::ops::Range;

/// Blocks `A_ij` of an eliminated matrix are its rows `matrix[i]` in `columns(j)`. Unused rows of a contact that has
/// unknowns are zero, except in blocks that are not read.
#[derive(Clone, Debug)]
pub(crate) struct Elimination<T, const D: usize, const C: usize> {
    /// Where the columns of each contact end.
    ends: [usize; C],
    /// Reciprocals of the pivots; 0 for a missing pivot of a contact that has others.
    reciprocals: ContactVector<T, D, C>,
    /// Which row of the contact was taken for each pivot.
    order: [[usize; D]; C],
}

impl<T: Real, const D: usize, const C: usize> Elimination<T, D, C> {
    pub(crate) const fn none() -> Self {
        Self {
            ends: [0; C],
            reciprocals: [[T::ZERO; D]; C],
            order: [[0; D]; C],
        }
    }

    /// Gives each contact its number of unknowns.
    pub(crate) fn lay_out(&mut self, mut counts: impl Iterator<Item = usize>) {
        let mut last = 0;
        for end in &mut self.ends {
            last += counts.next().unwrap_or(0);
            *end = last;
        }
    }

    /// The columns of a contact.
    pub(crate) fn columns(&self, contact: usize) -> Range<usize> {
        let end = |i: usize| self.ends.get(i).copied().unwrap_or(0);
        end(contact.wrapping_sub(1))..end(contact)
    }

    /// Factorises; `None` if a pivot vanishes or is no number. Of a matrix that is `symmetric` (and positive definite,
    /// but for rounding) blocks below the diagonal are not read.
    #[inline(never)]
    pub(crate) fn factorise(
        &mut self,
        matrix: &mut ContactMatrix<T, D, C>,
        symmetric: bool,
    ) -> Option<()> {
        let last = self.ends.last().copied().unwrap_or(0);
        for k in 0..C {
            let columns = self.columns(k);
            if columns.is_empty() {
                continue;
            }
            let (start, end) = (columns.start, columns.end);
            let (done, below) = matrix.split_at_mut_checked(k + 1)?;
            let rows = done.last_mut()?;
            let reciprocals = self.reciprocals.get_mut(k)?;
            let order = self.order.get_mut(k)?;
            triangularise(rows, columns, last, reciprocals, order, symmetric)?;
            let mut block = [[T::ZERO; D]; D];
            for (block, row) in block.iter_mut().zip(&*rows) {
                *block = *row.as_flattened().get(start..)?.first_chunk::<D>()?;
            }
            let mut before = end;
            for (others, &until) in below.iter_mut().zip(self.ends.get(k + 1..)?) {
                for (column, row) in (before..until).zip(others) {
                    rolled();
                    let own = row.as_flattened_mut().get_mut(start..)?;
                    let own = own.first_chunk_mut::<D>()?;
                    let (factors, first) = if symmetric {
                        let entry = |p: usize| rows.get(p)?.as_flattened().get(column).copied();
                        let entries: [T; D] = from_fn(|p| entry(p).unwrap_or(T::ZERO));
                        (multiply(entries, reciprocals), before)
                    } else {
                        (divide(own, &block, reciprocals), end)
                    };
                    for (p, (own, &factor)) in own.iter_mut().zip(&factors).enumerate() {
                        if start + p < end {
                            *own = factor;
                        }
                    }
                    subtract_rows(row, &factors, rows, first, last);
                }
                before = until;
            }
        }
        Some(())
    }

    /// Solves for a right-hand side, which the solution replaces.
    #[inline(never)]
    pub(crate) fn solve(&self, matrix: &ContactMatrix<T, D, C>, b: &mut [T]) -> Option<()> {
        // Behind the last column there may be anything.
        let b = b.get_mut(..self.ends.last().copied().unwrap_or(0))?;
        for (k, (rows, order)) in matrix.iter().zip(&self.order).enumerate() {
            let columns = self.columns(k);
            let own = b.get_mut(columns.clone())?;
            for (p, &taken) in order.iter().enumerate() {
                if p < taken && taken < own.len() {
                    rolled();
                    own.swap(p, taken);
                }
            }
            for p in 0..columns.len() {
                rolled();
                let (done, rest) = b.split_at_mut_checked(columns.start + p)?;
                *rest.first_mut()? -= dot(rows.get(p)?.as_flattened(), done);
            }
        }
        for k in (0..C).rev() {
            rolled();
            let (rows, reciprocals) = (matrix.get(k)?, self.reciprocals.get(k)?);
            let columns = self.columns(k);
            for p in (0..columns.len()).rev() {
                rolled();
                let behind = columns.start + p + 1;
                let (head, solved) = b.split_at_mut_checked(behind)?;
                let entry = head.last_mut()?;
                let row = rows.get(p)?.as_flattened().get(behind..)?;
                *entry = (*entry - dot(row, solved)) * *reciprocals.get(p)?;
            }
        }
        Some(())
    }
}

/// `x_p y_p`
#[inline]
fn multiply<T: Real, const D: usize>(mut x: [T; D], y: &[T; D]) -> [T; D] {
    for (x, &y) in x.iter_mut().zip(y) {
        *x *= y;
    }
    x
}

/// `x U⁻¹`, with a block that holds `U` above its diagonal, and the reciprocals of that.
#[inline]
fn divide<T: Real, const D: usize>(
    x: &[T; D],
    block: &[[T; D]; D],
    reciprocals: &[T; D],
) -> [T; D] {
    let mut quotient = *x;
    for (p, (row, &reciprocal)) in block.iter().zip(reciprocals).enumerate() {
        let mut factor = T::ZERO;
        if let Some(place) = quotient.get_mut(p) {
            *place *= reciprocal;
            factor = *place;
        }
        for (q, (x, &u)) in quotient.iter_mut().zip(row).enumerate() {
            if q > p {
                *x -= factor * u;
            }
        }
    }
    quotient
}

/// Eliminates among the rows of one contact: first in its own columns, then in those behind.
#[inline(never)]
fn triangularise<T: Real, const D: usize, const C: usize>(
    rows: &mut [ContactVector<T, D, C>; D],
    columns: Range<usize>,
    last: usize,
    reciprocals: &mut [T; D],
    order: &mut [usize; D],
    symmetric: bool,
) -> Option<()> {
    let count = columns.len();
    let mut block = [[T::ZERO; D]; D];
    for (block, row) in block.iter_mut().zip(&*rows) {
        *block = *row
            .as_flattened()
            .get(columns.start..)?
            .first_chunk::<D>()?;
    }
    *reciprocals = [T::ZERO; D];
    for (p, (reciprocal, taken)) in reciprocals.iter_mut().zip(order).enumerate().take(count) {
        rolled();
        // Rows that are not used have nothing to offer, being zero.
        let (mut largest, mut index) = (T::ZERO, p);
        let end = if symmetric { p + 1 } else { D };
        for i in p..end {
            rolled();
            let size = block.get(i)?.get(p)?.abs();
            if size > largest {
                (largest, index) = (size, i);
            }
        }
        *taken = index;
        if index != p && index < D {
            rows.swap(p, index);
            block.swap(p, index);
        }
        let source = *block.get(p)?;
        *reciprocal = T::ONE / *source.get(p)?;
        let usable = largest > T::ZERO && reciprocal.abs() > T::ZERO;
        if !usable {
            return None;
        }
        for i in p + 1..D {
            rolled();
            let row = block.get_mut(i)?;
            let factor = *row.get(p)? * *reciprocal;
            for (q, (entry, &source)) in row.iter_mut().zip(&source).enumerate() {
                if q > p {
                    *entry -= factor * source;
                }
            }
            *row.get_mut(p)? = factor;
        }
    }
    for (row, block) in rows.iter_mut().zip(&block).take(count) {
        rolled();
        let own = row.as_flattened_mut().get_mut(columns.start..)?;
        *own.first_chunk_mut::<D>()? = *block;
    }
    for (i, row) in block.iter_mut().enumerate() {
        for (p, factor) in row.iter_mut().enumerate() {
            if p >= i || i >= count {
                *factor = T::ZERO;
            }
        }
    }
    for k in columns.start + D..last.min(D * C) {
        rolled();
        let mut x = [T::ZERO; D];
        for (i, (row, factors)) in rows.iter_mut().zip(&block).enumerate() {
            if let Some(entry) = row.as_flattened_mut().get_mut(k) {
                for (&x, &factor) in x.iter().zip(factors).take(i) {
                    *entry -= factor * x;
                }
                if let Some(x) = x.get_mut(i) {
                    *x = *entry;
                }
            }
        }
    }
    Some(())
}

#[cfg(test)]
mod tests;
