//! Statuses, errors and culprits, as `stiction.h` numbers them.

use crate::header::{CALLS, number};
use core::ffi::CStr;
use stiction::{ContactMode, Error, Input};

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
    Solved = "STICTION_SOLVED",
    OutOfBudget = "STICTION_OUT_OF_BUDGET",
    PrecisionLimit = "STICTION_PRECISION_LIMIT",
    Infeasible = "STICTION_INFEASIBLE",
    Unsolved = "STICTION_UNSOLVED",
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
    DelassusNotGram = "STICTION_DELASSUS_NOT_GRAM",
    InvalidBounds = "STICTION_INVALID_BOUNDS",
    InvalidCompliance = "STICTION_INVALID_COMPLIANCE",
    NoSuchRow = "STICTION_NO_SUCH_ROW",
    InvalidParameter = "STICTION_INVALID_PARAMETER",
}

enum_of_the_header! {
    /// What a contact does, `enum stiction_mode`.
    Mode:
    Open = "STICTION_OPEN",
    Stick = "STICTION_STICK",
    Slip = "STICTION_SLIP",
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
}

/// What an error is about, `stiction_culprit`: -1 where an index has no meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Culprit {
    /// The input.
    pub input: Source,
    /// Index of the contact.
    pub contact: i32,
    /// Row of the entry.
    pub row: i32,
    /// Column of the entry.
    pub column: i32,
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
            Error::ContactListFull { .. } => Self::ContactListFull,
            Error::NoSuchContact { .. } => Self::NoSuchContact,
            Error::InvalidPenalty => Self::InvalidPenalty,
            Error::InvalidTolerance => Self::InvalidTolerance,
            Error::StaleFactor => Self::StaleFactor,
            Error::DelassusOutOfRange { .. } => Self::DelassusOutOfRange,
            Error::DelassusNotGram { .. } => Self::DelassusNotGram,
            Error::InvalidBounds { .. } => Self::InvalidBounds,
            Error::InvalidCompliance { .. } => Self::InvalidCompliance,
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

impl Culprit {
    /// Of no error.
    pub const NONE: Self = Self {
        input: Source::None,
        contact: -1,
        row: -1,
        column: -1,
    };

    fn entry(input: Source, row: usize, column: usize) -> Self {
        Self {
            input,
            row: index(row),
            column: index(column),
            ..Self::NONE
        }
    }

    fn contact(self, contact: usize) -> Self {
        Self {
            contact: index(contact),
            ..self
        }
    }
}

impl From<Error> for Culprit {
    fn from(error: Error) -> Self {
        let of = |input| Self {
            input,
            ..Self::NONE
        };
        match error {
            Error::NotFinite { input, row, column } => match input {
                Input::Mass => Self::entry(Source::Mass, row, column),
                Input::FreeImpulse => Self::entry(Source::FreeImpulse, row, column),
                Input::Jacobian { contact } => {
                    Self::entry(Source::Jacobian, row, column).contact(contact)
                }
                Input::Offset { contact } => {
                    Self::entry(Source::Offset, row, column).contact(contact)
                }
                _ => Self::entry(Source::Other, row, column),
            },
            Error::MassNotSymmetric { row, column } => Self::entry(Source::Mass, row, column),
            Error::MassNotPositiveDefinite { dof } => Self::entry(Source::Mass, dof, dof),
            Error::InvalidFriction { contact } => of(Source::Friction).contact(contact),
            Error::DelassusOutOfRange { contact } => of(Source::Jacobian).contact(contact),
            Error::NoSuchContact { contact } => of(Source::None).contact(contact),
            Error::ContactListFull { capacity } => of(Source::None).contact(capacity),
            _ => of(Source::None),
        }
    }
}

/// An error about a matrix whose rows were given for its columns.
#[must_use]
pub const fn turned(error: Error) -> Error {
    match error {
        Error::NotFinite { input, row, column } => Error::NotFinite {
            input,
            row: column,
            column: row,
        },
        error => error,
    }
}

/// An index as C has it.
fn index(index: usize) -> i32 {
    i32::try_from(index).unwrap_or(i32::MAX)
}
