//! What does not give way: a contact or row that a correction hardly moves is asked no more for a few steps.

use super::islands::Island;
use super::velocity::{ASK_AGAIN, Scene};
use std::collections::HashMap;

/// What is locked, by what stays the same from step to step: a contact by its geoms and its number among those of these, a row by its key.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Name {
    Touch([usize; 2], usize),
    Row(u32),
}

impl Name {
    /// The name of a contact of an island.
    pub(super) fn of_touch(scene: &Scene<'_>, island: &Island, number: usize) -> Self {
        let geoms = |place: usize| scene.touches[place].face.geoms;
        let own = geoms(island.touches[number]);
        let before = &island.touches[..number];
        Self::Touch(own, before.iter().filter(|&&place| geoms(place) == own).count())
    }
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

    pub(super) fn holds_touch(&self, scene: &Scene<'_>, island: &Island, number: usize) -> bool {
        !self.0.is_empty() && self.0.contains_key(&Name::of_touch(scene, island, number))
    }

    pub(super) fn holds_row(&self, key: u32) -> bool {
        self.0.contains_key(&Name::Row(key))
    }
}
