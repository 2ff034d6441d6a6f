//! Shared by the tests and the examples: scene files, hard scenes drawn at random, and the error
//! measured by a stranger.
#![allow(dead_code, unreachable_pub)] // each user takes a part

pub mod check;
pub mod generate;
pub mod measure;
pub mod scene_file;
pub mod solve;
