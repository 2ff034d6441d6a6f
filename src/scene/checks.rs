//! Checks and fingerprints of the numbers that a scene is given.

use crate::error::{Error, Input};
use crate::linalg::zip::zip3;
use crate::real::Real;
use core::sync::atomic::{Ordering::SeqCst, compiler_fence};
use nalgebra::{ComplexField, SMatrix};

/// Fingerprint of some numbers and of their index in the scene.
#[cfg_attr(target_os = "none", inline(never))]
pub(super) fn fingerprint<T: Real>(numbers: &[T], index: usize) -> u64 {
    let (chunks, rest) = numbers.as_chunks::<4>();
    let mut hashes = begin(index);
    for numbers in chunks {
        T::hash_four(&mut hashes, *numbers);
    }
    T::hash_four(&mut hashes, padded(rest));
    end(hashes)
}

/// Copies numbers and returns their [`fingerprint`].
pub(super) fn copy_and_hash<T: Real>(target: &mut [T], numbers: &[T], index: usize) -> u64 {
    let (chunks, rest) = numbers.as_chunks::<4>();
    let target = target.get_mut(..numbers.len()).unwrap_or_default();
    let (targets, last) = target.as_chunks_mut::<4>();
    let mut hashes = begin(index);
    for (target, numbers) in targets.iter_mut().zip(chunks) {
        T::hash_four(&mut hashes, *numbers);
        *target = *numbers;
        compiler_fence(SeqCst); // keeps the loop from becoming a `memcpy`, which takes longer
    }
    let mut last_four = [T::ZERO; 4];
    for (target, hashed, &number) in zip3(last, &mut last_four, rest) {
        (*target, *hashed) = (number, number);
        compiler_fence(SeqCst);
    }
    T::hash_four(&mut hashes, last_four);
    end(hashes)
}

/// Initial hashes for an index. They are not 0, which a number 0 would not change.
fn begin(index: usize) -> [u64; 4] {
    [u64::try_from(index).unwrap_or(0).wrapping_add(1); 4]
}

/// One hash of four.
fn end(hashes: [u64; 4]) -> u64 {
    hashes.into_iter().fold(0_u64, |sum, hash| {
        let product = (sum.rotate_left(5) ^ hash).wrapping_mul(0xd6e8_feb8_6659_fd93);
        // Without this the sign of the last number would change the highest bits alone, and two such bits cancel in a sum.
        product ^ (product >> 32)
    })
}

/// Up to three numbers, and zeros.
fn padded<T: Real>(rest: &[T]) -> [T; 4] {
    let mut numbers = [T::ZERO; 4];
    for (number, &x) in numbers.iter_mut().zip(rest) {
        *number = x;
    }
    numbers
}

/// Every entry of a matrix or vector of `R` rows is a number.
#[inline]
pub(crate) fn check_entries<T: Real, const R: usize>(entries: &[T], input: Input) -> Result<(), Error> {
    if are_finite(entries) { Ok(()) } else { Err(entry_not_finite::<T, R>(entries, input)) }
}

/// Every entry of a matrix or vector is a number.
#[inline]
pub(crate) fn check_finite<T: Real, const R: usize, const K: usize>(
    matrix: &SMatrix<T, R, K>,
    input: Input,
) -> Result<(), Error> {
    if are_finite(matrix.as_slice()) {
        Ok(())
    } else {
        Err(entry_not_finite::<T, R>(matrix.as_slice(), input))
    }
}

/// Names the first entry that is not a number, of a matrix of `R` rows.
#[cold]
fn entry_not_finite<T: Real, const R: usize>(entries: &[T], input: Input) -> Error {
    let index = entries.iter().position(|entry| !entry.is_finite());
    let index = index.unwrap_or(0);
    Error::NotFinite { input, row: index % R.max(1), column: index.checked_div(R).unwrap_or(0) }
}

/// Are all numbers finite? NaN or infinity in a sum makes the sum NaN or infinite, and times 0 these are NaN; any other number times 0 is 0.
fn are_finite<T: Real>(numbers: &[T]) -> bool {
    let (chunks, rest) = numbers.as_chunks::<4>();
    let mut gaps = T::ZERO;
    for &[a, b, c, d] in chunks {
        gaps += ((a + b) + (c + d)) * T::ZERO;
    }
    for &number in rest {
        gaps += number * T::ZERO;
    }
    // A sum of finite numbers may overflow.
    gaps == T::ZERO || numbers.iter().all(ComplexField::is_finite)
}

/// Is it finite, and symmetric to the bit?
pub(super) fn is_finite_and_symmetric<T: Real, const N: usize>(mass: &SMatrix<T, N, N>, n: usize) -> bool {
    let (columns, mut gaps) = (&mass.data.0, T::ZERO);
    for (j, column) in columns.iter().enumerate() {
        if j >= n {
            break; // a loop over the whole array, whose length is known, is faster
        }
        let diagonal = column.get(j).copied().unwrap_or(T::ZERO);
        gaps += diagonal * T::ZERO; // not 0 if it is not finite
        let below = column.get(j + 1..).unwrap_or_default();
        let others = columns.get(j + 1..n).unwrap_or_default();
        for (&below, other) in below.iter().zip(others) {
            let right = other.get(j).copied().unwrap_or(below);
            gaps += (below - right).abs(); // faster than a comparison of each pair
        }
    }
    gaps == T::ZERO
}

/// Checks whether the first `n` rows and columns of a mass matrix are finite and symmetric.
#[cold]
pub(super) fn check_mass<T: Real, const N: usize>(mass: &SMatrix<T, N, N>, n: usize) -> Result<(), Error> {
    for (column, entries) in mass.data.0.iter().enumerate().take(n) {
        if let Some(row) = entries.iter().take(n).position(|entry| !entry.is_finite()) {
            return Err(Error::NotFinite { input: Input::Mass, row, column });
        }
    }
    check_symmetric(mass, n)
}

/// Names the first of `M_ij` and `M_ji` that differ by more than the root of `eps`.
fn check_symmetric<T: Real, const N: usize>(mass: &SMatrix<T, N, N>, n: usize) -> Result<(), Error> {
    let diagonal = |i: usize| mass.get((i, i)).copied().unwrap_or(T::ZERO);
    for (j, column, row) in zip3(0..n, mass.column_iter(), mass.row_iter()) {
        for (k, &below, &right) in zip3(0..n, &column, &row).skip(j + 1) {
            if below == right {
                continue; // saves the roots
            }
            // Two roots, since the product of the diagonal entries may overflow.
            let [one, other] = [k, j].map(|i| diagonal(i).abs().square_root());
            if (below - right).abs() > T::EPSILON.square_root() * one * other {
                return Err(Error::MassNotSymmetric { row: k, column: j });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
