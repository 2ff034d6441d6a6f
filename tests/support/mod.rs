//! Shared by the tests and the examples: scenes, and the error measured by a stranger.
#![allow(dead_code)] // each user takes a part
#![allow(clippy::cast_precision_loss)] // sizes and counts are small

pub(crate) mod boxes;
pub(crate) mod measure;
pub(crate) mod method;
pub(crate) mod random;
pub(crate) mod scene_file;
