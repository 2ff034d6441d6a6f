//! One contact, as it is given.

use crate::error::Error;
use crate::linalg::zip::{zip3, zip4};
use crate::parameter::Parameter;
use crate::real::Real;
use core::mem;
use nalgebra::{ArrayStorage, SMatrix, SVector};

/// A contact with friction: `u_i = H_i v + w_i`, and Coulomb's law `K*_mu ∋ u_i + mu_i |u_Ti| e_N ⟂ r_i ∈ K_mu`.
///
/// It has `D` rows over `N` generalised velocities. The first row is the normal, which points out of the obstacle.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "T: Real + serde::Serialize",
        deserialize = "T: Real + serde::Deserialize<'de>"
    ))
)]
pub struct Contact<T, const N: usize, const D: usize> {
    /// Contact Jacobian `H_i` (`D × N`): `H_i v` is the velocity of the contact point.
    pub jacobian: SMatrix<T, D, N>,
    /// Offset `w_i` (`D` entries, m/s; spin and roll rad/s): velocity of a moving surface, gap over time step, restitution.
    pub offset: SVector<T, D>,
    /// Coulomb friction coefficient `mu_i >= 0`.
    pub mu: T,
    /// A number of your own that identifies the contact: a foot, a pair of features.
    ///
    /// A solve starts each contact from the impulse of the contact with the same key in the last solve, and from zero if there was none.
    /// If several contacts share a key, the first follows the first, the second the second. So all keys may be 0 if contacts never come, go
    /// or change their order. [`crate::ContactSolution::key`] returns it.
    pub key: u32,
}

impl<T: Real, const N: usize, const D: usize> Contact<T, N, D> {
    /// A contact at a point of a body, with offset 0.
    ///
    /// - `normal`: unit vector out of the obstacle, in `K` coordinates.
    /// - `point_jacobian`: velocity of the point in the same coordinates, `K × N`.
    ///
    /// With `D = K` rows the tangents are those of [`contact_frame`]; with `D = 1` there are none.
    ///
    /// ```
    /// use nalgebra::{matrix, vector};
    /// use stiction::Contact;
    ///
    /// // The corner of a plate in the plane (x, height, angle), half a metre to the right of its centre and 0.25 below.
    /// let corner = matrix![1.0, 0.0, 0.25; 0.0, 1.0, 0.5];
    /// let contact = Contact::<f64, 3, 2>::at_point(&vector![0.0, 1.0], &corner, 0.5, 0)?;
    /// assert_eq!(contact.jacobian.row(0), corner.row(1)); // the height
    /// # Ok::<(), stiction::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] with [`Parameter::Normal`] if the length of the normal is off 1 by more than a thousandth. (The scene checks
    /// the rest.)
    pub fn at_point<const K: usize>(
        normal: &SVector<T, K>,
        point_jacobian: &SMatrix<T, K, N>,
        mu: T,
        key: u32,
    ) -> Result<Self, Error> {
        const { assert!(D == K || D == 1, "a contact has all tangents or none") }
        let frame = contact_frame(normal)?;
        let mut contact = Self { mu, key, ..Self::none() };
        contact.set_rows(0, &frame, point_jacobian);
        Ok(contact)
    }

    /// A contact of a patch of a body, which resists spin (`D` = 4) and rolling as well (`D` = 6), with offset 0.
    ///
    /// - `normal`, `point_jacobian`: as for [`Self::at_point`], in space.
    /// - `rotation_jacobian`: angular velocity of the body, minus that of the obstacle (rad/s), in the same coordinates, `3 × N`.
    ///
    /// Behind the three rows of [`Self::at_point`] stand the angular velocities about the normal and about the two tangents. All its friction is
    /// in a [`crate::Surface`], with `spin` and `roll` ([`crate::guide::rows`]).
    ///
    /// ```
    /// use nalgebra::{Matrix3, SMatrix, vector};
    /// use stiction::{Contact, Scene, Surface};
    ///
    /// // A disc of 2 kg and 0.1 m lies on the floor. Its velocities are those of its centre and its angular velocity.
    /// let mut scene = Scene::<f64, 6, 4, 1, 0, 1>::new();
    /// scene.set_mass(&SMatrix::from_diagonal(&vector![2.0, 2.0, 2.0, 5e-3, 5e-3, 1e-2]))?;
    /// let (mut point, mut rotation) = (SMatrix::<f64, 3, 6>::zeros(), SMatrix::<f64, 3, 6>::zeros());
    /// point.fixed_columns_mut::<3>(0).copy_from(&Matrix3::identity());
    /// rotation.fixed_columns_mut::<3>(3).copy_from(&Matrix3::identity());
    /// let disc = Contact::<f64, 6, 4>::at_patch(&vector![0.0, 0.0, 1.0], &point, &rotation, 0)?;
    /// assert_eq!(disc.jacobian.row(3), rotation.row(2)); // about the vertical
    /// // A disc with even pressure resists spin by 2/3 mu R times its load.
    /// scene.push_on(&disc, &Surface { spin: 2.0 / 3.0 * 0.5 * 0.1, ..Surface::isotropic(0.5) })?;
    /// # Ok::<(), stiction::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::at_point`].
    pub fn at_patch(
        normal: &SVector<T, 3>,
        point_jacobian: &SMatrix<T, 3, N>,
        rotation_jacobian: &SMatrix<T, 3, N>,
        key: u32,
    ) -> Result<Self, Error> {
        const { assert!(D == 4 || D == 6, "a patch has four rows with spin, six with rolling") }
        let frame = contact_frame(normal)?;
        let mut contact = Self { key, ..Self::none() };
        contact.set_rows(0, &frame, point_jacobian);
        contact.set_rows(3, &frame, rotation_jacobian);
        Ok(contact)
    }

