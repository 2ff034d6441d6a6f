//! Statuses, errors and culprits, as `stiction.h` numbers them.

use super::header::{CALLS, number};
use core::ffi::CStr;
use stiction::{ContactMode, Error, Input, List, Part};

/// An enum whose numbers and names are those of an enum in `stiction.h`.
macro_rules! enum_of_the_header {
    ($(#[$doc:meta])* $Enum:ident: $($Variant:ident = $name:literal,)*) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(i32)]
        pub enum $Enum {
            $(#[doc = concat!("`", $name, "`.")] $Variant = number(CALLS, $name),)*
        }

        impl $Enum {
            /// All of them, each with its name in C.
            pub const NAMES: &[(Self, &CStr)] = &[
                $((Self::$Variant, {
                    match CStr::from_bytes_with_nul(concat!($name, "\0").as_bytes()) {
                        Ok(name) => name,
                        Err(_) => panic!("a name contains a zero"),
                    }
                }),)*
            ];
        }
    };
}

enum_of_the_header! {
    /// How a call ended, `enum stiction_status`.
    Status:
    Ok = "STICTION_OK",
    Solved = "STICTION_SOLVED",
    OutOfBudget = "STICTION_OUT_OF_BUDGET",
    PrecisionLimit = "STICTION_PRECISION_LIMIT",
    Infeasible = "STICTION_INFEASIBLE",
    Unsolved = "STICTION_UNSOLVED",
    Jammed = "STICTION_JAMMED",
    OutOfRows = "STICTION_OUT_OF_ROWS",
    Unknown = "STICTION_UNKNOWN",
    Null = "STICTION_NULL",
    NotInitialised = "STICTION_NOT_INITIALISED",
    NotFinite = "STICTION_NOT_FINITE",
    MassNotSymmetric = "STICTION_MASS_NOT_SYMMETRIC",
    MassNotPositiveDefinite = "STICTION_MASS_NOT_POSITIVE_DEFINITE",
    InvalidFriction = "STICTION_INVALID_FRICTION",
    ContactListFull = "STICTION_CONTACT_LIST_FULL",
    NoSuchContact = "STICTION_NO_SUCH_CONTACT",
    InvalidTolerance = "STICTION_INVALID_TOLERANCE",
    DelassusOutOfRange = "STICTION_DELASSUS_OVERFLOW",
    InvalidPenalty = "STICTION_INVALID_PENALTY",
    StaleFactor = "STICTION_STALE_FACTOR",
    InvalidBounds = "STICTION_INVALID_BOUNDS",
    InvalidCompliance = "STICTION_INVALID_COMPLIANCE",
    NoSuchRow = "STICTION_NO_SUCH_ROW",
    InvalidParameter = "STICTION_INVALID_PARAMETER",
    RowListFull = "STICTION_ROW_LIST_FULL",
    SurfaceListFull = "STICTION_SURFACE_LIST_FULL",
    ImpulseListFull = "STICTION_IMPULSE_LIST_FULL",
    NoSuchKey = "STICTION_NO_SUCH_KEY",
    RowOutOfRange = "STICTION_ROW_OUT_OF_RANGE",
    InvalidRowCompliance = "STICTION_INVALID_ROW_COMPLIANCE",
    InvalidLaw = "STICTION_INVALID_LAW",
    WrongSizes = "STICTION_WRONG_SIZES",
    InvalidLimit = "STICTION_INVALID_LIMIT",
    LimitsLeftOut = "STICTION_LIMITS_LEFT_OUT",
    LimitListFull = "STICTION_LIMIT_LIST_FULL",
    SceneIncomplete = "STICTION_SCENE_INCOMPLETE",
    InvalidVelocityCount = "STICTION_INVALID_VELOCITY_COUNT",
    InvalidModel = "STICTION_INVALID_MODEL",
    NoSolution = "STICTION_NO_SOLUTION",
    LimitKeyTaken = "STICTION_LIMIT_KEY_TAKEN",
}

enum_of_the_header! {
    /// The law of contacts that a solve obeys, `enum stiction_model`.
    Model:
    Coulomb = "STICTION_COULOMB",
    ConvexRelaxation = "STICTION_CONVEX_RELAXATION",
}

enum_of_the_header! {
    /// What a contact does, `enum stiction_mode`.
    Mode:
    Open = "STICTION_OPEN",
    Stick = "STICTION_STICK",
    Slip = "STICTION_SLIP",
}

enum_of_the_header! {
    /// What binds the impulse of a joint row, `enum stiction_law`.
    Law:
    Limit = "STICTION_LIMIT",
    Equality = "STICTION_EQUALITY",
    Box = "STICTION_BOX",
}

enum_of_the_header! {
    /// What a joint row does, `enum stiction_row_mode`.
    RowMode:
    Open = "STICTION_ROW_OPEN",
    AtLimit = "STICTION_ROW_AT_LIMIT",
    AtLower = "STICTION_ROW_AT_LOWER",
    AtUpper = "STICTION_ROW_AT_UPPER",
    Holding = "STICTION_ROW_HOLDING",
}

enum_of_the_header! {
    /// Which input an error is about, `enum stiction_input`.
    Source:
    None = "STICTION_INPUT_NONE",
    Mass = "STICTION_INPUT_MASS",
    FreeImpulse = "STICTION_INPUT_FREE_IMPULSE",
    Jacobian = "STICTION_INPUT_JACOBIAN",
    Offset = "STICTION_INPUT_OFFSET",
    Friction = "STICTION_INPUT_FRICTION",
    Other = "STICTION_INPUT_OTHER",
    JointRow = "STICTION_INPUT_JOINT_ROW",
    Bounds = "STICTION_INPUT_BOUNDS",
    Compliance = "STICTION_INPUT_COMPLIANCE",
    InitialImpulse = "STICTION_INPUT_INITIAL_IMPULSE",
    InitialRowImpulse = "STICTION_INPUT_INITIAL_ROW_IMPULSE",
    Limit = "STICTION_INPUT_LIMIT",
    Contact = "STICTION_INPUT_CONTACT",
    Velocities = "STICTION_INPUT_VELOCITIES",
}

/// What an error is about, `stiction_culprit`: -1 where an index has no meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Culprit {
    /// The input.
    pub input: Source,
    /// Index of the contact.
    pub contact: i32,
    /// Index of the joint row.
    pub joint_row: i32,
    /// Row of the entry.
    pub row: i32,
    /// Column of the entry.
    pub column: i32,
    /// Key of the contact or the joint row.
    pub key: i64,
}

impl From<stiction::Status> for Status {
    fn from(status: stiction::Status) -> Self {
        use stiction::Status as Rust;
        match status {
            Rust::Unsolved => Self::Unsolved,
            Rust::Solved => Self::Solved,
            Rust::OutOfBudget => Self::OutOfBudget,
            Rust::PrecisionLimit => Self::PrecisionLimit,
            Rust::Infeasible => Self::Infeasible,
            Rust::Jammed => Self::Jammed,
            Rust::OutOfRows => Self::OutOfRows,
            _ => Self::Unknown,
        }
    }
}

impl From<Error> for Status {
    fn from(error: Error) -> Self {
        match error {
            Error::NotFinite { .. } => Self::NotFinite,
            Error::MassNotSymmetric { .. } => Self::MassNotSymmetric,
            Error::MassNotPositiveDefinite { .. } => Self::MassNotPositiveDefinite,
            Error::InvalidFriction { .. } => Self::InvalidFriction,
            Error::ListFull { list, .. } => match list {
                List::Contacts => Self::ContactListFull,
                List::Surfaces => Self::SurfaceListFull,
                List::Rows => Self::RowListFull,
                List::InitialImpulses | List::InitialRowImpulses => Self::ImpulseListFull,
                _ => Self::Unknown,
            },
            Error::InvalidVelocityCount { .. } => Self::InvalidVelocityCount,
            Error::NoSuchContact { .. } => Self::NoSuchContact,
            Error::InvalidPenalty => Self::InvalidPenalty,
            Error::InvalidTolerance => Self::InvalidTolerance,
            Error::StaleFactor => Self::StaleFactor,
            Error::NoSolution | Error::SceneChanged => Self::NoSolution,
            Error::DelassusOutOfRange { .. } => Self::DelassusOutOfRange,
            Error::RowOutOfRange { .. } => Self::RowOutOfRange,
            Error::InvalidBounds { .. } => Self::InvalidBounds,
            Error::InvalidCompliance { .. } => Self::InvalidCompliance,
            Error::InvalidRowCompliance { .. } => Self::InvalidRowCompliance,
            Error::InvalidLimit { .. } => Self::InvalidLimit,
            Error::LimitKeyTaken { .. } => Self::LimitKeyTaken,
            Error::LimitsLeftOut => Self::LimitsLeftOut,
            Error::SceneIncomplete { .. } => Self::SceneIncomplete,
            Error::NoSuchRow { .. } => Self::NoSuchRow,
            Error::InvalidParameter { .. } => Self::InvalidParameter,
            _ => Self::Unknown,
        }
    }
}

impl From<ContactMode> for Mode {
    fn from(mode: ContactMode) -> Self {
        match mode {
            ContactMode::Open => Self::Open,
            ContactMode::Stick => Self::Stick,
            ContactMode::Slip => Self::Slip,
        }
    }
}

impl From<stiction::RowMode> for RowMode {
    fn from(mode: stiction::RowMode) -> Self {
        use stiction::RowMode as Rust;
        match mode {
            Rust::Open => Self::Open,
            Rust::AtLimit => Self::AtLimit,
            Rust::AtLower => Self::AtLower,
            Rust::AtUpper => Self::AtUpper,
            Rust::Holding => Self::Holding,
        }
    }
}

impl Culprit {
    /// Of no error.
    pub const NONE: Self =
        Self { input: Source::None, contact: -1, joint_row: -1, row: -1, column: -1, key: -1 };

    const fn of(input: Source) -> Self {
        Self { input, ..Self::NONE }
    }

    fn entry(input: Source, row: usize, column: usize) -> Self {
        Self { input, row: index(row), column: index(column), ..Self::NONE }
    }

    fn contact(self, contact: usize) -> Self {
        Self { contact: index(contact), ..self }
    }

    fn joint_row(self, row: usize) -> Self {
        Self { joint_row: index(row), ..self }
    }

    /// A limit, or how many there is room for.
    pub(super) fn limit(place: usize) -> Self {
        Self::of(Source::Limit).joint_row(place)
    }

    fn key(self, key: u32) -> Self {
        Self { key: i64::from(key), ..self }
    }
}

impl From<Error> for Culprit {
    fn from(error: Error) -> Self {
        let of = Self::of;
        match error {
            Error::NotFinite { input, row, column } => match input {
                Input::Mass => Self::entry(Source::Mass, row, column),
                Input::FreeImpulse => Self::entry(Source::FreeImpulse, row, column),
                Input::Jacobian { contact } => Self::entry(Source::Jacobian, row, column).contact(contact),
                Input::Offset { contact } => Self::entry(Source::Offset, row, column).contact(contact),
                Input::InitialImpulse { contact } => {
                    Self::entry(Source::InitialImpulse, row, column).contact(contact)
                }
                Input::InitialRowImpulse { row: joint } => {
                    Self::entry(Source::InitialRowImpulse, row, column).joint_row(joint)
                }
                Input::JointRow { row: joint } => Self::entry(Source::JointRow, row, column).joint_row(joint),
                Input::Limit { limit } => Self::entry(Source::Limit, row, column).joint_row(limit),
                _ => Self::entry(Source::Other, row, column),
            },
            Error::SceneIncomplete { part } => of(match part {
                Part::Mass => Source::Mass,
                Part::Contact => Source::Contact,
                Part::JointRow => Source::JointRow,
                _ => Source::Other,
            }),
            Error::MassNotSymmetric { row, column } => Self::entry(Source::Mass, row, column),
            Error::MassNotPositiveDefinite { dof } => Self::entry(Source::Mass, dof, dof),
            Error::InvalidFriction { contact, .. } => of(Source::Friction).contact(contact),
            Error::DelassusOutOfRange { contact } => of(Source::Jacobian).contact(contact),
            Error::InvalidVelocityCount { capacity, .. } => {
                Self { row: index(capacity), ..of(Source::Velocities) }
            }
            Error::NoSuchContact { contact } => of(Source::None).contact(contact),
            Error::NoSuchRow { row } => of(Source::None).joint_row(row),
            Error::RowOutOfRange { key } => of(Source::JointRow).key(key),
            Error::InvalidBounds { row } => of(Source::Bounds).joint_row(row),
            Error::InvalidCompliance { contact, .. } => of(Source::Compliance).contact(contact),
            Error::InvalidRowCompliance { row } => of(Source::Compliance).joint_row(row),
            Error::InvalidLimit { limit } | Error::LimitKeyTaken { limit } => Self::limit(limit),
            Error::ListFull { list, capacity } => match list {
                List::Contacts | List::Surfaces => of(Source::None).contact(capacity),
                List::InitialImpulses => of(Source::InitialImpulse).contact(capacity),
                List::Rows => of(Source::None).joint_row(capacity),
                List::InitialRowImpulses => of(Source::InitialRowImpulse).joint_row(capacity),
                _ => of(Source::Other),
            },
            _ => of(Source::None),
        }
    }
}

/// An error about a matrix whose rows were given for its columns.
#[must_use]
pub const fn turned(error: Error) -> Error {
    match error {
        Error::NotFinite { input, row, column } => Error::NotFinite { input, row: column, column: row },
        error => error,
    }
}

/// An index as C has it.
fn index(index: usize) -> i32 {
    i32::try_from(index).unwrap_or(i32::MAX)
}
