//! Expected impulses beside `|r0|`, see [`crate::guide::error`]: `|stop|`, which stops the motion, and `carried`, which momenta ask for.

use crate::linalg::blocks::diagonal_of;
use crate::linalg::sum::Size;
use crate::linalg::vector::{at_least, larger, square, unit};
use crate::linalg::zip::{zip3, zip5};
use crate::real::Real;
use crate::scene::Scene;
use crate::sets::{ContactSet, Sets};
use nalgebra::{ComplexField, SVector};

/// Least denominator of the error, as a share of the impulse that would stop the motion.
pub(crate) const SHARE: f64 = 1e-2;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Scene<T, N, D, C, R, S>
{
    /// `|stop|` (N·s), [`SHARE`] of the impulse that would stop the free velocity `free`.
    pub(crate) fn stopping_impulse(&self, sets: &[ContactSet<T, D>], free: &[T; N]) -> T {
        let mut speeds = [[T::ZERO; D]; C];
        let mut largest = T::ZERO;
        for (i, contact, support, set, speeds) in
            zip5(0..C, self.contacts(), self.supports(), sets, &mut speeds)
        {
            let mut sizes = <[T; D]>::from(without_gap(&contact.offset).abs()).map(Size);
            support.add_product((&contact.jacobian.data.0, self.velocities()), free, &mut sizes);
            *speeds = self.scaled_velocity(i, sizes.map(|Size(size)| size)).map(|speed| speed * set.alpha);
            largest = larger(largest, speeds, T::ONE);
        }
        let unit = unit(largest);
        let mut squares = T::ZERO;
        for speeds in speeds.iter().take(sets.len()) {
            squares += square(&speeds.map(|speed| speed * unit));
        }
        squares.square_root() * (T::literal(SHARE) / unit)
    }

    /// `carried` (N·s), the largest impulse that one dof asks of a contact.
    ///
    /// It is the largest of `(p_j + M_jj s / h_j) / h_j` over the dofs `j`, with the fastest offset `s = max |w|` and the longest
    /// lever `h_j = max_k |H_kj|`; `k` runs over normals and tangents, not over spin and roll. The momentum `p_j` is the
    /// magnitude of the free impulse plus those of the joint rows, each row as if it were alone. `|r0|` is too small where a
    /// light body carries a heavy one in a stack, or where a spring presses a body at rest onto its contacts. A dof counts only
    /// if `h_j > 1e-7 sqrt(M_jj max_i trace(W_ii))`: a contact that moves this dof alone, with the lever `h_j`, has the inverse
    /// mass `h_j² / M_jj`.
    pub(crate) fn carried_impulse(&self, sets: &Sets<T, D, C, R>, free: &[T; N]) -> T {
        let (mut levers, mut fastest, mut mobility) = ([T::ZERO; N], T::ZERO, T::ZERO);
        for (i, contact, set) in zip3(0..C, self.contacts(), sets.contacts()) {
            let mut offset = without_gap(&contact.offset);
            for (offset, &share) in offset.iter_mut().zip(&self.scaled_velocity(i, [T::ONE; D])) {
                if share == T::ZERO {
                    *offset = T::ZERO; // no impulse acts along this row
                }
            }
            fastest = larger(fastest, translations(offset.as_slice()), T::ONE);
            mobility = at_least(set.inverse_mass(), mobility);
            for (lever, column) in levers.iter_mut().zip(&contact.jacobian.data.0) {
                *lever = larger(*lever, translations(column), T::ONE);
            }
        }
        let mut momenta = free.map(ComplexField::abs);
        for (set, row) in sets.rows().iter().zip(self.rows()) {
            let alone = set.alone();
            for (momentum, &entry) in momenta.iter_mut().zip(&row.row) {
                *momentum += (entry * alone).abs();
            }
        }
        let mut largest = T::ZERO;
        for (&lever, &momentum, mass) in zip3(&levers, &momenta, diagonal_of(&self.mass().data.0)) {
            if lever > T::literal(1e-7) * (mass * mobility).square_root() {
                largest = at_least((momentum + mass * fastest / lever) / lever, largest);
            }
        }
        largest
    }
}

/// Entries of the normal row and the tangents of a contact, without spin and roll.
fn translations<T>(entries: &[T]) -> &[T] {
    entries.get(..3).unwrap_or(entries)
}

/// An offset with a positive normal entry (a gap) replaced by 0.
pub(crate) fn without_gap<T: Real, const D: usize>(offset: &SVector<T, D>) -> SVector<T, D> {
    let mut offset = *offset;
    if let Some(normal) = offset.as_mut_slice().first_mut() {
        *normal = normal.min(T::ZERO);
    }
    offset
}
