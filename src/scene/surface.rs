//! Surfaces: shapes of friction other than a round cone, and compliance.
//!
//! The rows of a contact are *physical*, as the caller gives and reads them, or *scaled*, so that the cone is round: sets and solvers
//! use scaled rows. Velocities are multiplied by the scales on their way into scaled rows, impulses are divided by them, so the product
//! of both stays the same. [`Scene::scaled_velocity`] and the three functions beside it are the only ways between the two.

use crate::cone::FrictionCone;
use crate::error::Error;
use crate::linalg::zip::zip3;
use crate::real::Real;
use crate::scene::Scene;

/// Friction by direction, and compliance, of a contact.
///
/// The cone is elliptic, `Σ (r_k / mu_k)² <= r_N²` over the tangents, the spin about the normal and the rolls about the tangents. The rows of
/// [`crate::Contact::jacobian`] have the order normal, two tangents, spin, two rolls (`D` = 2, 3, 4 or 6). A row with coefficient 0 is free.
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
    /// Coefficient of spin about the normal, a length (m): the largest torque over the load. `mu` is in it: a disc with even pressure has
    /// `2/3 mu R`.
    pub spin: T,
    /// Coefficients of roll about the two tangents, lengths (m).
    pub roll: [T; 2],
    /// Compliance along the normal and along the tangents (1/kg), see [`crate::time_stepping::Spring::compliance`]; 0 is rigid.
    ///
    /// The compliance of spin and roll is that of the tangents over `(length / mu)²`.
    pub compliance: [T; 2],
}

impl<T: Real> Surface<T> {
    /// A rigid surface with one friction coefficient and without resistance to spin and roll.
    #[must_use]
    pub const fn isotropic(mu: T) -> Self {
        Self { friction: [mu, mu], spin: T::ZERO, roll: [T::ZERO; 2], compliance: [T::ZERO; 2] }
    }

    /// The coefficients in the order of the rows.
    fn coefficients(&self) -> [T; 5] {
        let ([x, y], [about_x, about_y]) = (self.friction, self.roll);
        [x, y, self.spin, about_x, about_y]
    }

    /// Checks coefficients and compliance.
    pub(crate) fn check(&self, contact: usize) -> Result<(), Error> {
        let mut coefficients = self.coefficients().into_iter();
        if let Some(index) = coefficients.position(|mu| !FrictionCone::is_valid(mu)) {
            let row = index + 1; // behind the normal row
            return Err(Error::InvalidFriction { contact, row });
        }
        let invalid = |&compliance: &T| !(compliance >= T::ZERO && compliance.is_finite());
        match self.compliance.iter().position(invalid) {
            Some(row) => Err(Error::InvalidCompliance { contact, row }),
            None => Ok(()),
        }
    }

    /// The larger coefficient of the tangents, which is the coefficient of the round cone once rows are scaled. Without friction along the
    /// tangents it is 1 if there is spin or roll, otherwise 0.
    pub(crate) fn reference<const D: usize>(&self) -> T {
        let tangents = self.friction.into_iter().take(D - 1);
        let largest = tangents.fold(T::ZERO, T::max);
        let mut others = self.coefficients().into_iter().take(D - 1);
        if largest == T::ZERO && others.any(|mu| mu > T::ZERO) {
            return T::ONE;
        }
        largest
    }
}

/// Scales of the rows of a contact, and compliance of the scaled rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scaling<T, const D: usize> {
    scales: [T; D],
    pub(crate) compliance: [T; D],
}

impl<T: Real, const D: usize> Scaling<T, D> {
    /// The scaling of an unused contact.
    pub(super) const fn none() -> Self {
        Self { scales: [T::ZERO; D], compliance: [T::ZERO; D] }
    }

