//! The resolvent `B = (I + W R)⁻¹` of the Delassus operator: all that depends on the penalties.
//!
//! `R` is `rho I` as in the note, or has one penalty a contact. A projection onto a cone does not
//! mind a factor of its own for each contact.

use crate::cholesky::axpy;
use crate::contact_space::{ContactMatrix, ContactVector, multiply_transposed, subtract_rows};
use crate::{Error, Real};

/// `Bᵀ = (I + R W)⁻¹`, with the penalties `rho_i` (kg) on the diagonal of `R`.
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

    /// `Bᵀ = (W + R⁻¹)⁻¹ R⁻¹` for the first `contacts` contacts.
    #[inline(never)]
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
        self.penalties = *penalties;
        let blocks = self.matrix.iter_mut().zip(delassus).zip(penalties);
        for (i, ((rows, sources), &rho)) in blocks.take(contacts).enumerate() {
            rows.as_flattened_mut()
                .copy_from_slice(sources.as_flattened());
            let compliance = T::ONE / rho;
            for (a, row) in rows.iter_mut().enumerate() {
                if let Some(entry) = row.get_mut(i).and_then(|block| block.get_mut(a)) {
                    *entry += compliance;
                }
            }
        }
        for k in 0..contacts {
            self.sweep(contacts, k).ok_or(Error::InvalidPenalty)?;
        }
        self.mirror(contacts).ok_or(Error::InvalidPenalty)
    }

    /// Sweeps contact `k` of the lower triangle. With `K = A_kk⁻¹` the blocks become
    /// `A_ij - A_ik K A_kj`, `A_ik K` and `-K`; once all contacts are swept, that is `-A⁻¹`.
    #[inline(never)]
    fn sweep(&mut self, contacts: usize, k: usize) -> Option<()> {
        // A_kj, of which the triangle has what is right of the diagonal in column k.
        let mut row: [ContactVector<T, D, C>; D] = *self.matrix.get(k)?;
        for i in k + 1..contacts {
            for (a, source) in self.matrix.get(i)?.iter().enumerate() {
                for (row, &entry) in row.iter_mut().zip(source.get(k)?) {
                    *row.get_mut(i)?.get_mut(a)? = entry;
                }
            }
        }
        // With A_kk = L U and y = L⁻¹ A_ki, of which U has the factor D: A_ij - y_i D⁻¹ y_j.
        let reciprocals = triangularise(&mut row, k, 0, contacts)?;
        if !reciprocals.iter().all(|&reciprocal| reciprocal > T::ZERO) {
            return None;
        }
        for (i, a) in (0..contacts).flat_map(|i| (0..D).map(move |a| (i, a))) {
            if i == k {
                continue;
            }
            let mut swept = [T::ZERO; D]; // y, and then A_ik A_kk⁻¹
            let mut factors = [T::ZERO; D];
            let targets = swept.iter_mut().zip(&mut factors);
            for ((y, factor), (row, &reciprocal)) in targets.zip(row.iter().zip(&reciprocals)) {
                *y = *row.get(i)?.get(a)?;
                *factor = *y * reciprocal;
            }
            let target = self.matrix.get_mut(i)?.get_mut(a)?;
            subtract_rows(target, &factors, &row, 0, (i + 1) * D);
            back_substitute(&row, k, &reciprocals, &mut swept)?;
            if i > k {
                *target.get_mut(k)? = swept;
            } else {
                for (row, swept) in self.matrix.get_mut(k)?.iter_mut().zip(swept) {
                    *row.get_mut(i)?.get_mut(a)? = swept;
                }
            }
        }
        for a in 0..D {
            // -A_kk⁻¹ e_a
            let mut swept = [T::ZERO; D];
            *swept.get_mut(a)? = -T::ONE;
            for (p, (row, &reciprocal)) in row.iter().zip(&reciprocals).enumerate() {
                let y = *swept.get(p)? * reciprocal;
                for (swept, &u) in swept
                    .get_mut(p + 1..)?
                    .iter_mut()
                    .zip(row.get(k)?.get(p + 1..)?)
                {
                    *swept -= u * y;
                }
            }
            back_substitute(&row, k, &reciprocals, &mut swept)?;
            for (row, swept) in self.matrix.get_mut(k)?.iter_mut().zip(swept) {
                *row.get_mut(k)?.get_mut(a)? = swept;
            }
        }
        Some(())
    }

    /// From the lower triangle of `-A⁻¹` to `A⁻¹ R⁻¹`.
    #[inline(never)]
    fn mirror(&mut self, contacts: usize) -> Option<()> {
        let scale = self.penalties.map(|rho| -T::ONE / rho);
        for i in 0..contacts {
            for a in 0..D {
                for j in 0..=i {
                    let block = self.matrix.get_mut(i)?.get_mut(a)?.get_mut(j)?;
                    let entries = *block;
                    for entry in block {
                        *entry *= *scale.get(j)?;
                    }
                    if j == i {
                        continue;
                    }
                    for (row, entry) in self.matrix.get_mut(j)?.iter_mut().zip(entries) {
                        *row.get_mut(i)?.get_mut(a)? = entry * *scale.get(i)?;
                    }
                }
            }
        }
        Some(())
    }

    /// `y = B x`
    #[inline]
    pub(crate) fn times(&self, x: &[[T; D]], y: &mut [[T; D]]) {
        multiply_transposed(&self.matrix, x, y);
    }
}

/// Gaussian elimination among the rows of contact `k`, which makes its diagonal block upper
/// triangular; from contact `first` to `last`. Gives the reciprocals of the pivots.
///
/// `None` if a pivot vanishes or is no number.
#[inline(never)]
fn triangularise<T: Real, const D: usize, const C: usize>(
    rows: &mut [ContactVector<T, D, C>; D],
    k: usize,
    first: usize,
    last: usize,
) -> Option<[T; D]> {
    let mut reciprocals = [T::ZERO; D];
    for (p, reciprocal) in reciprocals.iter_mut().enumerate() {
        let (above, below) = rows.split_at_mut_checked(p + 1)?;
        let pivot_row = above.last()?;
        let pivot = *pivot_row.get(k)?.get(p)?;
        let usable = pivot.abs() > T::ZERO;
        if !usable {
            return None;
        }
        *reciprocal = T::ONE / pivot;
        let source = pivot_row.get(first..last)?.as_flattened();
        for row in below {
            let factor = *row.get(k)?.get(p)? * *reciprocal;
            axpy(
                -factor,
                source,
                row.get_mut(first..last)?.as_flattened_mut(),
            );
        }
    }
    Some(reciprocals)
}

/// Solves `U x = y` in place for the upper triangle of the diagonal block of contact `k`.
fn back_substitute<T: Real, const D: usize, const C: usize>(
    rows: &[ContactVector<T, D, C>; D],
    k: usize,
    reciprocals: &[T; D],
    x: &mut [T; D],
) -> Option<()> {
    for (p, row) in rows.iter().enumerate().rev() {
        let (head, solved) = x.split_at_mut_checked(p + 1)?;
        let entry = head.last_mut()?;
        for (&u, &x) in row.get(k)?.get(p + 1..)?.iter().zip(&*solved) {
            *entry -= u * x;
        }
        *entry *= *reciprocals.get(p)?;
    }
    Some(())
}
