//! Shared by the tests and the examples: scene files and the error measured by a stranger.
#![allow(dead_code)] // each user takes a part

pub mod measure;
pub mod scene_file;
