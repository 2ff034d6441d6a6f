//! Joint rows: one row over the generalised velocities each, with a law of its own.

use crate::linalg::vector::zeros;
use crate::real::Real;
use nalgebra::SVector;

/// A joint row: one speed `s = row · v + offset + compliance · λ`, and a law that binds `s` to its impulse `λ`.
///
/// [`crate::time_stepping`] makes joint rows for limits, dry friction, motors and loops.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "T: Real + serde::Serialize",
        deserialize = "T: Real + serde::Deserialize<'de>"
    ))
)]
pub struct JointRow<T, const N: usize> {
    /// The row over the `N` velocities. For the limit of a joint it is 1 or -1 at that joint and 0 elsewhere.
    pub row: SVector<T, N>,
    /// Offset, added to `row · v` (rad/s, m/s).
    pub offset: T,
    /// The law between `λ` and `s`.
    pub law: RowLaw<T>,
    /// Compliance `R >= 0`, in the unit of `s` over that of `λ`; 0 is rigid.
    pub compliance: T,
    /// A number of your own that identifies the row, as [`crate::Contact::key`]. Keys of rows and of contacts are independent.
    pub key: u32,
}

impl<T: Real, const N: usize> JointRow<T, N> {
    /// An unused joint row.
    pub(super) const fn none() -> Self {
        Self { row: zeros(), offset: T::ZERO, law: RowLaw::Limit, compliance: T::ZERO, key: 0 }
    }
}

/// The law of a joint row.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RowLaw<T> {
    /// `0 <= λ ⟂ s >= 0`: the stop of a joint. `λ` has the bounds 0 and infinity.
    Limit,
    /// `s = 0` for any `λ`: a closed loop, a gear. Redundant equalities are allowed.
    Equality,
    /// `lower <= λ <= upper`, with `λ = lower` while `s > 0` and `λ = upper` while `s < 0`: dry friction, a motor with a torque limit.
    Box {
        /// Least impulse, in the unit of `λ`.
        lower: T,
        /// Largest impulse, not below the least.
        upper: T,
    },
}

impl<T: Real> RowLaw<T> {
    /// The least and the largest `λ`.
    pub(crate) fn bounds(&self) -> [T; 2] {
        let infinity = T::INFINITY;
        match *self {
            Self::Limit => [T::ZERO, infinity],
            Self::Equality => [-infinity, infinity],
            Self::Box { lower, upper } => [lower, upper],
        }
    }

    /// Are its bounds numbers, and in order?
    pub(crate) fn is_valid(&self) -> bool {
        match *self {
            Self::Box { lower, upper } => lower.is_finite() && upper.is_finite() && lower <= upper,
            _ => true,
        }
    }
}
