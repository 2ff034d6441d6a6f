//! Faults in the data of a solve.

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
    /// An initial impulse of a contact.
    InitialImpulse {
        /// Index of the impulse in its list.
        contact: usize,
    },
    /// An initial impulse of a joint row.
    InitialRowImpulse {
        /// Index of the impulse in its list.
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
    /// A joint row: entries 0 to `N - 1` are its row over the velocities, entry `N` is its offset.
    JointRow {
        /// Index of the row.
        row: usize,
    },
    /// One of the limits of [`crate::Kernel::solve_with_limits`].
    Limit {
        /// Index of the limit.
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
    /// The surfaces of contacts, of which a scene has room for `S`.
    Surfaces,
    /// The joint rows of a scene, and behind them the reached limits of [`crate::Kernel::solve_with_limits`].
    Rows,
    /// The initial impulses of contacts.
    InitialImpulses,
    /// The initial impulses of joint rows.
    InitialRowImpulses,
}

/// Part of a scene that an [`Error::SceneIncomplete`] speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Part {
    /// The generalised mass matrix `M`.
    Mass,
    /// A contact.
    Contact,
    /// A joint row.
    JointRow,
}

/// A fault in the data of a call, with its culprit. [`crate::guide::tick`] says how a control loop responds.
///
/// The last solution stays, with one exception: [`crate::Kernel::solve_with_limits`] may leave none ([`crate::Status::Unsolved`]). A scene
/// lacks the contact, joint row or mass matrix that it refused ([`Self::SceneIncomplete`]); any other setter that refuses leaves the old value.
/// After a failed [`crate::Factor::prepare`] (and so [`crate::Kernel::solve`]) the factor is empty.
///
/// | stage | errors |
/// |---|---|
/// | filling a [`crate::Scene`] | [`Self::NotFinite`], [`Self::MassNotSymmetric`], [`Self::InvalidFriction`], [`Self::InvalidBounds`], [`Self::InvalidCompliance`], [`Self::InvalidRowCompliance`], [`Self::ListFull`], [`Self::InvalidVelocityCount`], [`Self::NoSuchContact`], [`Self::NoSuchRow`] |
/// | [`crate::Kernel::solve`] | [`Self::SceneIncomplete`], [`Self::NotFinite`] of the free impulse, [`Self::InvalidTolerance`], [`Self::MassNotPositiveDefinite`], [`Self::DelassusOutOfRange`], [`Self::RowOutOfRange`] |
/// | [`crate::Kernel::solve_with_limits`]; `resume` and `advance` after it | [`Self::LimitKeyTaken`], [`Self::InvalidLimit`], [`Self::NotFinite`], [`Self::ListFull`]; [`Self::LimitsLeftOut`] |
/// | [`crate::Kernel::derivative`] | [`Self::NoSolution`], [`Self::SceneChanged`], [`Self::StaleFactor`] |
/// | [`crate::Kernel::least_impulses`], `slip_reserve`, `load_reserve` | these, [`Self::InvalidTolerance`], [`Self::NotFinite`] of the load |
/// | [`crate::Kernel::rest_reserve`] | those of a solve, [`Self::NoSolution`] if numbers overflow |
/// | a [`crate::Solver`] or [`crate::AdmmSolver`] with a factor of its own | [`Self::StaleFactor`], [`Self::InvalidPenalty`] |
/// | helpers of [`crate::time_stepping`] | [`Self::InvalidParameter`] |
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
    /// `M` is not positive definite, or so nearly singular that the reciprocals of its Cholesky factor overflow.
    MassNotPositiveDefinite {
        /// Index of the velocity at which factorisation failed. It runs from the last velocity to the first.
        dof: usize,
    },
    /// A friction coefficient is negative, NaN, infinite, or so large that its square overflows. Or [`crate::Scene::set_friction`] would change
    /// the coefficient of a surface to 0 or from 0.
    InvalidFriction {
        /// Index of the contact.
        contact: usize,
        /// Row of the contact: 1 or 2 for a tangent (1 for [`crate::Contact::mu`]), 3 for spin, 4 or 5 for roll.
        row: usize,
    },
    /// A list has no room for one more.
    ListFull {
        /// The list.
        list: List,
        /// How many entries it can hold.
        capacity: usize,
    },
    /// A scene cannot have this number of velocities ([`crate::Scene::set_velocities`]): 0, or more than there is room for.
    InvalidVelocityCount {
        /// The number asked for.
        velocities: usize,
        /// The largest number, `N`.
        capacity: usize,
    },
    /// There is no contact of this index.
    NoSuchContact {
        /// The index asked for.
        contact: usize,
    },
    /// The penalty `rho` is not a positive number the factorisation can use.
    InvalidPenalty,
    /// [`crate::Settings::tolerance`] or [`crate::Settings::still`] is NaN, infinite or negative.
    InvalidTolerance,
    /// The scene has refused a part, which is now missing. For a contact or joint row call [`crate::Scene::clear`] (or
    /// [`crate::Scene::clear_contacts`], [`crate::Scene::clear_rows`]) and fill it again. For a mass
    /// matrix set another one.
    SceneIncomplete {
        /// The missing part.
        part: Part,
    },
    /// The factor is stale: `M`, a Jacobian, a compliance, or the contacts and joint rows in use have changed. Call [`crate::Factor::prepare`].
    StaleFactor,
    /// `W_ii = H_i M⁻¹ H_iᵀ` of a contact overflows, or its normal entry vanishes though the normal row of `H_i` is not zero. The cause may be an `M` that
    /// is nearly singular or near the end of the range.
    DelassusOutOfRange {
        /// Index of the contact.
        contact: usize,
    },
    /// `W_jj = row M⁻¹ rowᵀ + compliance` of a joint row overflows, or vanishes though the row is not zero.
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
        /// Row of the contact: 0 for the normal, 1 for the tangents.
        row: usize,
    },
    /// The compliance of a joint row is negative or not finite.
    InvalidRowCompliance {
        /// Index of the row.
        row: usize,
    },
    /// A limit of [`crate::Kernel::solve_with_limits`] has bounds that no impulse satisfies, or a compliance that is negative or not finite.
    InvalidLimit {
        /// Index of the limit.
        limit: usize,
    },
    /// A limit of [`crate::Kernel::solve_with_limits`] has the key of an earlier limit or of a joint row of the scene.
    LimitKeyTaken {
        /// Index of the limit.
        limit: usize,
    },
    /// The paused solve has limits: [`crate::Kernel::resume_with_limits`] or [`crate::Kernel::advance_with_limits`] continues it.
    LimitsLeftOut,
    /// There is no usable solution of which a derivative or least impulses could be computed: none, one whose error is above the tolerance, or
    /// numbers overflow.
    NoSolution,
    /// The solution is not that of the scene as it is: `M`, a Jacobian, an offset, friction, compliance, a joint row or a key has changed since the
    /// solve. Or the solve has reached limits of [`crate::Kernel::solve_with_limits`], which the scene lacks.
    SceneChanged,
    /// There is no joint row of this index.
    NoSuchRow {
        /// The index asked for.
        row: usize,
    },
    /// An argument of a helper of [`crate::time_stepping`] has no meaning, or makes its result overflow.
    InvalidParameter {
        /// The argument; its `Display` text says what is required.
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
            Self::InvalidVelocityCount { velocities, capacity } => {
                write!(f, "a scene cannot have {velocities} velocities (1 to {capacity})")
            }
            Self::NoSuchContact { contact } => write!(f, "there is no contact {contact}"),
            Self::InvalidPenalty => write!(f, "penalty rho is not a usable positive number"),
            Self::InvalidTolerance => {
                write!(f, "tolerance or speed of what is still is negative or not finite")
            }
            Self::SceneIncomplete { part } => {
                write!(f, "scene is incomplete: a {part} was refused")
            }
            Self::StaleFactor => write!(f, "factor is not that of the scene's M and H as they are now"),
            Self::DelassusOutOfRange { contact } => {
                write!(f, "H M⁻¹ Hᵀ of contact {contact} overflows or vanishes")
            }
            Self::RowOutOfRange { key } => {
                write!(f, "row M⁻¹ rowᵀ of the joint row with key {key} overflows or vanishes")
            }
            Self::InvalidBounds { row } => {
                write!(f, "bounds of joint row {row} are not finite or not in order")
            }
            Self::InvalidCompliance { contact, row } => {
                write!(f, "compliance of contact {contact}, row {row}, is negative or not finite")
            }
            Self::InvalidRowCompliance { row } => {
                write!(f, "compliance of joint row {row} is negative or not finite")
            }
            Self::InvalidLimit { limit } => {
                write!(f, "bounds or compliance of limit {limit} are invalid")
            }
            Self::LimitKeyTaken { limit } => {
                write!(f, "limit {limit} has the key of another limit or of a joint row")
            }
            Self::LimitsLeftOut => write!(f, "the paused solve has limits, and this call leaves them out"),
            Self::NoSolution => {
                write!(f, "there is no solution with an error within the tolerance, or numbers overflow")
            }
            Self::SceneChanged => write!(
                f,
                "the scene is not that of the solution: it has changed since, or limits were reached"
            ),
            Self::NoSuchRow { row } => write!(f, "there is no joint row {row}"),
            Self::InvalidParameter { parameter } => write!(f, "{parameter}"),
        }
    }
}

impl core::error::Error for Error {}
