//! Pointers as C gives them: to what they should point to, null, or to memory that was never initialised.

use crate::c::{BYTES, Solver};
use proptest::prelude::*;
use std::ptr::null;

/// What is wrong with a call.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fault {
    No,
    /// The pointer to the `stiction` is null.
    NullSolver,
    /// The first, second or third other pointer is null.
    Null(u8),
    /// The `stiction` was never initialised.
    Raw,
    /// It is initialised once more before the call.
    Again,
    /// The law of a joint row is none.
    Law(u32),
}

pub(crate) fn fault() -> impl Strategy<Value = Fault> {
    prop_oneof![
        30 => Just(Fault::No),
        1 => Just(Fault::NullSolver),
        2 => (1..4_u8).prop_map(Fault::Null),
        1 => Just(Fault::Raw),
        1 => Just(Fault::Again),
        2 => prop_oneof![Just(3_u32), 3..=u32::MAX].prop_map(Fault::Law),
    ]
}

impl Fault {
    /// The number of a law, unless this is to be none.
    pub(crate) fn law(self, law: u8) -> u32 {
        match self {
            Self::Law(none) => none,
            _ => u32::from(law),
        }
    }

    /// A pointer, unless this one is to be null.
    pub(crate) fn pointer<T>(self, which: u8, to: &[T]) -> *const T {
        if self == Self::Null(which) { null() } else { to.as_ptr() }
    }
}

/// The size of a `stiction` in C.
pub(crate) const ROOM: usize = 8 * WORDS;
const WORDS: usize = BYTES.div_ceil(8);
const MARK: u64 = 0xA5A5_A5A5_A5A5_A5A5;

/// What C declares as `stiction`, between two words that nobody may change.
#[repr(C)]
pub(crate) struct Memory {
    before: u64,
    stiction: [u64; WORDS],
    after: u64,
}

impl Memory {
    /// Garbage.
    pub(crate) fn new() -> Box<Self> {
        Box::new(Self { before: MARK, stiction: [MARK; WORDS], after: MARK })
    }

    pub(crate) fn solver(&mut self) -> *mut Solver {
        (&raw mut self.stiction).cast()
    }

    pub(crate) fn is_unharmed(&self) -> bool {
        self.before == MARK && self.after == MARK
    }
}
