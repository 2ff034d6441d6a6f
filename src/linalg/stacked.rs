//! Vectors and matrices over the rows of contacts and the joint rows: `D` rows for each of up to `C` contacts, and up to `R` joint rows.

use crate::real::Real;

/// A vector with `D` entries for each contact and one for each joint row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stacked<T, const D: usize, const C: usize, const R: usize> {
    pub(crate) contacts: [[T; D]; C],
    pub(crate) rows: [T; R],
}

/// A square matrix over the same entries, row by row.
#[derive(Clone, Debug)]
pub(crate) struct StackedMatrix<T, const D: usize, const C: usize, const R: usize> {
    pub(crate) contacts: [[Stacked<T, D, C, R>; D]; C],
    pub(crate) rows: [Stacked<T, D, C, R>; R],
}

/// Numbers of contacts and joint rows in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Counts {
    pub(crate) contacts: usize,
    pub(crate) rows: usize,
}

impl<T, const D: usize, const C: usize, const R: usize> Stacked<T, D, C, R> {
    /// All entries.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &T> {
        self.contacts.as_flattened().iter().chain(&self.rows)
    }

    /// All entries, mutable.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut T> {
        let contacts = self.contacts.as_flattened_mut();
        contacts.iter_mut().chain(&mut self.rows)
    }

    /// The entries of the contacts and joint rows in use.
    pub(crate) fn in_use(&self, counts: Counts) -> impl Iterator<Item = &T> {
        let contacts = self.contacts.iter().take(counts.contacts).flatten();
        contacts.chain(self.rows.iter().take(counts.rows))
    }

    /// The entries of the contacts and joint rows in use, mutable.
    pub(crate) fn in_use_mut(&mut self, counts: Counts) -> impl Iterator<Item = &mut T> {
        let contacts = self.contacts.iter_mut().take(counts.contacts).flatten();
        contacts.chain(self.rows.iter_mut().take(counts.rows))
    }
}

impl<T: Real, const D: usize, const C: usize, const R: usize> Stacked<T, D, C, R> {
    /// All zeros.
    pub(crate) const fn zero() -> Self {
        Self { contacts: [[T::ZERO; D]; C], rows: [T::ZERO; R] }
    }

    /// Sets all entries to those of another. (Behind two references an assignment would call `memmove`.)
    #[inline]
    pub(crate) fn copy_from(&mut self, source: &Self) {
        self.contacts.copy_from_slice(&source.contacts);
        self.rows.copy_from_slice(&source.rows);
    }

    /// `start + step length`
    pub(crate) fn along(start: &Self, step: &Self, length: T) -> Self {
        let mut sum = *start;
        for (sum, &step) in sum.iter_mut().zip(step.iter()) {
            *sum += step * length;
        }
        sum
    }

    /// Are all entries finite?
    pub(crate) fn is_finite(&self) -> bool {
        self.iter().all(T::is_finite)
    }
}

impl<T: Real, const D: usize, const C: usize, const R: usize> StackedMatrix<T, D, C, R> {
    /// All zeros.
    pub(crate) const fn zero() -> Self {
        Self { contacts: [[Stacked::zero(); D]; C], rows: [Stacked::zero(); R] }
    }
}
