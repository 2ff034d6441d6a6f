//! Joint rows: one row over the generalised velocities each, with a law of its own.

use crate::Real;
use core::fmt;
use nalgebra::SVector;

/// One row beside the contacts, `s = row · v + offset + R λ`, and the law that binds `s` to its impulse `λ`.
///
/// [`crate::time_stepping`] makes them of what a robot has: limits, dry friction, motors, loops.
#[derive(Clone, Debug, PartialEq)]
pub struct JointRow<T, const N: usize> {
    /// The row over the velocities; a unit row for the limit of a joint.
    pub row: SVector<T, N>,
    /// What is added to `row · v`, in the unit of that.
    pub offset: T,
    /// What binds `λ` to `s`.
    pub law: RowLaw<T>,
    /// Compliance `R >= 0`, in the unit of `s` over that of `λ`; 0 is rigid.
    pub compliance: T,
    /// Which row it is, for a warm start, as [`crate::Contact::key`] (rows and contacts apart).
    pub key: u32,
}

/// The law of a joint row.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RowLaw<T> {
    /// `0 <= λ ⟂ s >= 0`: a joint's stop.
    Limit,
    /// `s = 0`, whatever `λ` that takes: a loop that is closed, a gear. Redundant ones may stand side by side.
    Equality,
    /// `lower <= λ <= upper`, at `lower` while `s > 0` and at `upper` while `s < 0`: dry friction, a motor with a
    /// torque limit.
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
        let infinity = T::ONE / T::ZERO;
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

/// Where a joint row stands in its scene, as [`crate::Scene::push_row`] has told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RowIndex {
    /// Its slot, counted with the contacts.
    pub slot: usize,
    /// Its place in the slot.
    pub row: usize,
}

impl fmt::Display for RowIndex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "joint row {} of slot {}", self.row, self.slot)
    }
}

/// What a joint row does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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
pub struct RowSolution<T> {
    /// Which row it is: the [`JointRow::key`] that it had.
    pub key: u32,
    /// Impulse `λ`: N·s along a length, N·m·s about an axis.
    pub impulse: T,
    /// `s = row · v + offset + R λ`.
    pub velocity: T,
    /// At a limit, saturated, holding.
    pub mode: RowMode,
    /// Its entry of the proof that the scene is infeasible, otherwise 0; see [`crate::Solution::certificate`].
    pub certificate: T,
}
