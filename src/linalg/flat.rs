//! Stacked vectors and matrices by a flat index, which counts the rows of all contacts first and then the joint rows.

use crate::linalg::cholesky::axpy;
use crate::linalg::stacked::{Stacked, StackedMatrix};
use crate::real::Real;
use core::mem::swap;
use core::ops::Range;

/// Length from which [`axpy`] is faster than a loop in place.
const SHORT: usize = 8;

impl<T, const D: usize, const C: usize, const R: usize> Stacked<T, D, C, R> {
    /// The entry at a flat index.
    #[inline]
    pub(crate) fn at(&self, index: usize) -> Option<&T> {
        match index.checked_sub(D * C) {
            None => self.contacts.as_flattened().get(index),
            Some(row) => self.rows.get(row),
        }
    }

    /// The entry at a flat index, mutable.
    #[inline]
    pub(crate) fn at_mut(&mut self, index: usize) -> Option<&mut T> {
        match index.checked_sub(D * C) {
            None => self.contacts.as_flattened_mut().get_mut(index),
            Some(row) => self.rows.get_mut(row),
        }
    }

    /// The entries in a range of flat indices, those of contacts and those of joint rows.
    #[inline]
    fn pieces(&self, range: &Range<usize>) -> [&[T]; 2] {
        if R == 0 {
            let contacts = self.contacts.as_flattened().get(range.clone());
            return [contacts.unwrap_or_default(), &[]];
        }
        let [contacts, rows] = split::<D, C>(range);
        let contacts = self.contacts.as_flattened().get(contacts);
        [contacts, self.rows.get(rows)].map(Option::unwrap_or_default)
    }

    /// [`Self::pieces`], mutable.
    #[inline]
    fn pieces_mut(&mut self, range: &Range<usize>) -> [&mut [T]; 2] {
        if R == 0 {
            let contacts = self.contacts.as_flattened_mut().get_mut(range.clone());
            return [contacts.unwrap_or_default(), &mut []];
        }
        let [contacts, rows] = split::<D, C>(range);
        let contacts = self.contacts.as_flattened_mut().get_mut(contacts);
        [contacts, self.rows.get_mut(rows)].map(Option::unwrap_or_default)
    }
}

/// The parts of a range of flat indices among contacts and among joint rows.
#[inline]
fn split<const D: usize, const C: usize>(range: &Range<usize>) -> [Range<usize>; 2] {
    let (start, end, contacts) = (range.start, range.end.max(range.start), D * C);
    let behind = start.saturating_sub(contacts)..end.saturating_sub(contacts);
    [start.min(contacts)..end.min(contacts), behind]
}

impl<T: Copy, const D: usize, const C: usize, const R: usize> Stacked<T, D, C, R> {
    /// Exchanges two entries.
    #[inline]
    pub(crate) fn swap(&mut self, a: usize, b: usize) -> Option<()> {
        let (one, other) = (*self.at(a)?, *self.at(b)?);
        (*self.at_mut(a)?, *self.at_mut(b)?) = (other, one);
        Some(())
    }
}

impl<T: Real, const D: usize, const C: usize, const R: usize> Stacked<T, D, C, R> {
    /// `x · y` over a range of flat indices.
    #[inline]
    pub(crate) fn dot(&self, other: &Self, range: Range<usize>) -> T {
        let ([x, x_rows], [y, y_rows]) = (self.pieces(&range), other.pieces(&range));
        let mut sum = T::ZERO;
        for (&x, &y) in x.iter().zip(y) {
            sum += x * y;
        }
        for (&x, &y) in x_rows.iter().zip(y_rows) {
            sum += x * y;
        }
        sum
    }

    /// `x -= factor y` over a range of flat indices.
    #[inline]
    pub(crate) fn subtract(&mut self, factor: T, other: &Self, range: Range<usize>) {
        let ([x, x_rows], [y, y_rows]) = (self.pieces_mut(&range), other.pieces(&range));
        if y.len() < SHORT {
            for (x, &y) in x.iter_mut().zip(y) {
                *x -= factor * y;
            }
        } else {
            axpy(-factor, y, x);
        }
        for (x, &y) in x_rows.iter_mut().zip(y_rows) {
            *x -= factor * y;
        }
    }

    /// The largest magnitude of an entry in a range of flat indices.
    pub(crate) fn max(&self, range: Range<usize>) -> T {
        let mut largest = T::ZERO;
        for x in self.pieces(&range).into_iter().flatten() {
            let size = x.abs();
            if size > largest {
                largest = size;
            }
        }
        largest
    }

    /// The flat index of the entry of largest magnitude in a range.
    #[inline]
    pub(crate) fn index_of_max(&self, range: Range<usize>) -> usize {
        let (mut largest, mut best) = (T::ZERO, range.start);
        for index in range {
            let size = self.at(index).copied().unwrap_or(T::ZERO).abs();
            if size > largest {
                (largest, best) = (size, index);
            }
        }
        best
    }
}

impl<T: Copy, const D: usize, const C: usize, const R: usize> StackedMatrix<T, D, C, R> {
    /// The row at a flat index.
    #[inline]
    pub(crate) fn row(&self, index: usize) -> Option<&Stacked<T, D, C, R>> {
        match index.checked_sub(D * C) {
            None => self.contacts.as_flattened().get(index),
            Some(row) => self.rows.get(row),
        }
    }

    /// The row at a flat index, mutable.
    #[inline]
    pub(crate) fn row_mut(&mut self, index: usize) -> Option<&mut Stacked<T, D, C, R>> {
        match index.checked_sub(D * C) {
            None => self.contacts.as_flattened_mut().get_mut(index),
            Some(row) => self.rows.get_mut(row),
        }
    }

    /// All rows.
    #[inline]
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Stacked<T, D, C, R>> {
        self.contacts.as_flattened().iter().chain(&self.rows)
    }

    /// All rows, mutable.
    #[inline]
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut Stacked<T, D, C, R>> {
        let contacts = self.contacts.as_flattened_mut();
        contacts.iter_mut().chain(&mut self.rows)
    }

    /// Exchanges two rows.
    #[inline]
    pub(crate) fn swap(&mut self, a: usize, b: usize) -> Option<()> {
        let mut row = *self.row(a)?;
        swap(&mut row, self.row_mut(b)?);
        *self.row_mut(a)? = row;
        Some(())
    }
}
