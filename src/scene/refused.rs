//! Parts of a scene that were refused as it was filled: without them it is half a scene.

use super::Scene;
use crate::error::{Error, Part};
use crate::real::Real;

/// Parts that were refused, and are missing since.
#[derive(Clone, Copy, Debug)]
pub(super) struct Refused {
    pub(super) mass: bool,
    pub(super) contact: bool,
    pub(super) row: bool,
}

impl Refused {
    /// None.
    pub(super) const fn none() -> Self {
        Self { mass: false, contact: false, row: false }
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Scene<T, N, D, C, R, S>
{
    /// Is there a part that was refused, and that neither [`Self::clear`] nor another mass matrix has made good?
    pub(crate) const fn check_complete(&self) -> Result<(), Error> {
        let part = if self.refused.mass {
            Part::Mass
        } else if self.refused.contact {
            Part::Contact
        } else if self.refused.row {
            Part::JointRow
        } else {
            return Ok(());
        };
        Err(Error::SceneIncomplete { part })
    }
}
