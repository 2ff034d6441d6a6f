//! Small scenes in sizes of more velocities: the others move by themselves.

use nalgebra::{SMatrix, SVector};
use stiction::Real;

/// A mass matrix with more velocities, each of the first mass: none is heavier than what there is.
pub(crate) fn mass<T: Real, const K: usize, const N: usize>(mass: &SMatrix<T, K, K>) -> SMatrix<T, N, N> {
    SMatrix::from_fn(|i, j| match mass.get((i, j)) {
        Some(entry) => *entry,
        None if i == j => mass[(0, 0)],
        None => T::ZERO,
    })
}

/// A Jacobian with more columns, of zeros.
pub(crate) fn jacobian<T: Real, const D: usize, const K: usize, const N: usize>(
    jacobian: &SMatrix<T, D, K>,
) -> SMatrix<T, D, N> {
    SMatrix::from_fn(|i, j| jacobian.get((i, j)).copied().unwrap_or(T::ZERO))
}

/// A vector with more entries, zeros.
pub(crate) fn vector<T: Real, const K: usize, const N: usize>(vector: SVector<T, K>) -> SVector<T, N> {
    SVector::from_fn(|i, _| vector.get(i).copied().unwrap_or(T::ZERO))
}
