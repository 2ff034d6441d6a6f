//! The number types of the kernel: `f32` and `f64`.

use nalgebra::RealField;

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// A floating-point type the kernel can compute with: `f32` or `f64`.
///
/// It adds to [`nalgebra::RealField`] what a constant constructor needs (associated constants)
/// and one square root that is the same, bit for bit, on every machine. Sealed: no other type
/// implements it.
pub trait Real: RealField + Copy + sealed::Sealed {
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// Distance from 1 to the next larger number.
    const EPSILON: Self;

    /// Correctly rounded square root (IEEE 754).
    #[must_use]
    fn square_root(self) -> Self;

    /// The binary exponent `e` of a positive number, `2^e <= x < 2^(e+1)`.
    #[must_use]
    fn exponent(self) -> i32;

    /// `2^exponent`.
    #[must_use]
    fn power_of_two(exponent: i32) -> Self;

    /// A small count.
    #[must_use]
    fn count(number: usize) -> Self;

    /// A constant of the algorithms, rounded to this type.
    #[must_use]
    fn literal(value: f64) -> Self;
}

macro_rules! real {
    ($float:ident, $sqrt:path, $ilogb:path, $scalbn:path) => {
        impl Real for $float {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const EPSILON: Self = $float::EPSILON;

            #[inline]
            fn square_root(self) -> Self {
                $sqrt(self)
            }

            #[inline]
            fn exponent(self) -> i32 {
                $ilogb(self)
            }

            #[inline]
            fn power_of_two(exponent: i32) -> Self {
                $scalbn(1.0, exponent)
            }

            #[inline]
            #[allow(clippy::cast_precision_loss)]
            fn count(number: usize) -> Self {
                number as Self
            }

            #[inline]
            #[allow(clippy::cast_possible_truncation)]
            fn literal(value: f64) -> Self {
                value as Self
            }
        }
    };
}

real!(f32, libm::sqrtf, libm::ilogbf, libm::scalbnf);
real!(f64, libm::sqrt, libm::ilogb, libm::scalbn);
