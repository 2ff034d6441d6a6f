//! A factor that takes in slots and lets go of them again.

use super::Factor;
use crate::laws::Mixed;
use crate::linalg::cholesky::reach;
use crate::{Error, Real, Scene};
use nalgebra::SVector;

/// What of a factor [`Factor::extend`] overwrites.
pub(crate) struct Extent {
    contacts: usize,
    fingerprint: u64,
    moved: usize,
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Factor<T, N, D, C, Mixed> {
    /// Takes in the slots of a scene from `first` on. `M` and the slots before have to be those that it has.
    pub(crate) fn extend(
        &mut self,
        scene: &Scene<T, N, D, C, Mixed>,
        first: usize,
    ) -> Result<(), Error> {
        let reach = reach(&self.mass);
        self.take_in(scene, first, &reach);
        self.check(scene)
    }

    /// How far it reaches.
    pub(crate) const fn extent(&self) -> Extent {
        Extent {
            contacts: self.contacts,
            fingerprint: self.fingerprint,
            moved: self.moved,
        }
    }

    /// Lets go of the slots that it has taken in since.
    pub(crate) const fn shrink(&mut self, to: &Extent) {
        (self.contacts, self.fingerprint, self.moved) = (to.contacts, to.fingerprint, to.moved);
    }

    /// `v_free = M⁻¹ p`
    pub(crate) fn free_velocity(&self, free_impulse: &SVector<T, N>) -> SVector<T, N> {
        let [mut whitened] = free_impulse.data.0;
        self.whiten(&mut whitened);
        let mut velocity = *free_impulse;
        let [v] = &mut velocity.data.0;
        self.velocity(&whitened, &[], v);
        velocity
    }
}
