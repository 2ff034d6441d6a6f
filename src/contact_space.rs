//! Vectors and matrices over the contacts: one block of `D` rows a contact, room for `C` contacts.

use crate::Real;
use crate::cholesky::{add_products, total};

/// A vector in contact space.
pub(crate) type ContactVector<T, const D: usize, const C: usize> = [[T; D]; C];

/// A square matrix in contact space, row by row.
pub(crate) type ContactMatrix<T, const D: usize, const C: usize> = [[ContactVector<T, D, C>; D]; C];

/// `y = A x` for the first `contacts` contacts; the `D` rows of a contact share the reading of `x`.
#[inline]
pub(crate) fn multiply<T: Real, const D: usize, const C: usize>(
    matrix: &ContactMatrix<T, D, C>,
    contacts: usize,
    x: &ContactVector<T, D, C>,
    y: &mut ContactVector<T, D, C>,
) {
    let x = x.get(..contacts).unwrap_or_default().as_flattened();
    let (x_chunks, x_rest) = x.as_chunks::<4>();
    for (y, rows) in y.iter_mut().zip(matrix).take(contacts) {
        let rows = rows.each_ref().map(|row| {
            let row = row.as_flattened();
            row.get(..x.len()).unwrap_or(row).as_chunks::<4>()
        });
        let mut sums = [[T::ZERO; 4]; D];
        for (k, x) in x_chunks.iter().enumerate() {
            for (sums, (chunks, _)) in sums.iter_mut().zip(&rows) {
                if let Some(chunk) = chunks.get(k) {
                    add_products(sums, chunk, x);
                }
            }
        }
        for ((y, sums), (_, rest)) in y.iter_mut().zip(sums).zip(rows) {
            let rest = rest.iter().zip(x_rest);
            *y = total(sums) + rest.fold(T::ZERO, |sum, (&a, &x)| sum + a * x);
        }
    }
}

/// Copies the lower triangle of the leading `n × n` block to the upper one.
pub(crate) fn mirror<T: Real>(a: &mut [T], stride: usize, n: usize) {
    for i in 1..n {
        let Some((above, rest)) = a.split_at_mut_checked(i * stride) else {
            return;
        };
        for (row, &entry) in above.chunks_exact_mut(stride).zip(rest.iter()) {
            if let Some(mirrored) = row.get_mut(i) {
                *mirrored = entry;
            }
        }
    }
}