    /// The scaling of a surface. Without friction the scale of tangents is 1, as in [`crate::Scene::push`], and that of spin and roll, which have
    /// another unit, is 0.
    pub(super) fn of(surface: &Surface<T>) -> Self {
        let reference = surface.reference::<D>();
        let mut scales = [T::ONE; D];
        for (k, scale, mu) in zip3(1..D, scales.iter_mut().skip(1), surface.coefficients()) {
            if reference > T::ZERO {
                *scale = mu / reference;
            } else if k >= 3 {
                *scale = T::ZERO;
            }
        }
        let [normal, tangential] = surface.compliance;
        let mut compliance = [normal; D];
        for (k, compliance, &scale) in zip3(0..D, &mut compliance, &scales).skip(1) {
            *compliance = match k {
                1 | 2 => tangential * scale * scale,
                _ if scale > T::ZERO => tangential,
                _ => T::ZERO,
            };
        }
        Self { scales, compliance }
    }

    /// Does the contact rub along a tangent?
    pub(super) fn has_tangents(&self) -> bool {
        let mut tangents = self.scales.iter().skip(1).take(2);
        tangents.any(|&scale| scale > T::ZERO)
    }

    /// Fingerprint of the contact's Jacobian, scales and compliance, from that of the Jacobian.
    pub(super) fn fingerprint(&self, jacobian: u64) -> u64 {
        let numbers = self.scales.iter().chain(&self.compliance);
        numbers.fold(jacobian, |hash, number| number.hash(hash))
    }

    /// Multiplies by the scales, as [`Scene::scaled_velocity`] and [`Scene::physical_impulse`] do.
    #[inline]
    pub(crate) fn multiply(&self, mut x: [T; D]) -> [T; D] {
        for (x, &scale) in x.iter_mut().zip(&self.scales) {
            *x *= scale;
        }
        x
    }

    /// Divides by the scales, as [`Scene::scaled_impulse`] and [`Scene::physical_velocity`] do. A row with the scale 0 becomes 0.
    #[inline]
    fn divide(&self, mut x: [T; D]) -> [T; D] {
        for (x, &scale) in x.iter_mut().zip(&self.scales) {
            *x = if scale > T::ZERO { *x / scale } else { T::ZERO };
        }
        x
    }

    /// Is it compliant?
    pub(crate) fn is_compliant(&self) -> bool {
        self.compliance.iter().any(|&compliance| compliance > T::ZERO)
    }

    /// The largest compliance of a row, in scaled rows.
    pub(crate) fn largest_compliance(&self) -> T {
        self.compliance.into_iter().fold(T::ZERO, T::max)
    }

    /// The physical velocity that compliance adds for a physical impulse, `R r`.
    pub(crate) fn compliance_velocity(&self, r: &[T; D]) -> [T; D] {
        let mut added = self.compliance;
        for (added, &r, &scale) in zip3(&mut added, r, &self.scales) {
            if *added > T::ZERO {
                *added *= r / scale / scale; // a row that is scaled by 0 has no compliance
            }
        }
        added
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Scene<T, N, D, C, R, S>
{
    /// A velocity of a contact in scaled rows, from physical ones.
    #[inline]
    pub(crate) fn scaled_velocity<V: From<[T; D]> + Into<[T; D]>>(&self, contact: usize, u: V) -> V {
        self.convert(contact, u, Scaling::multiply)
    }

    /// A velocity of a contact in physical rows, from scaled ones.
    #[inline]
    pub(crate) fn physical_velocity<V: From<[T; D]> + Into<[T; D]>>(&self, contact: usize, u: V) -> V {
        self.convert(contact, u, Scaling::divide)
    }

    /// An impulse of a contact in scaled rows, from physical ones.
    #[inline]
    pub(crate) fn scaled_impulse<V: From<[T; D]> + Into<[T; D]>>(&self, contact: usize, r: V) -> V {
        self.convert(contact, r, Scaling::divide)
    }

    /// An impulse of a contact in physical rows, from scaled ones.
    #[inline]
    pub(crate) fn physical_impulse<V: From<[T; D]> + Into<[T; D]>>(&self, contact: usize, r: V) -> V {
        self.convert(contact, r, Scaling::multiply)
    }

    /// A vector of a contact, converted by its scaling if it has one.
    #[inline]
    fn convert<V: From<[T; D]> + Into<[T; D]>>(
        &self,
        contact: usize,
        x: V,
        conversion: impl Fn(&Scaling<T, D>, [T; D]) -> [T; D],
    ) -> V {
        match self.scaling(contact) {
            Some(scaling) => conversion(scaling, x.into()).into(),
            None => x,
        }
    }
}
