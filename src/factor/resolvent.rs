//! The resolvent `B = (I + rho W)⁻¹` of the Delassus operator. Only it depends on the penalty `rho`.

use crate::error::Error;
use crate::factor::Factor;
use crate::factor::penalty::is_usable;
use crate::linalg::block_factor::{BlockFactor, subtract_row};
use crate::linalg::blocks::{ContactMatrix, ContactVector, block, multiply_transposed, set_block, transpose};
use crate::linalg::zip::zip3;
use crate::real::Real;
use heapless::Vec;

/// `B = (I + rho W)⁻¹` and its penalty `rho` (kg).
#[derive(Clone, Debug)]
pub(crate) struct Resolvent<T, const D: usize, const C: usize> {
    pub(crate) penalty: T,
    matrix: ContactMatrix<T, D, C>,
}

impl<T: Real, const D: usize, const C: usize> Resolvent<T, D, C> {
    pub(crate) const fn empty() -> Self {
        Self { penalty: T::ZERO, matrix: [[[[T::ZERO; D]; C]; D]; C] }
    }

    /// Computes `B = (W + I / rho)⁻¹ / rho` for the contacts of a factor.
    #[inline(never)]
    pub(crate) fn compute<const N: usize>(
        &mut self,
        factor: &Factor<T, N, D, C>,
        penalty: T,
    ) -> Result<(), Error> {
        if !is_usable(penalty) {
            return Err(Error::InvalidPenalty);
        }
        self.penalty = penalty;
        let (contacts, inverse_penalty) = (factor.contacts(), T::ONE / penalty);
        let blocks = zip3(0..contacts, &mut self.matrix, &factor.delassus().contacts);
        for (i, rows, sources) in blocks {
            for (a, row, source) in zip3(0..D, rows, sources) {
                for (block, source) in row.iter_mut().zip(source).take(i + 1) {
                    *block = *source;
                }
                if let Some(entry) = row.get_mut(i).and_then(|block| block.get_mut(a)) {
                    *entry += inverse_penalty;
                }
            }
        }
        for k in 0..contacts {
            self.eliminate(contacts, k).ok_or(Error::InvalidPenalty)?;
        }
        self.mirror(contacts).ok_or(Error::InvalidPenalty)
    }

    /// Eliminates contact `k` from the lower triangle of `A` (a step of Gauss-Jordan's method). With `K = A_kk⁻¹` the blocks become
    /// `A_ij - A_ik K A_kj`, `A_ik K` and `-K`. After the last contact they are `-A⁻¹`.
    #[inline(never)]
    #[allow(clippy::comparison_chain)] // a `match` of the ordering is longer code
    fn eliminate(&mut self, contacts: usize, k: usize) -> Option<()> {
        let factor = BlockFactor::new(block(&self.matrix, k, k)?)?;
        // y_i = L⁻¹ A_ki (the lower triangle has A_ik in its place if i > k), and y_k = -L⁻¹.
        let mut row = Vec::<[[T; D]; D], C>::new();
        for i in 0..contacts {
            let mut y = if i < k {
                block(&self.matrix, k, i)?
            } else if i > k {
                transpose(&block(&self.matrix, i, k)?)
            } else {
                diagonal(-T::ONE)
            };
            factor.eliminate(&mut y);
            row.push(y).ok()?;
        }
        for (i, y) in row.iter().enumerate() {
            let mut factors = *y;
            factor.scale(&mut factors);
            if i != k && factors != [[T::ZERO; D]; D] {
                let rows = self.matrix.get_mut(i)?;
                let factors = transpose(&factors);
                for (j, y) in row.get(..=i)?.iter().enumerate() {
                    if j != k {
                        subtract(rows, j, &factors, y);
                    }
                }
            }
            factor.back_substitute(&mut factors);
            if i > k {
                set_block(&mut self.matrix, i, k, &transpose(&factors))?;
            } else {
                set_block(&mut self.matrix, k, i, &factors)?;
            }
        }
        Some(())
    }

    /// Replaces the lower triangle of `-A⁻¹` by all of `A⁻¹ / rho`; `None` if an entry is not finite.
    #[inline(never)]
    fn mirror(&mut self, contacts: usize) -> Option<()> {
        let scale = -T::ONE / self.penalty;
        for i in 0..contacts {
            for j in 0..=i {
                let block = times(scale, &block(&self.matrix, i, j)?);
                if !block.as_flattened().iter().all(T::is_finite) {
                    return None;
                }
                if j != i {
                    set_block(&mut self.matrix, j, i, &transpose(&block))?;
                }
                set_block(&mut self.matrix, i, j, &block)?;
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

/// `A_ij -= factors y`, with the blocks `A_i` in `rows`.
#[inline]
fn subtract<T: Real, const D: usize, const C: usize>(
    rows: &mut [ContactVector<T, D, C>; D],
    j: usize,
    factors: &[[T; D]; D],
    y: &[[T; D]; D],
) {
    for (row, factors) in rows.iter_mut().zip(factors) {
        if let Some(block) = row.get_mut(j) {
            let mut sums = *block;
            for (&factor, y) in factors.iter().zip(y) {
                subtract_row(&mut sums, factor, y);
            }
            *block = sums;
        }
    }
}

/// `x A`
#[inline]
fn times<T: Real, const D: usize>(x: T, block: &[[T; D]; D]) -> [[T; D]; D] {
    block.map(|row| row.map(|entry| x * entry))
}

/// `x I`
#[inline]
fn diagonal<T: Real, const D: usize>(x: T) -> [[T; D]; D] {
    let mut block = [[T::ZERO; D]; D];
    for (p, row) in block.iter_mut().enumerate() {
        if let Some(entry) = row.get_mut(p) {
            *entry = x;
        }
    }
    block
}
