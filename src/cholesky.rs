//! Root-free dense Cholesky factorisation `A = L D Lᵀ` in place, on row-major storage.
//!
//! `L` has a unit diagonal; the reciprocal of `D` stands in its place, so that no solve divides
//! and no square root is taken. (With roots, a change of units by an odd power of two would change
//! mantissas; without, it changes exponents only.) Only the lower triangle is read and written,
//! and sums run in one fixed order on every machine.

use crate::Real;

/// Scalar product over the common length, in four running sums.
#[inline]
pub(crate) fn dot<T: Real>(x: &[T], y: &[T]) -> T {
    let length = x.len().min(y.len());
    let (xs, x_rest) = x.get(..length).unwrap_or(x).as_chunks::<4>();
    let (ys, y_rest) = y.get(..length).unwrap_or(y).as_chunks::<4>();
    let mut sums = [T::ZERO; 4];
    for (x, y) in xs.iter().zip(ys) {
        add_products(&mut sums, x, y);
    }
    let rest = x_rest.iter().zip(y_rest);
    total(sums) + rest.fold(T::ZERO, |sum, (&x, &y)| sum + x * y)
}

/// Adds the products of four pairs to four running sums.
#[inline]
pub(crate) fn add_products<T: Real>(sums: &mut [T; 4], x: &[T; 4], y: &[T; 4]) {
    for ((sum, &x), &y) in sums.iter_mut().zip(x).zip(y) {
        *sum += x * y;
    }
}

/// The sum of four running sums.
#[inline]
pub(crate) fn total<T: Real>([a, b, c, d]: [T; 4]) -> T {
    (a + b) + (c + d)
}

/// `y += a x` over the common length.
#[inline]
pub(crate) fn axpy<T: Real>(a: T, x: &[T], y: &mut [T]) {
    for (y, &x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// Factorises the leading `n × n` block in place; row `i` starts at `i * stride`.
///
/// Fails with the row of the first pivot that is not above `threshold` times the diagonal entry
/// it is what is left of.
pub(crate) fn factorise<T: Real>(
    a: &mut [T],
    stride: usize,
    n: usize,
    threshold: T,
) -> Result<(), usize> {
    for i in 0..n {
        let (done, rest) = a.split_at_mut_checked(i * stride).ok_or(i)?;
        let (row, after) = rest.split_at_mut_checked(i).ok_or(i)?;
        let diagonal = after.first_mut().ok_or(i)?;
        // Row i of L D: entry j needs the entries before it.
        for (j, other) in done.chunks_exact(stride).enumerate() {
            let (head, tail) = row.split_at_mut_checked(j).ok_or(i)?;
            let entry = tail.first_mut().ok_or(i)?;
            *entry -= dot(head, other);
        }
        // Row i of L, and what is left of the diagonal.
        let mut pivot = *diagonal;
        for (j, (entry, other)) in row.iter_mut().zip(done.chunks_exact(stride)).enumerate() {
            let scaled = *entry * other.get(j).copied().unwrap_or(T::ZERO);
            pivot -= *entry * scaled;
            *entry = scaled;
        }
        // A NaN is no pivot either.
        let usable = pivot > threshold * *diagonal && pivot > T::ZERO;
        if !usable {
            return Err(i);
        }
        *diagonal = T::ONE / pivot;
    }
    Ok(())
}

/// Solves `L y = b` in place.
pub(crate) fn solve_lower<T: Real>(l: &[T], stride: usize, x: &mut [T]) {
    for (i, row) in l.chunks_exact(stride).take(x.len()).enumerate() {
        if let Some((done, [entry, ..])) = x.split_at_mut_checked(i) {
            *entry -= dot(row, done);
        }
    }
}

/// Multiplies by `D⁻¹` in place.
pub(crate) fn scale_by_reciprocal<T: Real>(l: &[T], stride: usize, x: &mut [T]) {
    for (i, (entry, row)) in x.iter_mut().zip(l.chunks_exact(stride)).enumerate() {
        *entry *= row.get(i).copied().unwrap_or(T::ZERO);
    }
}

/// Solves `Lᵀ x = y` in place.
pub(crate) fn solve_upper<T: Real>(l: &[T], stride: usize, mut x: &mut [T]) {
    while let Some((entry, rest)) = x.split_last_mut() {
        if let Some(row) = l.get(rest.len() * stride..) {
            axpy(-*entry, row, rest);
        }
        x = rest;
    }
}

#[cfg(test)]
mod tests;
