//! LU factorisation with complete pivoting of a matrix that may be singular: it tells the rank, and solves with the matrix and with its
//! transpose.
//!
//! `P A Q = L U` with as many pivots as `A` has rank. Equations without a pivot are left out. Unknowns without one are free, and
//! chosen so that the solution is the shortest: an orthonormal basis of the null space stands where they had their columns.

use crate::linalg::stacked::{Stacked, StackedMatrix};
use crate::real::Real;
use core::ops::Range;

/// A factorised matrix of some rows and columns, as many as there are contact rows and joint rows at most.
#[derive(Clone, Debug)]
pub(crate) struct Lu<T, const D: usize, const C: usize, const R: usize> {
    matrix: StackedMatrix<T, D, C, R>,
    reciprocals: Stacked<T, D, C, R>,
    /// Which row and which column of `A` stands at each place.
    rows: Stacked<usize, D, C, R>,
    columns: Stacked<usize, D, C, R>,
    size: usize,
    rank: usize,
}

impl<T: Real, const D: usize, const C: usize, const R: usize> Lu<T, D, C, R> {
    /// All zeros, without rows and columns.
    pub(crate) const fn zero() -> Self {
        Self {
            matrix: StackedMatrix::zero(),
            reciprocals: Stacked::zero(),
            rows: Stacked {
                contacts: [[0; D]; C],
                rows: [0; R],
            },
            columns: Stacked {
                contacts: [[0; D]; C],
                rows: [0; R],
            },
            size: 0,
            rank: 0,
        }
    }

    /// Has so many rows and columns from now on, of zeros.
    pub(crate) fn begin(&mut self, size: usize) {
        self.size = size;
        for (place, (row, column)) in self
            .rows
            .iter_mut()
            .zip(self.columns.iter_mut())
            .enumerate()
        {
            (*row, *column) = (place, place);
        }
    }

    /// An entry, to be filled in.
    pub(crate) fn entry_mut(&mut self, row: usize, column: usize) -> Option<&mut T> {
        self.matrix.row_mut(row)?.at_mut(column)
    }

    pub(crate) const fn size(&self) -> usize {
        self.size
    }

    pub(crate) const fn rank(&self) -> usize {
        self.rank
    }

