//! What a contact and a joint row of a solution do.

use crate::real::Real;
use nalgebra::SVector;

/// What a contact does.
///
/// No tolerance decides it. A contact without impulse is open. One whose `r_i - alpha_i û_i` lies strictly inside the
/// friction cone sticks, also if a velocity of the size of the error is left. Every other one slips: also one without friction that
/// pushes, but for one of `D` = 1, which has no tangent to slip along, and sticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ContactMode {
    /// No impulse, exactly zero.
    Open,
    /// An impulse inside the friction cone, no relative velocity up to the error (on a [`crate::Surface`] along the rows that
    /// have friction).
    Stick,
    /// An impulse on the boundary of the friction cone, up to the error.
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
    /// Which contact it is: the [`crate::Contact::key`] that it had in the scene.
    pub key: u32,
    /// Contact impulse `r_i` (N·s), normal first.
    pub impulse: SVector<T, D>,
    /// Relative velocity `u_i = H_i v + w_i` (m/s), normal first.
    pub velocity: SVector<T, D>,
    /// Open, stick or slip.
    pub mode: ContactMode,
}

/// What a joint row does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RowMode {
    /// A limit that is not reached; no impulse, exactly zero.
    Open,
    /// A limit that is reached, and pushes.
    AtLimit,
    /// A box at its lower bound: a motor that can do no more, friction that slips.
    AtLower,
    /// A box at its upper bound.
    AtUpper,
    /// An equality, or a box within its bounds: it holds.
    Holding,
}

impl RowMode {
    /// That of an impulse between these bounds; of a box by the argument of the natural map, `push`.
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
    /// Which row it is: the [`crate::JointRow::key`] that it had.
    pub key: u32,
    /// Impulse `λ`: N·s along a length, N·m·s about an axis.
    pub impulse: T,
    /// `s = row · v + offset + R λ`.
    pub velocity: T,
    /// At a limit, saturated, holding.
    pub mode: RowMode,
}
