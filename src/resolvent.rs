//! The resolvent `B = (I + W R)⁻¹` of the Delassus operator: all that depends on the penalties.
//!
//! `R` is `rho I` as in the note, or has one penalty a contact. A projection onto a cone does not
//! mind a factor of its own for each contact.

use crate::cholesky::{axpy, factorise};
use crate::contact_space::{ContactMatrix, ContactVector, mirror, multiply};
use crate::{Error, Real};

/// `B = (I + W R)⁻¹`, with the penalties `rho_i` (kg) on the diagonal of `R`.
#[derive(Clone, Debug)]
pub(crate) struct Resolvent<T, const D: usize, const C: usize> {
    pub(crate) penalties: [T; C],
    pub(crate) matrix: ContactMatrix<T, D, C>,
}

impl<T: Real, const D: usize, const C: usize> Resolvent<T, D, C> {
    pub(crate) const fn empty() -> Self {
        Self {
            penalties: [T::ZERO; C],
            matrix: [[[[T::ZERO; D]; C]; D]; C],
        }
    }

    /// `B = R⁻¹ (W + R⁻¹)⁻¹` for the first `contacts` contacts, by the Cholesky factor of `W + R⁻¹`.
    pub(crate) fn compute(
        &mut self,
        delassus: &ContactMatrix<T, D, C>,
        contacts: usize,
        penalties: &[T; C],
    ) -> Result<(), Error> {
        let usable = |&rho: &T| rho > T::ZERO && rho.is_finite();
        if !penalties.iter().all(usable) {
            return Err(Error::InvalidPenalty);
        }
        let (rows, stride) = (contacts * D, D * C);
        let blocks = self.matrix.iter_mut().zip(delassus).zip(penalties);
        for (i, ((rows, sources), &rho)) in blocks.take(contacts).enumerate() {
            for (a, (row, source)) in rows.iter_mut().zip(sources).enumerate() {
                *row = *source;
                let diagonal = row.get_mut(i).and_then(|block| block.get_mut(a));
                if let Some(entry) = diagonal {
                    *entry += T::ONE / rho;
                }
            }
        }
        let flat = self.matrix.as_flattened_mut().as_flattened_mut();
        let flat = flat.as_flattened_mut();
        factorise(flat, stride, rows, T::ZERO).map_err(|_| Error::InvalidPenalty)?;
        invert(flat, stride, rows);
        mirror(flat, stride, rows);
        for (rows, &rho) in self.matrix.iter_mut().zip(penalties) {
            for entry in rows.as_flattened_mut().as_flattened_mut() {
                *entry /= rho;
            }
        }
        self.penalties = *penalties;
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
