//! Scaled rows of a slot: contacts so that their cone is round, joint rows to unit `W_jj`; and compliance.
//!
//! A joint row's impulse and velocity then have one unit, the root of an energy, whatever the row measures, and its step
//! `alpha` is 1.

use crate::Real;
use crate::linalg::blocks::ContactMatrix;
use crate::linalg::hints::rolled;
use crate::linalg::substitution::Scaled;
use crate::scene::slot::Slot;

/// The scales of a slot whose own block of `H M⁻¹ Hᵀ` is this one, unscaled. A row that nothing moves keeps its own.
pub(super) fn of<T: Real, const D: usize>(slot: &Slot<T, D>, own: &[[T; D]; D]) -> [T; D] {
    let mut scales = slot.scales;
    if slot.rows.is_some() {
        let rows = own.iter().zip(&slot.compliance).enumerate();
        for (scale, (k, (row, &compliance))) in scales.iter_mut().zip(rows) {
            rolled();
            let inertia = row.get(k).copied().unwrap_or(T::ZERO) + compliance;
            if inertia > T::ZERO {
                *scale = T::ONE / inertia.square_root();
            }
        }
    }
    scales
}

/// Scales what was made of the rows of a slot.
pub(super) fn apply<T: Real, const N: usize, const D: usize>(
    scales: &[T; D],
    whitened: &mut [[T; D]; N],
    scaled: &mut [Scaled<'_, T, N, D>],
) {
    let columns = scaled.iter_mut().map(|row| &mut row.entry).chain(whitened);
    for column in columns {
        rolled();
        for (entry, &scale) in column.iter_mut().zip(scales) {
            *entry *= scale;
        }
    }
}

/// Adds compliance to the own block of a slot. A place for a joint row that is not used gets 1, so that the block has an
/// inverse.
pub(super) fn comply<T: Real, const D: usize, const C: usize>(
    delassus: &mut ContactMatrix<T, D, C>,
    slot_index: usize,
    slot: &Slot<T, D>,
    scales: &[T; D],
) {
    let rows = delassus.get_mut(slot_index).into_iter().flatten();
    for (k, (row, (&compliance, &scale))) in
        rows.zip(slot.compliance.iter().zip(scales)).enumerate()
    {
        rolled();
        let added = match slot.rows {
            None => compliance,
            Some(rows) if k < rows.count => compliance * scale * scale,
            Some(_) => T::ONE,
        };
        let entry = row.get_mut(slot_index).and_then(|block| block.get_mut(k));
        if let Some(entry) = entry {
            *entry += added;
        }
    }
}