    /// Factorises what was filled in; what is left once no entry exceeds the floor counts as zero.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn factorise(&mut self, floor: T) -> Option<()> {
        let size = self.size;
        let mut largest = (floor, None);
        for (i, row) in self.matrix.iter_mut().enumerate().take(size) {
            note_largest(row, i, 0..size, &mut largest);
        }
        while let (_, Some(row)) = largest {
            let k = self.rank;
            let column = self.matrix.row(row)?.largest(k..size);
            self.bring_up(k, row, column)?;
            let source = *self.matrix.row(k)?;
            let reciprocal = T::ONE / *source.at(k)?;
            *self.reciprocals.at_mut(k)? = reciprocal;
            largest = (floor, None);
            let others = self.matrix.iter_mut().enumerate().take(size).skip(k + 1);
            for (i, row) in others {
                let factor = *row.at(k)? * reciprocal;
                *row.at_mut(k)? = factor;
                if factor != T::ZERO {
                    row.subtract(factor, &source, k + 1..size);
                }
                note_largest(row, i, k + 1..size, &mut largest);
            }
            self.rank += 1;
        }
        self.find_null_space()
    }

    /// Exchanges a row and a column with those in the next place.
    fn bring_up(&mut self, k: usize, row: usize, column: usize) -> Option<()> {
        if row != k {
            self.matrix.swap(k, row)?;
            self.rows.swap(k, row)?;
        }
        if column != k {
            for row in self.matrix.iter_mut().take(self.size) {
                row.swap(k, column)?;
            }
            self.columns.swap(k, column)?;
        }
        Some(())
    }

    /// Puts an orthonormal basis of the null space in the columns without a pivot.
    #[cold]
    #[inline(never)]
    fn find_null_space(&mut self) -> Option<()> {
        let (size, rank) = (self.size, self.rank);
        for c in rank..size {
            let mut null = Stacked::<T, D, C, R>::zero();
            for (i, row) in self.matrix.iter_mut().enumerate().take(rank) {
                *null.at_mut(i)? = -*row.at(c)?;
            }
            self.back_substitute(&mut null)?;
            *null.at_mut(c)? = T::ONE;
            // Twice is enough (Kahan, Parlett).
            for _ in 0..2 {
                self.leave_null_space(&mut null, c)?;
            }
            let scale = T::ONE / null.dot(&null, 0..size).square_root();
            for (i, row) in self.matrix.iter_mut().enumerate().take(size) {
                *row.at_mut(c)? = *null.at(i)? * scale;
            }
        }
        Some(())
    }

    /// A vector of the basis of the null space, in the order of the unknowns; `None` if there are no more.
    pub(crate) fn null_vector(&self, index: usize) -> Option<Stacked<T, D, C, R>> {
        let column = self.rank + index;
        if column >= self.size {
            return None;
        }
        let mut null = Stacked::zero();
        for (i, &place) in self.columns.iter().enumerate().take(self.size) {
            *null.at_mut(place)? = *self.matrix.row(i)?.at(column)?;
        }
        Some(null)
    }

    /// Takes from `x` what lies in the null space, as far as its basis is known up to column `end`.
    fn leave_null_space(&self, x: &mut Stacked<T, D, C, R>, end: usize) -> Option<()> {
        for c in self.rank..end {
            let mut share = T::ZERO;
            for (i, x) in x.iter().enumerate().take(self.size) {
                share += *x * *self.matrix.row(i)?.at(c)?;
            }
            for (i, x) in x.iter_mut().enumerate().take(self.size) {
                *x -= share * *self.matrix.row(i)?.at(c)?;
            }
        }
        Some(())
    }

    /// `U x = y` in place, with the pivots that there are.
    fn back_substitute(&self, x: &mut Stacked<T, D, C, R>) -> Option<()> {
        for i in (0..self.rank).rev() {
            let known = self.matrix.row(i)?.dot(x, i + 1..self.rank);
            let unknown = x.at_mut(i)?;
            *unknown = (*unknown - known) * *self.reciprocals.at(i)?;
        }
        Some(())
    }

    /// The shortest solution of the equations with a pivot, and the largest of what is left of the others.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn solve(&self, b: &Stacked<T, D, C, R>) -> Option<(Stacked<T, D, C, R>, T)> {
        let mut x = Stacked::zero();
        let mut left = T::ZERO;
        for (i, &place) in self.rows.iter().enumerate().take(self.size) {
            let known = self.matrix.row(i)?.dot(&x, 0..i.min(self.rank));
            let rest = *b.at(place)? - known;
            if i < self.rank {
                *x.at_mut(i)? = rest;
            } else {
                left = left.max(rest.abs());
            }
        }
        self.back_substitute(&mut x)?;
        self.leave_null_space(&mut x, self.size)?;
        let mut ordered = Stacked::zero();
        for (&place, &x) in self.columns.iter().zip(x.iter()).take(self.size) {
            *ordered.at_mut(place)? = x;
        }
        Some((ordered, left))
    }

    /// The transpose of [`Self::solve`].
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn solve_transposed(&self, c: &Stacked<T, D, C, R>) -> Option<Stacked<T, D, C, R>> {
        let mut y = Stacked::zero();
        for (y, &place) in y.iter_mut().zip(self.columns.iter()).take(self.size) {
            *y = *c.at(place)?;
        }
        self.leave_null_space(&mut y, self.size)?;
        for i in 0..self.rank {
            let known = *y.at(i)? * *self.reciprocals.at(i)?;
            *y.at_mut(i)? = known;
            y.subtract(known, self.matrix.row(i)?, i + 1..self.rank);
        }
        for i in (0..self.rank).rev() {
            let known = *y.at(i)?;
            y.subtract(known, self.matrix.row(i)?, 0..i);
        }
        let mut ordered = Stacked::zero();
        for (&place, &y) in self.rows.iter().zip(y.iter()).take(self.rank) {
            *ordered.at_mut(place)? = y;
        }
        Some(ordered)
    }
}

/// Notes a row that has a larger entry in some columns than all before.
#[inline]
fn note_largest<T: Real, const D: usize, const C: usize, const R: usize>(
    row: &Stacked<T, D, C, R>,
    place: usize,
    columns: Range<usize>,
    largest: &mut (T, Option<usize>),
) {
    let size = row.max(columns);
    if size > largest.0 {
        *largest = (size, Some(place));
    }
}
