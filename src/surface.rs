//! Surfaces: shapes of friction other than a round cone, and compliance.

use crate::cone::FrictionCone;
use crate::{Error, Real};

/// How a contact rubs and gives way, where that is not one coefficient.
///
/// The cone is elliptic, `Σ (r_k / mu_k)² <= r_N²` over the tangents, the spin about the normal and the roll about the
/// tangents, as far as the contact has such rows ([`crate::Contact::jacobian`] in this order: normal, two tangents, spin,
/// two rolls; `D` = 2, 3, 4 or 6). A coefficient of 0 lets its row go free.
///
/// ```
/// use stiction::Surface;
///
/// // A track: grips along, slips across, and resists turning like a patch of 4 cm.
/// let track = Surface { friction: [0.9, 0.5], spin: 0.04, ..Surface::isotropic(0.0) };
/// assert_eq!(track.compliance, [0.0, 0.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Surface<T> {
    /// Friction coefficients along the two tangents.
    pub friction: [T; 2],
    /// Torsional coefficient, a length (m).
    pub spin: T,
    /// Rolling coefficients about the two tangents, lengths (m).
    pub roll: [T; 2],
    /// Compliance along the normal and along the tangents (1/kg), see [`crate::time_stepping::compliance`]; 0 is rigid.
    ///
    /// Spin and roll have that of the tangents over the square of their lengths in units of the friction coefficient.
    pub compliance: [T; 2],
}

impl<T: Real> Surface<T> {
    /// Rigid, with one friction coefficient, and without resistance to spin and roll.
    #[must_use]
    pub const fn isotropic(mu: T) -> Self {
        Self {
            friction: [mu, mu],
            spin: T::ZERO,
            roll: [T::ZERO; 2],
            compliance: [T::ZERO; 2],
        }
    }

    /// The coefficients in the order of the rows.
    fn coefficients(&self) -> [T; 5] {
        let ([x, y], [about_x, about_y]) = (self.friction, self.roll);
        [x, y, self.spin, about_x, about_y]
    }

    /// What can be wrong with it.
    pub(crate) fn check(&self, contact: usize) -> Result<(), Error> {
        let coefficients = self.coefficients();
        if !coefficients.iter().all(|&mu| FrictionCone::is_valid(mu)) {
            return Err(Error::InvalidFriction { contact });
        }
        let valid = |&compliance: &T| compliance >= T::ZERO && compliance.is_finite();
        if !self.compliance.iter().all(valid) {
            return Err(Error::InvalidCompliance { slot: contact });
        }
        Ok(())
    }

    /// The larger coefficient of the tangents: that of the round cone once rows are scaled. Where both are 0 any number
    /// does if it spins or rolls, and without friction it is 0.
    pub(crate) fn reference<const D: usize>(&self) -> T {
        let tangents = self.friction.into_iter().take(D - 1);
        let largest = tangents.fold(T::ZERO, T::max);
        let mut others = self.coefficients().into_iter().take(D - 1);
        if largest == T::ZERO && others.any(|mu| mu > T::ZERO) {
            return T::ONE;
        }
        largest
    }

    /// By what each row is scaled, so that the cone is round. Without friction tangents are scaled by 1,
    /// as those of [`crate::Scene::push`], and spin and roll, of another unit, by 0.
    pub(crate) fn scales<const D: usize>(&self) -> [T; D] {
        let reference = self.reference::<D>();
        let mut scales = [T::ONE; D];
        for (k, (scale, mu)) in scales
            .iter_mut()
            .skip(1)
            .zip(self.coefficients())
            .enumerate()
        {
            if reference > T::ZERO {
                *scale = mu / reference;
            } else if k >= 2 {
                *scale = T::ZERO;
            }
        }
        scales
    }

    /// The compliance of the scaled rows.
    pub(crate) fn compliances<const D: usize>(&self, scales: &[T; D]) -> [T; D] {
        let [normal, tangential] = self.compliance;
        let mut compliances = [normal; D];
        for (k, (compliance, &scale)) in compliances.iter_mut().zip(scales).enumerate().skip(1) {
            *compliance = match k {
                1 | 2 => tangential * scale * scale,
                _ if scale > T::ZERO => tangential,
                _ => T::ZERO,
            };
        }
        compliances
    }
}
