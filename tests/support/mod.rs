//! Shared by the tests and the examples: scenes from files, drawn at random and built by hand, and
//! the error measured by a stranger.
#![allow(dead_code, unreachable_pub)] // each user takes a part
#![allow(clippy::cast_precision_loss)] // sizes and counts are small

pub mod boxes;
pub mod check;
pub mod contact_keys;
pub mod generate;
pub mod measure;
pub mod method;
pub mod motion;
pub mod random;
pub mod scene_file;
pub mod solve;
