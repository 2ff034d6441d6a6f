//! Root-free dense Cholesky factorisation `A = Lᵀ D L` in place, on row-major storage.
//!
//! `L` is lower triangular with a unit diagonal; the reciprocal of `D` stands in its place, so
//! that no solve divides and no square root is taken. (With roots, a change of units by an odd
//! power of two would change mantissas; without, it changes exponents only.) Only the lower
//! triangle is read and written, and sums run in one fixed order on every machine.
//!
//! Elimination runs from the last row to the first. Where the rows are the joints of a robot, its
//! base first, that leaves the zeros of the mass matrix zero (R. Featherstone, *Efficient
//! factorization of the joint-space inertia matrix for branched kinematic trees*, 2005), and rows
//! are not added where they are multiplied by zero.

use crate::Real;
use core::hint::black_box;

/// All of a slice, of a length that the compiler does not know: loops over dofs or contacts that it
/// unrolls are several times as large and hardly faster.
#[inline]
pub(crate) fn opaque<T>(slice: &[T]) -> &[T] {
    slice.get(..black_box(slice.len())).unwrap_or(slice)
}

/// Scalar product over the common length, in four running sums.
#[inline(never)]
pub(crate) fn dot<T: Real>(x: &[T], y: &[T]) -> T {
    let length = x.len().min(y.len());
    let (xs, x_rest) = x.get(..length).unwrap_or(x).as_chunks::<4>();
    let (ys, y_rest) = y.get(..length).unwrap_or(y).as_chunks::<4>();
    let mut sums = [T::ZERO; 4];
    for (x, y) in xs.iter().zip(ys) {
        for ((sum, &x), &y) in sums.iter_mut().zip(x).zip(y) {
            *sum += x * y;
        }
    }
    let rest = x_rest.iter().zip(y_rest);
    let [a, b, c, d] = sums;
    (a + b) + (c + d) + rest.fold(T::ZERO, |sum, (&x, &y)| sum + x * y)
}

/// `y += a x` over the common length.
#[inline(never)]
pub(crate) fn axpy<T: Real>(a: T, x: &[T], y: &mut [T]) {
    let length = x.len().min(y.len());
    let (xs, x_rest) = x.get(..length).unwrap_or(x).as_chunks::<4>();
    let (ys, y_rest) = y.split_at_mut_checked(length & !3).unwrap_or_default();
    for (y, x) in ys.as_chunks_mut::<4>().0.iter_mut().zip(xs) {
        for (y, &x) in y.iter_mut().zip(x) {
            *y += a * x;
        }
    }
    for (y, &x) in y_rest.iter_mut().zip(x_rest) {
        *y += a * x;
    }
}

/// Factorises the leading `n × n` block in place; row `i` starts at `i * stride`.
///
/// Fails with the row of the first pivot, from the last row on, that is not above its floor (zero
/// where `floors` has none).
#[inline(never)]
pub(crate) fn factorise<T: Real>(
    a: &mut [T],
    stride: usize,
    n: usize,
    floors: &[T],
) -> Result<(), usize> {
    for k in (0..n).rev() {
        let (above, rest) = a.split_at_mut_checked(k * stride).ok_or(k)?;
        let (row, rest) = rest.split_at_mut_checked(k).ok_or(k)?;
        let pivot = rest.first_mut().ok_or(k)?;
        let floor = floors.get(k).copied().unwrap_or(T::ZERO);
        // A NaN is no pivot either.
        let usable = *pivot > floor && *pivot > T::ZERO;
        if !usable {
            return Err(k);
        }
        let reciprocal = T::ONE / *pivot;
        *pivot = reciprocal;
        // What is left of the rows above. Entry i of this row is last needed for row i.
        for i in (0..k).rev() {
            let head = row.get_mut(..=i).unwrap_or_default();
            let entry = head.last().copied().unwrap_or(T::ZERO);
            if entry == T::ZERO {
                continue;
            }
            let scaled = entry * reciprocal;
            if let Some(target) = above.get_mut(i * stride..) {
                axpy(-scaled, head, target);
            }
            if let Some(entry) = head.last_mut() {
                *entry = scaled;
            }
        }
    }
    Ok(())
}

/// Solves `Lᵀ y = b` in place.
#[inline(never)]
pub(crate) fn solve_upper<T: Real>(l: &[T], stride: usize, mut x: &mut [T]) {
    while let Some((entry, rest)) = x.split_last_mut() {
        if let Some(row) = l.get(rest.len() * stride..) {
            axpy(-*entry, row, rest);
        }
        x = rest;
    }
}

/// Solves `Lᵀ y = b` in place, for `K` right-hand sides side by side.
#[inline(never)]
pub(crate) fn solve_upper_block<T: Real, const K: usize>(
    l: &[T],
    stride: usize,
    mut x: &mut [[T; K]],
) {
    while let Some((entry, rest)) = x.split_last_mut() {
        if *entry != [T::ZERO; K] {
            let row = l.get(rest.len() * stride..).unwrap_or_default();
            for (x, &l) in rest.iter_mut().zip(row) {
                for (x, &entry) in x.iter_mut().zip(&*entry) {
                    *x -= l * entry;
                }
            }
        }
        x = rest;
    }
}

/// Multiplies by `D⁻¹` in place.
#[inline(never)]
pub(crate) fn scale_by_reciprocal<T: Real>(l: &[T], stride: usize, x: &mut [T]) {
    for (entry, &reciprocal) in x.iter_mut().zip(l.iter().step_by(stride + 1)) {
        *entry *= reciprocal;
    }
}

/// Solves `L x = y` in place.
#[inline(never)]
pub(crate) fn solve_lower<T: Real>(l: &[T], stride: usize, x: &mut [T]) {
    for i in 1..x.len() {
        if let (Some((done, [entry, ..])), Some(row)) =
            (x.split_at_mut_checked(i), l.get(i * stride..))
        {
            *entry -= dot(row, done);
        }
    }
}

/// Solves `A x = b` in place.
pub(crate) fn solve<T: Real>(l: &[T], stride: usize, x: &mut [T]) {
    solve_upper(l, stride, x);
    scale_by_reciprocal(l, stride, x);
    solve_lower(l, stride, x);
}

#[cfg(test)]
mod tests;
