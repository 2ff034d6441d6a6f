//! What is left of a contact, or of a slot of joint rows.

use crate::Real;
use crate::solution::zeros;
use nalgebra::SVector;

/// `ũ` and `r` of a contact in the last solve, in physical units.
#[derive(Clone, Copy, Debug)]
pub(in crate::solver) struct ContactState<T, const D: usize> {
    pub(in crate::solver) key: u32,
    pub(in crate::solver) u: SVector<T, D>,
    pub(in crate::solver) r: SVector<T, D>,
    /// `r` of the solve before, if `solves > 1`. (An option in an option would not be all zeros.)
    pub(in crate::solver) before: SVector<T, D>,
    /// How many solves have had the contact; 0 if its impulse was given, and `u` is not known.
    pub(in crate::solver) solves: u32,
}

impl<T: Real, const D: usize> ContactState<T, D> {
    /// `r`, extrapolated from the last two solves; an open contact stays open.
    pub(super) fn ahead(&self) -> SVector<T, D> {
        if self.solves > 1 && self.r != zeros::<T, D>() {
            self.r + (self.r - self.before)
        } else {
            self.r
        }
    }
}
