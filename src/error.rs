//! What can be wrong with the data of a solve.

use crate::parameter::Parameter;
use core::fmt;

/// Which input of a scene an [`Error`] speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Input {
    /// The generalised mass matrix `M`.
    Mass,
    /// The free impulse `M v_free`.
    FreeImpulse,
    /// The impulse `i` that a solve was to start at.
    InitialImpulse {
        /// Its place in the list.
        contact: usize,
    },
    /// The impulse of a joint row that a solve was to start at.
    InitialRowImpulse {
        /// Its place in the list.
        row: usize,
    },
    /// The Jacobian `H_i` of contact `i`.
    Jacobian {
        /// Index `i` of the contact.
        contact: usize,
    },
    /// The offset `w_i` of contact `i`.
    Offset {
        /// Index `i` of the contact.
        contact: usize,
    },
    /// A joint row; its offset stands as entry `N` behind those of the `N` velocities.
    JointRow {
        /// Its index.
        row: usize,
    },
    /// One of the limits of [`crate::Kernel::solve_with_limits`].
    Limit {
        /// Its place in the list.
        limit: usize,
    },
}

/// Which list an [`Error::ListFull`] speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum List {
    /// The contacts of a scene.
    Contacts,
    /// The contacts of a scene that may have a surface of their own: its first `S`.
    Surfaces,
    /// The joint rows of a scene; limits of [`crate::Kernel::solve_with_limits`] that are reached stand behind them.
    Rows,
    /// The impulses of contacts that a solve was to start at.
    InitialImpulses,
    /// The impulses of joint rows that a solve was to start at.
    InitialRowImpulses,
}

/// Part of a scene that an [`Error::SceneIncomplete`] speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Part {
    /// The generalised mass matrix `M`, or the `W` in its place.
    Mass,
    /// A contact.
    Contact,
    /// A joint row.
    JointRow,
}

/// What is wrong with the data of a call; it names the culprit. [`crate::guide::error`] says what a control loop does then.
///
/// The call that returns it changes nothing, and the last solution stays. Only what a scene refuses as it is filled is missing there
/// ([`Self::SceneIncomplete`]). After [`crate::Factor::prepare`] (and so
/// [`crate::Kernel::solve`]) the factor is empty, and [`crate::Kernel::solve_with_limits`] may leave no solution
/// ([`crate::Status::Unsolved`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Error {
    /// An entry is NaN or infinite.
    NotFinite {
        /// The matrix or vector it stands in.
        input: Input,
        /// Row of the entry.
        row: usize,
        /// Column of the entry, 0 in a vector.
        column: usize,
    },
    /// `M[row][column]` and `M[column][row]` differ by more than [`crate::Scene::set_mass`] overlooks.
    MassNotSymmetric {
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        column: usize,
    },
    /// `M` is not positive definite: it has no Cholesky factor, or one whose reciprocals overflow.
    MassNotPositiveDefinite {
        /// Generalised velocity at which factorisation failed; it runs from the last to the first.
        dof: usize,
    },
    /// A friction coefficient is negative, NaN, infinite, or so large that its square overflows; or that of a surface is to
    /// become 0 or cease to be.
    InvalidFriction {
        /// Index of the contact.
        contact: usize,
        /// Row of the contact that it is of: 1 or 2 of a tangent (1 of [`crate::Contact::mu`]), 3 of the spin, 4 or 5 of a roll.
        row: usize,
    },
    /// No room for one more.
    ListFull {
        /// Where there is no room.
        list: List,
        /// How many it can hold.
        capacity: usize,
    },
    /// There is nothing with this key.
    NoSuchKey {
        /// The key asked for.
        key: u32,
    },
    /// There is no contact of this index.
    NoSuchContact {
        /// The index asked for.
        contact: usize,
    },
    /// The penalty `rho` is not a positive number the factorisation can use.
    InvalidPenalty,
    /// The tolerance asked for is NaN, infinite or negative.
    InvalidTolerance,
    /// A part of the scene was refused as it was filled, and is missing. Contacts and joint rows: call [`crate::Scene::clear`] (or
    /// [`crate::Scene::clear_contacts`], [`crate::Scene::clear_rows`]) and add them again. A mass matrix: set another one.
    SceneIncomplete {
        /// What is missing.
        part: Part,
    },
    /// The factor is not that of the scene's current `M`, `H` and number of contacts; prepare it.
    StaleFactor,
    /// `W_ii = H_i M⁻¹ H_iᵀ` of a contact is too large for the number type, or that of its normal too small, though its row
    /// is not zero. It may be `M` that is to blame, if that is singular but for rounding or near the end of the range.
    DelassusOutOfRange {
        /// Index of the contact.
        contact: usize,
    },
    /// `W_jj = row M⁻¹ rowᵀ + R` of a joint row is too large for the number type, or too small, though the row is not zero.
    RowOutOfRange {
        /// [`crate::JointRow::key`] of the row.
        key: u32,
    },
    /// The bounds of a joint row are not finite, or the lower one is above the upper one.
    InvalidBounds {
        /// Index of the row.
        row: usize,
    },
    /// A compliance of a contact is negative or not finite.
    InvalidCompliance {
        /// Index of the contact.
        contact: usize,
        /// Row of the contact: 0 of the normal, 1 of the tangents.
        row: usize,
    },
    /// The compliance of a joint row is negative or not finite.
    InvalidRowCompliance {
        /// Index of the row.
        row: usize,
    },
    /// A limit of [`crate::Kernel::solve_with_limits`] has bounds that no impulse fulfils, or a compliance that is negative or not
    /// finite.
    InvalidLimit {
        /// Index of the limit.
        limit: usize,
    },
    /// The solve that was paused had limits: [`crate::Kernel::solve_with_limits`] goes on with them.
    LimitsLeftOut,
    /// There is no solution to be differentiated: nothing was solved, the scene has none, or its contacts and joint rows are others.
    NoSolution,
    /// There is no joint row of this index.
    NoSuchRow {
        /// The index asked for.
        row: usize,
    },
    /// An argument of a helper of [`crate::time_stepping`] has no meaning, or makes its result overflow.
    InvalidParameter {
        /// Which one; its text says what is asked of it.
        parameter: Parameter,
    },
}

