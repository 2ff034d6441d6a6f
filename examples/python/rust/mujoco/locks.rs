//! What does not give way: a contact or row that a correction hardly moves is asked no more for a few steps.

use super::velocity::ASK_AGAIN;
use std::collections::HashMap;

/// What is locked: a contact or a row, by its key.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Name {
    Touch(u32),
    Row(u32),
}

/// What is locked, and for how many steps.
#[derive(Default)]
pub(super) struct Locks(pub(super) HashMap<Name, u32>);

impl Locks {
    /// A step has begun.
    pub(super) fn count_down(&mut self) {
        self.0.retain(|_, steps| {
            *steps -= 1;
            *steps > 0
        });
    }

    pub(super) fn add(&mut self, name: Name) {
        self.0.insert(name, ASK_AGAIN);
    }

    pub(super) fn hold(&self, name: Name) -> bool {
        self.0.contains_key(&name)
    }
}
