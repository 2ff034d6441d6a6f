//! What a slot of a scene of [`crate::Mixed`] laws has, beside a Jacobian and an offset.

use super::checks::fingerprint;
use crate::Real;

/// Scales and compliance of a slot's rows; of a slot of joint rows their laws.
#[derive(Clone, Copy, Debug)]
pub struct Slot<T, const D: usize> {
    /// By what each row of a contact is scaled, so that its cone is round.
    pub(crate) scales: [T; D],
    /// Compliance: of a contact that of the scaled rows.
    pub(crate) compliance: [T; D],
    pub(crate) rows: Option<SlotRows<T, D>>,
}

/// The laws of up to `D` joint rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SlotRows<T, const D: usize> {
    pub(crate) count: usize,
    /// The least and the largest impulse of each row; 0 of those behind the last.
    pub(crate) bounds: [[T; 2]; D],
    pub(crate) keys: [u32; D],
}

impl<T: Real, const D: usize> Slot<T, D> {
    /// A slot of joint rows, of which there is none yet.
    pub(super) const fn rows() -> Self {
        Self {
            scales: [T::ONE; D],
            compliance: [T::ZERO; D],
            rows: Some(SlotRows {
                count: 0,
                bounds: [[T::ZERO; 2]; D],
                keys: [0; D],
            }),
        }
    }

    /// Fingerprint of what a factor depends on.
    pub(super) fn fingerprint(&self, place: usize) -> u64 {
        let rows = self.rows.map_or(0, |rows| rows.count + 1);
        let scales = fingerprint(&self.scales, place).rotate_left(7);
        fingerprint(&self.compliance, place + (rows << 8)).wrapping_add(scales)
    }

    /// Does a contact rub along a tangent?
    pub(super) fn has_tangents(&self) -> bool {
        let mut tangents = self.scales.iter().skip(1).take(2);
        tangents.any(|&scale| scale > T::ZERO)
    }

    /// Is it compliant?
    pub(crate) fn gives_way(&self) -> bool {
        self.compliance
            .iter()
            .any(|&compliance| compliance > T::ZERO)
    }

    /// Adds to velocities by how much its rows give way to their impulses, both scaled.
    pub(crate) fn comply(&self, scales: &[T; D], r: &[T; D], u: &mut [T; D]) {
        let sources = r.iter().zip(self.compliance.iter().zip(scales));
        for (u, (&r, (&compliance, &scale))) in u.iter_mut().zip(sources) {
            let scaled = self.rows.map_or(compliance, |_| compliance * scale * scale);
            *u += scaled * r;
        }
    }

    /// By how much its rows give way to their impulses, `R r`, both not scaled.
    pub(crate) fn given_way(&self, r: &[T; D]) -> [T; D] {
        let mut given = self.compliance;
        for ((given, &r), &scale) in given.iter_mut().zip(r).zip(&self.scales) {
            *given *= match self.rows {
                None if scale > T::ZERO => r / (scale * scale),
                None => T::ZERO,
                Some(_) => r,
            };
        }
        given
    }
}
