//! What a scene does with the numbers it is given: it checks them, and knows them again.

use crate::linalg::hints::{opaque, rolled};
use crate::{Error, Input, Real};
use nalgebra::SMatrix;

/// Fingerprint of some numbers and their place among others, in four running hashes: one alone would be waited for at each
/// number.
#[cfg_attr(target_os = "none", inline(never))]
pub(super) fn fingerprint<T: Real>(numbers: &[T], place: usize) -> u32 {
    let seed = u32::try_from(place).unwrap_or(0);
    let mut hashes = [seed; 4];
    let (chunks, rest) = numbers.as_chunks::<4>();
    for numbers in chunks {
        rolled();
        for (hash, number) in hashes.iter_mut().zip(numbers) {
            *hash = number.hash(*hash);
        }
    }
    for (hash, number) in hashes.iter_mut().zip(rest) {
        *hash = number.hash(*hash);
    }
    let [first, others @ ..] = hashes;
    others
        .into_iter()
        .fold(mixed(first), |sum, hash| mixed(sum.rotate_left(5) ^ hash))
}

/// Until here the sign of the last number moves the highest bit alone, and two such bits would cancel in a sum.
const fn mixed(hash: u32) -> u32 {
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
