//! Factorisation `A = L D Lᵀ` of the symmetric block of one contact.

use crate::real::Real;

/// The factor `L D Lᵀ` of a block.
pub(crate) struct BlockFactor<T, const D: usize> {
    /// `L` below the diagonal; its diagonal of ones is not stored.
    lower: [[T; D]; D],
    /// Reciprocals of `D`.
    reciprocals: [T; D],
}

impl<T: Real, const D: usize> BlockFactor<T, D> {
    /// Factorises a block; `None` if a pivot is not positive, or NaN.
    #[inline]
    pub(crate) fn new(mut block: [[T; D]; D]) -> Option<Self> {
        let mut reciprocals = [T::ZERO; D];
        for (p, reciprocal) in reciprocals.iter_mut().enumerate() {
            let (above, below) = block.split_at_mut_checked(p + 1)?;
            let row = above.last()?;
            let pivot = *row.get(p)?;
            *reciprocal = T::ONE / pivot;
            let usable = pivot > T::ZERO && *reciprocal > T::ZERO;
            if !usable {
                return None;
            }
            for others in below {
                let factor = *others.get(p)? * *reciprocal;
                let (first, rest) = others.get_mut(p..)?.split_first_mut()?;
                *first = factor;
                for (other, &entry) in rest.iter_mut().zip(row.get(p + 1..)?) {
                    *other -= factor * entry;
                }
            }
        }
        Some(Self { lower: block, reciprocals })
    }

    /// `L⁻¹ x`
    #[inline]
    pub(crate) fn eliminate(&self, x: &mut [[T; D]; D]) {
        for (p, lower) in self.lower.iter().enumerate() {
            let (done, rest) = x.split_at_mut_checked(p).unwrap_or_default();
            let Some(row) = rest.first_mut() else { return };
            for (done, &factor) in done.iter().zip(lower) {
                subtract_row(row, factor, done);
            }
        }
    }

    /// `D⁻¹ x`
    #[inline]
    pub(crate) fn scale(&self, x: &mut [[T; D]; D]) {
        for (row, &reciprocal) in x.iter_mut().zip(&self.reciprocals) {
            *row = row.map(|entry| entry * reciprocal);
        }
    }

    /// `L⁻ᵀ x`
    #[inline]
    pub(crate) fn back_substitute(&self, x: &mut [[T; D]; D]) {
        for (p, lower) in self.lower.iter().enumerate().rev() {
            let (rows, solved) = x.split_at_mut_checked(p).unwrap_or_default();
            let Some(solved) = solved.first() else { return };
            for (row, &factor) in rows.iter_mut().zip(lower) {
                subtract_row(row, factor, solved);
            }
        }
    }
}

/// `y -= factor x`
#[inline]
pub(crate) fn subtract_row<T: Real, const D: usize>(y: &mut [T; D], factor: T, x: &[T; D]) {
    for (y, &x) in y.iter_mut().zip(x) {
        *y -= factor * x;
    }
}
