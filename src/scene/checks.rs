//! What a scene does with the numbers it is given: it checks them, and knows them again.

use crate::error::{Error, Input};
use crate::real::Real;
use nalgebra::SMatrix;

/// Fingerprint of some numbers and their place among others.
#[cfg_attr(target_os = "none", inline(never))]
pub(super) fn fingerprint<T: Real>(numbers: &[T], place: usize) -> u64 {
    let (chunks, rest) = numbers.as_chunks::<4>();
    hashed(chunks.iter(), rest, place)
}

/// Copies numbers and returns their fingerprint: a loop for each would take half as many instructions more.
#[cfg_attr(target_os = "none", inline(never))]
pub(super) fn copy_and_hash<T: Real>(target: &mut [T], numbers: &[T], place: usize) -> u64 {
    let (chunks, rest) = numbers.as_chunks::<4>();
    let (targets, last) = target.as_chunks_mut::<4>();
    for (target, &number) in last.iter_mut().zip(rest) {
        *target = number;
    }
    let pairs = targets.iter_mut().zip(chunks);
    let copied = pairs.map(|(target, numbers)| {
        *target = *numbers;
        numbers
    });
    hashed(copied, rest, place)
}

/// Hash of numbers in chunks and what is left of them, in four running hashes: one alone would be waited for at each number.
#[inline]
fn hashed<'a, T: Real>(chunks: impl Iterator<Item = &'a [T; 4]>, rest: &[T], place: usize) -> u64 {
    // Not 0, which zeros would leave as it is.
    let mut hashes = [u64::try_from(place).unwrap_or(0).wrapping_add(1); 4];
    for numbers in chunks {
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

/// Until here the sign of the last number moves the highest bits alone, and two such bits would cancel in a sum.
const fn mixed(hash: u64) -> u64 {
    (hash ^ (hash >> 32)).wrapping_mul(0xd6e8_feb8_6659_fd93)
}

/// Every entry of a matrix or vector is a number.
#[inline]
pub(crate) fn check_finite<T: Real, const R: usize, const K: usize>(
    matrix: &SMatrix<T, R, K>,
    input: Input,
) -> Result<(), Error> {
    match not_finite(matrix.as_slice()) {
        None => Ok(()),
        Some(index) => Err(Error::NotFinite {
            input,
            row: index % R.max(1),
            column: index.checked_div(R).unwrap_or(0),
        }),
    }
}

/// Which of them is the first that is not a number? `0 x` is 0 for a number, and for no other: four sums say sooner than a
/// comparison for each whether there is one.
#[cfg_attr(target_os = "none", inline(never))]
fn not_finite<T: Real>(numbers: &[T]) -> Option<usize> {
    let mut sums = [T::ZERO; 4];
    let (chunks, rest) = numbers.as_chunks::<4>();
    for numbers in chunks {
        for (sum, &number) in sums.iter_mut().zip(numbers) {
            *sum += number * T::ZERO;
        }
    }
    for (sum, &number) in sums.iter_mut().zip(rest) {
        *sum += number * T::ZERO;
    }
    if sums == [T::ZERO; 4] {
        return None;
    }
    let mut numbers = numbers.iter();
    numbers.position(|number| !number.is_finite())
}

/// Is it symmetric to the bit? An error if `M_ij` and `M_ji` differ by more than the root of `eps`.
pub(super) fn check_symmetric<T: Real, const N: usize>(
    mass: &SMatrix<T, N, N>,
) -> Result<bool, Error> {
    let (columns, mut is_symmetric) = (&mass.data.0, true);
    let diagonal = |i: usize| mass.get((i, i)).copied().unwrap_or(T::ZERO);
    for (j, column) in columns.iter().enumerate() {
        let (Some(lower), Some(others)) = (column.get(j..), columns.get(j..)) else {
            continue;
        };
        for (k, (&lower, other)) in lower.iter().zip(others).enumerate() {
            let upper = other.get(j).copied().unwrap_or(lower);
            if lower == upper {
                continue; // as a rule, and without a root
            }
            let row = j + k;
            is_symmetric = false;
            let [one, other] = [row, j].map(|i| diagonal(i).abs().square_root()); // whose product may overflow
            if (lower - upper).abs() > T::EPSILON.square_root() * one * other {
                return Err(Error::MassNotSymmetric { row, column: j });
            }
        }
    }
    Ok(is_symmetric)
}

#[cfg(test)]
mod tests;