impl fmt::Display for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Mass => write!(f, "mass matrix M"),
            Self::FreeImpulse => write!(f, "free impulse"),
            Self::InitialImpulse { contact } => write!(f, "initial impulse {contact}"),
            Self::InitialRowImpulse { row } => write!(f, "initial impulse {row} of joint rows"),
            Self::Jacobian { contact } => write!(f, "Jacobian H of contact {contact}"),
            Self::Offset { contact } => write!(f, "offset w of contact {contact}"),
            Self::JointRow { row } => write!(f, "joint row {row}"),
            Self::Limit { limit } => write!(f, "limit {limit}"),
        }
    }
}

impl fmt::Display for List {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Contacts => "contacts",
            Self::Surfaces => "contacts with surfaces",
            Self::Rows => "joint rows",
            Self::InitialImpulses => "initial impulses",
            Self::InitialRowImpulses => "initial impulses of joint rows",
        })
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mass => "mass matrix M",
            Self::Contact => "contact",
            Self::JointRow => "joint row",
        })
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite { input, row, column } => {
                write!(f, "{input}: entry ({row}, {column}) is not finite")
            }
            Self::MassNotSymmetric { row, column } => {
                write!(f, "mass matrix M is not symmetric at ({row}, {column})")
            }
            Self::MassNotPositiveDefinite { dof } => {
                write!(f, "mass matrix M is not positive definite at dof {dof}")
            }
            Self::InvalidFriction { contact, row } => write!(
                f,
                "friction coefficient mu of contact {contact}, row {row}, is negative, not finite or too large, or its surface cannot take it"
            ),
            Self::ListFull { list, capacity } => {
                write!(f, "{list} are full (room for {capacity})")
            }
            Self::NoSuchKey { key } => write!(f, "there is nothing with key {key}"),
            Self::NoSuchContact { contact } => write!(f, "there is no contact {contact}"),
            Self::InvalidPenalty => write!(f, "penalty rho is not a usable positive number"),
            Self::InvalidTolerance => write!(f, "tolerance is negative or not finite"),
            Self::SceneIncomplete { part } => {
                write!(f, "scene is incomplete: a {part} was refused")
            }
            Self::StaleFactor => write!(
                f,
                "factor is not that of the scene's M and H as they are now"
            ),
            Self::DelassusOutOfRange { contact } => {
                write!(f, "H M⁻¹ Hᵀ of contact {contact} overflows or vanishes")
            }
            Self::RowOutOfRange { key } => {
                write!(
                    f,
                    "row M⁻¹ rowᵀ of the joint row with key {key} overflows or vanishes"
                )
            }
            Self::InvalidBounds { row } => {
                write!(
                    f,
                    "bounds of joint row {row} are not finite or not in order"
                )
            }
            Self::InvalidCompliance { contact, row } => {
                write!(
                    f,
                    "compliance of contact {contact}, row {row}, is negative or not finite"
                )
            }
            Self::InvalidRowCompliance { row } => {
                write!(f, "compliance of joint row {row} is negative or not finite")
            }
            Self::InvalidLimit { limit } => {
                write!(f, "bounds or compliance of limit {limit} are invalid")
            }
            Self::LimitsLeftOut => write!(f, "the solve that was paused had limits"),
            Self::NoSolution => write!(f, "there is no solution of the scene to be differentiated"),
            Self::NoSuchRow { row } => write!(f, "there is no joint row {row}"),
            Self::InvalidParameter { parameter } => write!(f, "{parameter}"),
        }
    }
}

impl core::error::Error for Error {}
