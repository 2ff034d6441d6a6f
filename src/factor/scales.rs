//! Scaled rows of a slot: contacts so that their cone is round, joint rows to unit `W_jj`; and compliance.
//!
//! A joint row is scaled to `W_jj = 1 / m`, with one reference mass `m` for all rows of a scene
//! ([`crate::Scene`]'s `reference_mass`): its impulse then is a momentum and its velocity a speed, whatever the row measures, and
//! its step `alpha` is `m`. `W_jj m` does not depend on the unit of mass, and is a square in those of length and angle: units
//! that change by a power of two change no bit of a mantissa, although a root is taken.

use crate::Real;
use crate::linalg::blocks::ContactMatrix;
use crate::linalg::hints::rolled;
use crate::linalg::substitution::Scaled;
use crate::scene::slot::Slot;

/// The scales of a slot whose own block of `H M⁻¹ Hᵀ` is this one, unscaled. A row that nothing moves keeps its own. It is
/// infinite if `W_jj` is out of the range of the number type: too large, or too small for its digits though the row `reaches`
/// something.
pub(super) fn of<T: Real, const D: usize>(
    slot: &Slot<T, D>,
    own: &[[T; D]; D],
    reference_mass: T,
    reaches: &[bool; D],
) -> [T; D] {
    let mut scales = slot.scales;
    if slot.rows.is_some() {
        let rows = own.iter().zip(slot.compliance.iter().zip(reaches));
        for (scale, (k, (row, (&compliance, &reaches)))) in scales.iter_mut().zip(rows.enumerate())
        {
            rolled();
            let inverse_mass = row.get(k).copied().unwrap_or(T::ZERO) + compliance;
            if inverse_mass > T::ZERO || reaches {
                *scale = T::ONE / in_range(inverse_mass, reference_mass).square_root();
            }
        }
    }
    scales
}

/// `W_jj m`, or 0 if either is no normal number.
fn in_range<T: Real>(inverse_mass: T, reference_mass: T) -> T {
    let (least, product) = (T::least_normal(), inverse_mass * reference_mass);
    let fits = inverse_mass >= least && product >= least && product.is_finite();
    if fits { product } else { T::ZERO }
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

/// Adds compliance to the own block of a slot. A place for a joint row that is not used gets `1 / m`, so that the block has
/// an inverse.
pub(super) fn comply<T: Real, const D: usize, const C: usize>(
    delassus: &mut ContactMatrix<T, D, C>,
    slot_index: usize,
    slot: &Slot<T, D>,
    scales: &[T; D],
    reference_mass: T,
) {
    let rows = delassus.get_mut(slot_index).into_iter().flatten();
    for (k, (row, (&compliance, &scale))) in
        rows.zip(slot.compliance.iter().zip(scales)).enumerate()
    {
        rolled();
        let added = match slot.rows {
            None => compliance,
            Some(rows) if k < rows.count => compliance * scale * scale,
            Some(_) => T::ONE / reference_mass,
        };
        let entry = row.get_mut(slot_index).and_then(|block| block.get_mut(k));
        if let Some(entry) = entry {
            *entry += added;
        }
    }
}
