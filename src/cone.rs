//! The friction cone `K`, its dual `K*` and the projections onto them: Eqs. (1)-(10) of [the note](crate::guide::note).
//!
//! The note divides by `mu` in (2), (4), (5) and (10), so it has no frictionless contact. Here a
//! cone is given by the direction `(axial, radial)` of its boundary ray,
//! `{(x1, x2): axial |x2| <= radial x1, x1 >= 0}`: `K_mu` is `(1, mu)` and its dual (9) is
//! `(mu, 1)`. All formulas of the note multiplied out by `mu` then serve both cones, `mu = 0`
//! included (`K` a ray, `K*` a half-space), exactly and without a division by `mu`.

use crate::linalg::vector::{norm, square, zeros};
use crate::real::Real;
use nalgebra::SVector;

/// A friction cone in any dimension `D >= 1`, normal component first.
///
/// `D` = 1 is a frictionless contact (the half-line), 2 planar, 3 spatial, 4 with spin, 6 with spin and roll.
///
/// ```
/// use nalgebra::vector;
/// use stiction::FrictionCone;
///
/// let cone = FrictionCone::new(1.0).unwrap();
/// let slipping = vector![2.0, 4.0, 0.0]; // normal first
/// assert_eq!(cone.project(&slipping), vector![3.0, 3.0, 0.0]);
/// assert!(cone.dual().contains(&vector![2.0, 1.0, 0.0]));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FrictionCone<T> {
    axial: T,
    radial: T,
    /// `1 / (axial² + radial²)`
    shrink: T,
}

impl<T: Real> FrictionCone<T> {
    /// The cone `K_mu = {(x1, x2): |x2| <= mu x1}`.
    ///
    /// `None` if `mu` is negative, NaN, infinite, or so large that `mu²` overflows.
    #[must_use]
    pub fn new(mu: T) -> Option<Self> {
        Self::is_valid(mu).then(|| Self { axial: T::ONE, radial: mu, shrink: T::ONE / (T::ONE + mu * mu) })
    }

    /// Is there a cone with this `mu`?
    #[inline]
    pub(crate) fn is_valid(mu: T) -> bool {
        mu >= T::ZERO && (mu * mu).is_finite()
    }

    /// The cone of a contact without friction, `K_0`: a ray.
    #[must_use]
    pub const fn frictionless() -> Self {
        Self { axial: T::ONE, radial: T::ZERO, shrink: T::ONE }
    }

    /// The dual cone, Eq. (9): `K*_mu = K_{1/mu} = {(x1, x2): mu |x2| <= x1}`.
    #[must_use]
    pub const fn dual(&self) -> Self {
        Self { axial: self.radial, radial: self.axial, shrink: self.shrink }
    }

    /// `mu` of a friction cone.
    pub(crate) const fn friction(&self) -> T {
        self.radial
    }

    /// `1 / (1 + mu²)`
    pub(crate) const fn shrink(&self) -> T {
        self.shrink
    }

    /// Coordinate along the boundary ray `(axial, radial)` of the projection of a vector, if that lies on the ray.
    #[inline]
    pub(crate) fn along(&self, normal: T, length: T) -> T {
        (self.axial * normal + self.radial * length) * self.shrink
    }

    /// Is `x` in the cone?
    #[must_use]
    pub fn contains<const D: usize>(&self, x: &SVector<T, D>) -> bool {
        self.has(&(x * unit_of(x))) && !self.is_beside_ray(x)
    }

    /// Does `x` have a tangential part while the cone is a ray? [`Self::has`] may miss it: its square may vanish.
    fn is_beside_ray<const D: usize>(&self, x: &SVector<T, D>) -> bool {
        self.radial == T::ZERO && split(x).1.iter().any(|&x| x != T::ZERO)
    }

    /// [`Self::contains`] for entries whose squares neither overflow nor vanish.
    #[inline]
    pub(crate) fn has<const D: usize>(&self, x: &SVector<T, D>) -> bool {
        let (normal, tangent) = split(x);
        normal >= T::ZERO && is_within(tangent, self.axial, self.radial * normal)
    }

    /// Is `x` in the polar cone? Then its projection is zero.
    #[inline]
    fn is_polar<const D: usize>(&self, x: &SVector<T, D>) -> bool {
        let (normal, tangent) = split(x);
        is_within(tangent, self.radial, -self.axial * normal)
    }

