//! The problem of one contact while the impulses of the others are held.

use crate::real::Real;
use crate::sets::ContactSet;

/// The data from which a sweep computes the next impulse of one contact.
pub(in crate::sets) struct Local<'a, T: Real, const D: usize> {
    pub(in crate::sets) set: &'a ContactSet<T, D>,
    /// `W_ii`, the diagonal block of the Delassus operator.
    pub(in crate::sets) block: [[T; D]; D],
    /// `W_ii⁻¹`; zero if `W_ii` is nearly singular or has more than three rows.
    pub(in crate::sets) mass: &'a [[T; D]; D],
    /// Velocity of the contact with its present impulse `r`.
    pub(in crate::sets) u: [T; D],
    /// Present impulse.
    pub(in crate::sets) r: [T; D],
}
