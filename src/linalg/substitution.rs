//! Backward and forward substitution with the factor `A = Lᵀ D⁻¹ L` of [`crate::linalg::cholesky`].

use crate::linalg::cholesky::BLOCK;
use crate::real::Real;
use heapless::Vec;

/// Asserts in tests that a block was computed. `None` is a wrong index, an error of this file.
#[inline]
fn found(all: Option<()>) {
    debug_assert!(all.is_some(), "an index is out of bounds");
}

/// The first `n` rows and unknowns, or a block if that is more: behind `n` both are zero.
#[inline]
fn used<'a, T, const N: usize>(
    l: &'a [[T; N]; N],
    x: &'a mut [T; N],
    n: usize,
) -> Option<(&'a [[T; N]], &'a mut [T])> {
    let count = if N < BLOCK { n } else { n.max(BLOCK) };
    Some((l.get(..count)?, x.get_mut(..count)?))
}

/// Solves `Lᵀ D⁻¹ y = b` in place, for `n` unknowns.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn solve_upper<T: Real, const N: usize>(l: &[[T; N]; N], x: &mut [T; N], n: usize) {
    let Some((l, x)) = used(l, x, n) else { return };
    let mut end = n;
    while end > 0 {
        if N < BLOCK {
            found(upper_block::<T, N, 1>(l, x, end - 1, end));
            end -= 1;
        } else {
            let first = end.saturating_sub(BLOCK);
            found(upper_block::<T, N, BLOCK>(l, x, first, end));
            end = first;
        }
    }
}

/// Computes the unknowns `first..end` of a block of `K` unknowns from `first` on. Those from `end` on are known.
#[inline]
fn upper_block<T: Real, const N: usize, const K: usize>(
    l: &[[T; N]],
    x: &mut [T],
    first: usize,
    end: usize,
) -> Option<()> {
    let (here, known) = x.get_mut(first..)?.split_first_chunk_mut::<K>()?;
    let (rows, below) = l.get(first..)?.split_first_chunk::<K>()?;
    let mut sums = *here;
    for (k, found) in below.iter().zip(&*known).enumerate().rev() {
        let (row, known) = found;
        let entry = *known * *row.get(first + K + k)?;
        for (sum, &l) in sums.iter_mut().zip(row.get(first..)?.first_chunk::<K>()?) {
            *sum -= entry * l;
        }
    }
    for (c, row) in rows.iter().enumerate().rev() {
        let row = row.get(first..)?.first_chunk::<K>()?;
        let unknown = here.get_mut(c)?;
        if first + c < end {
            *unknown = *sums.get(c)?;
        }
        let entry = *unknown * *row.get(c)?;
        for (sum, &l) in sums.iter_mut().zip(row).take(c) {
            *sum -= entry * l;
        }
    }
    Some(())
}

/// A row of `D⁻¹ y` for `K` right-hand sides.
pub(crate) struct Scaled<'a, T, const N: usize, const K: usize> {
    /// Index of the row.
    pub(crate) index: usize,
    /// The row, with an entry for each right-hand side.
    pub(crate) entry: [T; K],
    /// The row of `L` with the same index.
    row: &'a [T; N],
}

/// Solves `Lᵀ D⁻¹ y = b` for `K` right-hand sides. `envelope` has the row of the last nonzero entry of each column of `L`.
/// Appends the nonzero rows of `D⁻¹ y` to `scaled`, from the last to the first.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn solve_upper_block<'a, T: Real, const N: usize, const K: usize>(
    l: &'a [[T; N]; N],
    (envelope, n): (&[usize; N], usize),
    b: &[[T; K]; N],
    y: &mut [[T; K]; N],
    scaled: &mut Vec<Scaled<'a, T, N, K>, N>,
) {
    for index in (0..n).rev() {
        let (Some(row), Some(&last)) = (l.get(index), envelope.get(index)) else { break };
        let (Some(b), Some(y)) = (b.get(index), y.get_mut(index)) else { break };
        let mut sums = *b;
        // Rows behind `last` have no entry in this column.
        let mut known = scaled.as_slice();
        if known.first().is_some_and(|row| row.index > last) {
            let near = known.iter().rev().take_while(|row| row.index <= last);
            known = known.split_at_checked(known.len() - near.count()).unwrap_or_default().1;
        }
        for Scaled { entry, row, .. } in known {
            let l = row.get(index).copied().unwrap_or(T::ZERO);
            for (sum, &entry) in sums.iter_mut().zip(entry) {
                *sum -= l * entry;
            }
        }
        *y = sums;
        if sums != [T::ZERO; K]
            && let Some(&reciprocal) = row.get(index)
        {
            let entry = sums.map(|sum| sum * reciprocal);
            // `scaled` has room for all rows.
            let _ = scaled.push(Scaled { index, entry, row });
        }
    }
}

/// Solves `L x = y` in place, for `n` unknowns.
pub(crate) fn solve_lower<T: Real, const N: usize>(l: &[[T; N]; N], x: &mut [T; N], n: usize) {
    let (mut next, end) = (0, n);
    while next < end {
        if N < BLOCK {
            found(lower_block::<T, N, 1>(l, x, next, next));
            next += 1;
        } else {
            let first = next.min(N - BLOCK); // behind `n` are zeros
            found(lower_block::<T, N, BLOCK>(l, x, first, next));
            next = first + BLOCK;
        }
    }
}

/// Computes the unknowns from `next` on of a block of `K` unknowns from `first` on. Those before `next` are known.
#[inline]
fn lower_block<T: Real, const N: usize, const K: usize>(
    l: &[[T; N]; N],
    x: &mut [T; N],
    first: usize,
    next: usize,
) -> Option<()> {
    let (known, here) = x.split_at_mut_checked(first)?;
    let here = here.first_chunk_mut::<K>()?;
    let rows = l.get(first..)?.first_chunk::<K>()?;
    let before = rows.each_ref().map(|row| row.get(..first).unwrap_or_default());
    let mut sums = *here;
    for (k, &known) in known.iter().enumerate() {
        for (sum, row) in sums.iter_mut().zip(before) {
            *sum -= *row.get(k)? * known;
        }
    }
    for (c, row) in rows.iter().enumerate() {
        let row = row.get(first..)?.first_chunk::<K>()?;
        let mut sum = *sums.get(c)?;
        for (&l, &unknown) in row.iter().zip(&*here).take(c) {
            sum -= l * unknown;
        }
        if first + c >= next {
            *here.get_mut(c)? = sum * *row.get(c)?;
        }
    }
    Some(())
}