    /// Is `x` in the interior of the cone? With `D` = 1 that is the open half-line.
    pub(crate) fn is_interior<const D: usize>(&self, x: &SVector<T, D>) -> bool {
        let (normal, tangent) = split(x);
        let bound = self.radial * normal;
        let size = square(tangent) * (self.axial * self.axial);
        normal > T::ZERO && (size < bound * bound || D == 1)
    }

    /// Euclidean projection (6) onto the cone: Eq. (8) for `K`, and (10) for `K*`, the [`Self::dual`].
    ///
    /// These are (1) and (2) of the note again. `tests/small/cone.rs` has the spectral form (3)-(5), (7), which gives the same.
    #[must_use]
    pub fn project<const D: usize>(&self, x: &SVector<T, D>) -> SVector<T, D> {
        if self.axial == T::ZERO {
            // A half-space. Beside a large normal part the square of a tangent may vanish.
            let mut projection = *x;
            if let Some(first) = projection.as_mut_slice().first_mut() {
                *first = first.max(T::ZERO);
            }
            return projection;
        }
        let unit = unit_of(x);
        let mut projection = self.nearest(&(x * unit)) / unit;
        if self.is_beside_ray(x) {
            for tangent in projection.iter_mut().skip(1) {
                *tangent = T::ZERO;
            }
        }
        projection
    }

    /// [`Self::project`] for entries whose squares neither overflow nor vanish.
    #[inline]
    pub(crate) fn nearest<const D: usize>(&self, x: &SVector<T, D>) -> SVector<T, D> {
        self.project_with_length(x).0
    }

    /// [`Self::nearest`] and the length of the tangential part of the projection.
    #[inline]
    pub(crate) fn project_with_length<const D: usize>(&self, x: &SVector<T, D>) -> (SVector<T, D>, T) {
        let (normal, tangent) = split(x);
        if self.has(x) {
            return (*x, norm(tangent));
        }
        if self.is_polar(x) {
            return (zeros(), T::ZERO);
        }
        // Here `length > 0`: without a tangential part one of the cases above holds.
        let length = norm(tangent);
        let along = self.along(normal, length);
        let shadow = along * self.radial;
        let mut projection = x * (shadow / length);
        if let Some(first) = projection.as_mut_slice().first_mut() {
            *first = along * self.axial;
        }
        (projection, shadow)
    }

    /// `|Π_K(x)|²`, computed without a division.
    #[inline]
    pub(crate) fn projected_square<const D: usize>(&self, x: &SVector<T, D>) -> T {
        let (normal, tangent) = split(x);
        if self.has(x) {
            square(x.as_slice())
        } else if self.is_polar(x) {
            T::ZERO
        } else {
            let along = self.axial * normal + self.radial * norm(tangent);
            along * along * self.shrink
        }
    }
}

/// Normal and tangential part of a contact vector.
#[inline]
pub(crate) fn split<T: Real, const D: usize>(x: &SVector<T, D>) -> (T, &[T]) {
    const { assert!(D >= 1, "a contact has at least its normal row") }
    match x.as_slice().split_first() {
        Some((&normal, tangent)) => (normal, tangent),
        None => (T::ZERO, &[]),
    }
}

/// `factor |tangent| <= bound`, without a square root.
#[inline]
fn is_within<T: Real>(tangent: &[T], factor: T, bound: T) -> bool {
    let within = match tangent {
        [] => true,
        [only] => factor * only.abs() <= bound,
        more => square(more) * (factor * factor) <= bound * bound,
    };
    within && bound >= T::ZERO
}

/// Adds a value to the normal component.
#[inline]
pub(crate) fn add_to_normal<T: Real, const D: usize>(x: &mut SVector<T, D>, value: T) {
    if let Some(normal) = x.as_mut_slice().first_mut() {
        *normal += value;
    }
}

/// A power of two that brings the largest entry near 1. Then no square overflows, and none of a large entry vanishes.
fn unit_of<T: Real, const D: usize>(entries: &SVector<T, D>) -> T {
    let mut largest = T::ZERO;
    for x in entries {
        if x.abs() > largest {
            largest = x.abs();
        }
    }
    T::power_of_two(-largest.exponent())
}
