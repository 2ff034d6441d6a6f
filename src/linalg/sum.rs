//! Running sums of products: plain numbers, magnitudes, both, and sums in twice the digits ([`super::dot2`]). One loop serves all of them.

use crate::real::Real;

/// A running sum of products.
pub(crate) trait Sum<T>: Copy {
    /// Adds `x y`.
    fn add(&mut self, x: T, y: T);
}

impl<T: Real> Sum<T> for T {
    #[inline]
    fn add(&mut self, x: T, y: T) {
        *self += x * y;
    }
}

/// The sum of the magnitudes of its terms.
#[derive(Clone, Copy)]
pub(crate) struct Size<T>(pub(crate) T);

impl<T: Real> Sum<T> for Size<T> {
    #[inline]
    fn add(&mut self, x: T, y: T) {
        self.0 += (x * y).abs();
    }
}

/// A sum, and the sum of the magnitudes of its terms.
#[derive(Clone, Copy)]
pub(crate) struct SizedSum<T> {
    pub(crate) sum: T,
    pub(crate) size: T,
}

impl<T: Real> SizedSum<T> {
    /// The sum of one number.
    pub(crate) fn of(number: T) -> Self {
        Self { sum: number, size: number.abs() }
    }
}

impl<T: Real> Sum<T> for SizedSum<T> {
    #[inline]
    fn add(&mut self, x: T, y: T) {
        let product = x * y;
        self.sum += product;
        self.size += product.abs();
    }
}
