//! One contact and one joint row of a solution, and their modes.

use crate::real::Real;
use nalgebra::SVector;

/// The mode of a contact: open, sticking or slipping.
///
/// A contact without impulse is open. It slips if it moves along its tangents: faster than [`crate::Settings::still`], and faster than the larger of
/// tolerance and error allows (`alpha |u_T|` as a share of all impulses). Otherwise it sticks, also if its impulse lies on the boundary of its cone. A
/// contact with `D` = 1 has no tangent: it sticks if it pushes. [`crate::guide::loads`] says how near to slipping it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ContactMode {
    /// No impulse, exactly zero.
    Open,
    /// An impulse, and no velocity along the tangents, up to the error.
    Stick,
    /// A velocity along the tangents, and an impulse on the boundary of the friction cone against it, up to the error.
    Slip,
}

/// One contact of a [`crate::Solution`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "T: Real + serde::Serialize",
        deserialize = "T: Real + serde::Deserialize<'de>"
    ))
)]
pub struct ContactSolution<T, const D: usize> {
    /// The [`crate::Contact::key`] of this contact.
    pub key: u32,
    /// Contact impulse `r_i` (N·s; spin and roll N·m·s), normal first.
    pub impulse: SVector<T, D>,
    /// Relative velocity `u_i = H_i v + w_i` (m/s; spin and roll rad/s), plus that of compliance, normal first.
    pub velocity: SVector<T, D>,
    /// The mode of the contact.
    pub mode: ContactMode,
}

/// The mode of a joint row.
///
/// A box is at a bound if `λ - alpha s` lies there or beyond, as in the natural map ([`crate::guide::error`]). `λ` itself is there up to the
/// error: [`crate::Violation::row_impulse`] is how far it is off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RowMode {
    /// A limit that is not reached: no impulse, exactly zero.
    Open,
    /// A limit that is reached and pushes.
    AtLimit,
    /// A box at its lower bound, up to the error: a saturated motor, a joint that slips against its friction.
    AtLower,
    /// A box at its upper bound, up to the error.
    AtUpper,
    /// An equality, or a box between its bounds: `s` is 0, up to the error.
    Holding,
}

impl RowMode {
    /// The mode of a row with these bounds. A limit has the mode of its impulse; a box that of `push`, the argument `λ - alpha s` of the
    /// projection in the natural map ([`crate::guide::error`]).
    pub(crate) fn of<T: Real>(impulse: T, push: T, [lower, upper]: [T; 2]) -> Self {
        let limit = !upper.is_finite() && lower.is_finite();
        let impulse = if limit { impulse } else { push };
        if impulse <= lower {
            if limit { Self::Open } else { Self::AtLower }
        } else if impulse >= upper {
            Self::AtUpper
        } else if limit {
            Self::AtLimit
        } else {
            Self::Holding
        }
    }
}

/// One joint row of a [`crate::Solution`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RowSolution<T> {
    /// The [`crate::JointRow::key`] of this row.
    pub key: u32,
    /// Impulse `λ`: N·s along a length, N·m·s about an axis.
    pub impulse: T,
    /// Speed `s = row · v + offset + compliance · λ` (rad/s, m/s).
    pub velocity: T,
    /// The mode of the row.
    pub mode: RowMode,
}
