//! One contact, the others held.

use crate::real::Real;
use crate::sets::ContactSet;

/// A contact with what its impulse follows from while the others are held.
pub(in crate::sets) struct Local<'a, T: Real, const D: usize> {
    pub(in crate::sets) set: &'a ContactSet<T, D>,
    /// `W_ii`
    pub(in crate::sets) own: [[T; D]; D],
    /// `W_ii⁻¹`, or zero
    pub(in crate::sets) mass: &'a [[T; D]; D],
    /// Its velocity with its impulse as it is.
    pub(in crate::sets) u: [T; D],
    pub(in crate::sets) r: [T; D],
}
