//! What a scene does with the numbers it is given: it checks them, and knows them again.

use crate::linalg::hints::{opaque, rolled};
use crate::{Error, Input, Real};
use nalgebra::SMatrix;

/// Fingerprint of some numbers and their place among others.
#[cfg_attr(target_os = "none", inline(never))]
pub(super) fn fingerprint<T: Real>(numbers: &[T], place: usize) -> u32 {
    let mut hash = u32::try_from(place).unwrap_or(0);
    for number in numbers {
        rolled();
        hash = number.hash(hash);
    }
    // Until here the sign of the last number moves the highest bit alone, and two such bits would cancel in a sum.
    (hash ^ (hash >> 15)).wrapping_mul(0x85eb_ca77)
}

/// Every entry of a matrix or vector is a number.
pub(crate) fn check_finite<T: Real, const R: usize, const K: usize>(
    matrix: &SMatrix<T, R, K>,
    input: Input,
) -> Result<(), Error> {
    for (column, entries) in matrix.data.0.iter().enumerate() {
        for (row, entry) in opaque(entries).iter().enumerate() {
            rolled();
            if !entry.is_finite() {
                return Err(Error::NotFinite { input, row, column });
            }
        }
    }
    Ok(())
}
