//! Friction that falls once a contact slips.

use crate::real::Real;
use crate::solution::ContactMode;

/// Static and kinetic friction: a contact that slipped in the last step has the lower coefficient in this one.
///
/// ```
/// use stiction::{ContactMode, time_stepping::StaticFriction};
///
/// let wood = StaticFriction { at_rest: 0.5, sliding: 0.3 };
/// assert_eq!(wood.mu(Some(ContactMode::Slip)), 0.3);
/// assert_eq!(wood.mu(None), 0.5); // a contact that is new
/// ```
///
/// The mode of the last step is found by key: `kernel.solution().contact_by_key(7).map(|contact| contact.mode)`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StaticFriction<T> {
    /// Coefficient of a contact that sticks, opens or is new.
    pub at_rest: T,
    /// Coefficient of a contact that slips.
    pub sliding: T,
}

impl<T: Real> StaticFriction<T> {
    /// Coefficient for the next step, from the mode in the last one. [`crate::Scene::set_friction`] checks it.
    #[must_use]
    pub const fn mu(&self, last: Option<ContactMode>) -> T {
        match last {
            Some(ContactMode::Slip) => self.sliding,
            _ => self.at_rest,
        }
    }
}
