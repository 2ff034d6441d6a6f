//! The resolvent `B = (I + rho W)⁻¹` of the Delassus operator: all that depends on the penalty.

use crate::cholesky::{axpy, factorise};
use crate::contact_space::{ContactMatrix, ContactVector, mirror, multiply};
use crate::{Error, Real};

/// `B = (I + rho W)⁻¹`, symmetric, with the `rho` it belongs to.
#[derive(Clone, Debug)]
pub(crate) struct Resolvent<T, const D: usize, const C: usize> {
    penalty: T,
    pub(crate) matrix: ContactMatrix<T, D, C>,
}

impl<T: Real, const D: usize, const C: usize> Resolvent<T, D, C> {
    pub(crate) const fn empty() -> Self {
        Self {
            penalty: T::ONE,
            matrix: [[[[T::ZERO; D]; C]; D]; C],
        }
    }

    pub(crate) const fn penalty(&self) -> T {
        self.penalty
    }

    /// Inverts `I + rho W` for the first `contacts` contacts, by its Cholesky factor.
    pub(crate) fn compute(
        &mut self,
        delassus: &ContactMatrix<T, D, C>,
        contacts: usize,
        penalty: T,
    ) -> Result<(), Error> {
        if !(penalty > T::ZERO && penalty.is_finite()) {
            return Err(Error::InvalidPenalty);
        }
        let (rows, stride) = (contacts * D, D * C);
        let matrix = self.matrix.as_flattened_mut();
        let pairs = matrix.iter_mut().zip(delassus.as_flattened());
        for (i, (row, source)) in pairs.take(rows).enumerate() {
            let entries = row.as_flattened_mut().iter_mut().zip(source.as_flattened());
            for (j, (entry, &w)) in entries.take(i + 1).enumerate() {
                let unit = if i == j { T::ONE } else { T::ZERO };
                *entry = unit + penalty * w;
            }
        }
        let flat = matrix.as_flattened_mut().as_flattened_mut();
        factorise(flat, stride, rows, T::ZERO).map_err(|_| Error::InvalidPenalty)?;
        invert(flat, stride, rows);
        mirror(flat, stride, rows);
        self.penalty = penalty;
        Ok(())
    }

    /// `y_i = (B x)_i` for the first `contacts` contacts.
    #[inline]
    pub(crate) fn times(
        &self,
        contacts: usize,
        x: &ContactVector<T, D, C>,
        y: &mut ContactVector<T, D, C>,
    ) {
        multiply(&self.matrix, contacts, x, y);
    }
}

/// Replaces `L D Lᵀ` as [`factorise`] leaves it by the lower triangle of its inverse.
fn invert<T: Real>(a: &mut [T], stride: usize, n: usize) {
    // Row i of L⁻¹ is -(row i of L without its diagonal) times the rows of L⁻¹ above.
    for i in 0..n {
        let Some((done, row)) = a.split_at_mut_checked(i * stride) else {
            return;
        };
        for (k, above) in done.chunks_exact(stride).enumerate() {
            if let Some((head, [entry, ..])) = row.split_at_mut_checked(k) {
                axpy(-*entry, above, head);
                *entry = -*entry;
            }
        }
    }
    // Row i of L⁻ᵀ D⁻¹ L⁻¹ gathers the rows of L⁻¹ from i on.
    for i in 0..n {
        let Some((row, below)) = a
            .get_mut(i * stride..n * stride)
            .and_then(|rows| rows.split_at_mut_checked(stride))
        else {
            return;
        };
        let Some((head, [diagonal, ..])) = row.split_at_mut_checked(i) else {
            return;
        };
        for entry in head.iter_mut() {
            *entry *= *diagonal;
        }
        for (k, other) in below.chunks_exact(stride).enumerate() {
            let (Some(&entry), Some(&reciprocal)) = (other.get(i), other.get(i + 1 + k)) else {
                return;
            };
            axpy(entry * reciprocal, other, head);
            *diagonal += entry * reciprocal * entry;
        }
    }
}
