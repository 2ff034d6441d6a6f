//! Norms, quotients of norms, and units in which squares neither overflow nor vanish.

use crate::real::Real;
use nalgebra::{ArrayStorage, SVector};

/// A vector of zeros, `const`.
pub(crate) const fn zeros<T: Real, const K: usize>() -> SVector<T, K> {
    SVector::from_array_storage(ArrayStorage([[T::ZERO; K]; 1]))
}

/// Adds numbers, up to the end of the shorter list.
#[inline]
pub(crate) fn add<T: Real>(sums: &mut [T], terms: &[T]) {
    for (sum, &term) in sums.iter_mut().zip(terms) {
        *sum += term;
    }
}

/// Euclidean norm. A single entry needs no square root.
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

/// A quotient of norms: 0/0 is 0, and NaN or infinity in either becomes infinity.
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

/// `(sqrt(residual) + sqrt(noise)) / sqrt(size)`: the relative error of a residual with a bound on its rounding. All three are squares.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn root_sum<T: Real>(residual: T, noise: T, size: T) -> T {
    let error = quotient(residual, size).square_root();
    if noise == T::ZERO {
        return error;
    }
    error + quotient(noise, size).square_root()
}

/// A power of two that brings the largest of some numbers near 1. Then no square overflows, and none of a large number vanishes.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn unit<T: Real>(largest: T) -> T {
    if largest > T::ZERO && largest.is_finite() { T::power_of_two(-largest.exponent()) } else { T::ONE }
}

/// The largest of the number `largest` and the magnitudes of `values` times `scale`. NaN does not count.
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

/// The larger of two numbers, `least` if `number` is NaN. (`max` would take four times as many instructions.)
#[inline]
pub(crate) fn at_least<T: Real>(number: T, least: T) -> T {
    if number > least { number } else { least }
}

/// Relative rounding bound of a term that takes part in this many operations: half an `eps` each.
pub(crate) fn rounding_bound<T: Real>(operations: usize) -> T {
    T::EPSILON * T::count(operations) * T::literal(0.5)
}
