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
    /// Positive infinity.
    const INFINITY: Self;

    /// Correctly rounded square root (IEEE 754).
    #[must_use]
    fn square_root(self) -> Self;

    /// Binary exponent `e` of a positive normal number, `2^e <= x < 2^(e+1)`; for a smaller number one less than that of
    /// the least normal number.
    #[doc(hidden)]
    #[must_use]
    fn exponent(self) -> i32;

    /// `2^exponent`, or the nearest power of two that is a normal number.
    #[doc(hidden)]
    #[must_use]
    fn power_of_two(exponent: i32) -> Self;

    /// The least number with all its digits.
    #[doc(hidden)]
    #[must_use]
    fn least_normal() -> Self;

    /// `2^s + 1`, with `s` half the digits: splits a number into halves.
    #[doc(hidden)]
    #[must_use]
    fn splitter() -> Self;

    /// Continues four running hashes with four numbers.
    #[doc(hidden)]
    fn hash_four(hashes: &mut [u64; 4], numbers: [Self; 4]);

    /// Continues the hash of a sequence of numbers with the bits of this one.
    #[doc(hidden)]
    #[must_use]
    fn hash(self, hash: u64) -> u64;

    /// Its bits.
    #[doc(hidden)]
    #[must_use]
    fn to_word(self) -> u64;

    /// The number of these bits.
    #[doc(hidden)]
    #[must_use]
    fn from_word(word: u64) -> Self;

    /// A small count.
    #[doc(hidden)]
    #[must_use]
    fn count(number: usize) -> Self;

    /// A constant of the algorithms, rounded to this type.
    #[must_use]
    fn literal(value: f64) -> Self;
}

/// Two running hashes by sums and rotations, of words of 32 bits: products take more registers than a Cortex-M has.
#[inline]
#[allow(clippy::cast_possible_truncation)]
fn hash_words([one, other, ..]: &mut [u64; 4], [a, b, c, d]: [f32; 4]) {
    for two in [[a, b], [c, d]] {
        for (hash, number) in [&mut *one, &mut *other].into_iter().zip(two) {
            let sum = (*hash as u32).rotate_right(5).wrapping_add(number.to_bits());
            let sums = ((*hash >> 32) as u32).rotate_right(11).wrapping_add(sum);
            *hash = u64::from(sums) << 32 | u64::from(sum);
        }
    }
}

/// Four running hashes by products: one alone would be waited for at each number.
#[inline]
fn hash_products(hashes: &mut [u64; 4], numbers: [f64; 4]) {
    for (hash, number) in hashes.iter_mut().zip(numbers) {
        *hash = number.hash(*hash);
    }
}

macro_rules! real {
    ($float:ident, $bits:ident, $hash_four:path, $sqrt:path) => {
        impl Real for $float {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const EPSILON: Self = $float::EPSILON;
            const INFINITY: Self = $float::INFINITY;

            #[inline]
            fn square_root(self) -> Self {
                $sqrt(self)
            }

            #[inline]
            #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)]
            fn exponent(self) -> i32 {
                let biased = self.to_bits() >> ($float::MANTISSA_DIGITS - 1);
                biased as i32 + 1 - $float::MAX_EXP
            }

            #[inline]
            #[allow(clippy::cast_sign_loss)]
            fn power_of_two(exponent: i32) -> Self {
                let exponent = exponent.clamp($float::MIN_EXP - 1, $float::MAX_EXP - 1);
                let biased = (exponent - 1 + $float::MAX_EXP) as $bits;
                Self::from_bits(biased << ($float::MANTISSA_DIGITS - 1))
            }

            #[inline]
            fn least_normal() -> Self {
                $float::MIN_POSITIVE
            }

            #[inline]
            #[allow(clippy::cast_possible_wrap)]
            fn splitter() -> Self {
                Self::power_of_two($float::MANTISSA_DIGITS.div_ceil(2) as i32) + 1.0
            }

            #[inline]
            fn hash_four(hashes: &mut [u64; 4], numbers: [Self; 4]) {
                $hash_four(hashes, numbers);
            }

            #[inline]
            fn to_word(self) -> u64 {
                u64::from(self.to_bits())
            }

            #[inline]
            #[allow(clippy::cast_possible_truncation)]
            fn from_word(word: u64) -> Self {
                Self::from_bits(word as $bits)
            }

            #[inline]
            #[allow(clippy::cast_possible_truncation)]
            fn hash(self, hash: u64) -> u64 {
                // The halves change places, so that the product mixes the upper one as well: no shift where words have 32 bits.
                (hash.rotate_left(32) ^ u64::from(self.to_bits())).wrapping_mul(0x9e37_79b9_7f4a_7c15)
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

#[cfg(not(feature = "hardware-sqrt"))]
real!(f32, u32, hash_words, libm::sqrtf);
#[cfg(feature = "hardware-sqrt")]
real!(f32, u32, hash_words, stiction_sqrt::sqrtf);
real!(f64, u64, hash_products, libm::sqrt);