    /// Fills the rows from index `first` on with the components of a velocity along the axes of a frame.
    fn set_rows<const K: usize>(
        &mut self,
        first: usize,
        frame: &SMatrix<T, K, K>,
        velocity: &SMatrix<T, K, N>,
    ) {
        for (target, velocity) in self.jacobian.data.0.iter_mut().zip(&velocity.data.0) {
            for (entry, axis) in target.iter_mut().skip(first).zip(&frame.data.0) {
                *entry = axis.iter().zip(velocity).fold(T::ZERO, |sum, (&a, &v)| sum + a * v);
            }
        }
    }

    /// An unused contact.
    pub(super) const fn none() -> Self {
        Self {
            jacobian: SMatrix::from_array_storage(ArrayStorage([[T::ZERO; D]; N])),
            offset: SVector::from_array_storage(ArrayStorage([[T::ZERO; D]; 1])),
            mu: T::ZERO,
            key: 0,
        }
    }
}

/// Frame of a contact with a unit normal (`K × K`): its columns are the normal and the tangents, in the coordinates of the normal.
///
/// It turns an impulse `r` of a contact into the vector `frame r`. For a normal along the last axis the tangents are the other
/// axes. They turn with the normal without a jump, unless it passes the direction against the last axis. So let the last axis
/// point up: on uneven ground a warm start then finds its friction along the same tangents. Only under a ceiling do normals that
/// differ little have frames that differ much.
///
/// # Errors
/// [`Error::InvalidParameter`] with [`Parameter::Normal`] if the length of the normal is off 1 by more than a thousandth.
pub fn contact_frame<T: Real, const K: usize>(normal: &SVector<T, K>) -> Result<SMatrix<T, K, K>, Error> {
    let square = normal.iter().fold(T::ZERO, |sum, &x| sum + x * x);
    let is_unit = (square - T::ONE).abs() < T::literal(2e-3);
    if !is_unit {
        let parameter = Parameter::Normal;
        return Err(Error::InvalidParameter { parameter });
    }
    let unit = *normal / square.square_root();
    let mut level = unit;
    let up = level.as_mut_slice().last_mut().map_or(T::ONE, |last| mem::replace(last, T::ZERO));
    // 1 + up, without cancellation.
    let mut rise = T::ONE + up;
    if up < T::ZERO {
        rise = level.iter().fold(T::ZERO, |sum, &x| sum + x * x) / (T::ONE - up);
    }
    // Against the last axis: the limit of normals between the first axis and that direction.
    if rise < T::least_normal() / T::EPSILON
        && let Some(first) = level.as_mut_slice().first_mut()
    {
        (*first, rise) = (T::ONE, T::literal(0.5));
    }
    // The half turn that exchanges normal and last axis takes the other axes to the negative tangents.
    let mut frame = SMatrix::from_array_storage(ArrayStorage([unit.into(); K]));
    let tangents = frame.data.0.iter_mut().skip(1);
    for (j, tangent, &component, &y) in zip4(0..K, tangents, &unit, &level) {
        for (i, entry, &x) in zip3(0..K, &mut *tangent, &level) {
            let delta = if i == j { T::ONE } else { T::ZERO };
            *entry = delta - x * y / rise;
        }
        if let Some(last) = tangent.last_mut() {
            *last = -component;
        }
    }
    Ok(frame)
}
