//! Vectors, and norms that neither overflow nor vanish.

use crate::real::Real;
use nalgebra::{ArrayStorage, SVector};

/// A vector of zeros in a constant.
pub(crate) const fn zeros<T: Real, const K: usize>() -> SVector<T, K> {
    SVector::from_array_storage(ArrayStorage([[T::ZERO; K]; 1]))
}

/// Euclidean norm; a planar contact (one tangent) needs no square root.
#[inline]
pub(crate) fn norm<T: Real>(tangent: &[T]) -> T {
    match tangent {
        [] => T::ZERO,
        [only] => only.abs(),
        more => square(more).square_root(),
    }
}

/// Square of the Euclidean norm.
#[inline]
pub(crate) fn square<T: Real>(x: &[T]) -> T {
    x.iter().fold(T::ZERO, |sum, &x| sum + x * x)
}

/// A quotient of norms in which 0/0 is 0, and whatever is not a number is infinite.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn quotient<T: Real>(numerator: T, denominator: T) -> T {
    if numerator == T::ZERO && denominator.is_finite() {
        T::ZERO
    } else if numerator.is_finite() && denominator.is_finite() {
        numerator / denominator
    } else {
        T::INFINITY
    }
}

/// `(sqrt(residual) + sqrt(noise)) / sqrt(size)`, of squares: what rounding may hide of an error adds to it.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn root_sum<T: Real>(residual: T, noise: T, size: T) -> T {
    let error = quotient(residual, size).square_root();
    if noise == T::ZERO {
        return error;
    }
    error + quotient(noise, size).square_root()
}

/// A power of two that brings the largest of some numbers near 1, so that their squares neither
/// overflow nor vanish.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn unit<T: Real>(largest: T) -> T {
    if largest > T::ZERO && largest.is_finite() {
        T::power_of_two(-largest.exponent())
    } else {
        T::ONE
    }
}

/// The largest of a number and of some sizes; sizes that are not numbers do not count.
#[inline]
pub(crate) fn larger<T: Real>(mut largest: T, values: &[T], scale: T) -> T {
    for &value in values {
        let size = (value * scale).abs();
        if size > largest {
            largest = size;
        }
    }
    largest
}

/// The larger of two numbers; the second if the first is none. (`max` would take four times as many instructions.)
#[inline]
pub(crate) fn at_least<T: Real>(number: T, least: T) -> T {
    if number > least { number } else { least }
}

/// Half an `eps` for each operation that a term takes part in.
pub(crate) fn precision<T: Real>(operations: usize) -> T {
    T::EPSILON * T::count(operations) * T::literal(0.5)
}
