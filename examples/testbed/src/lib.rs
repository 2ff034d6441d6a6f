//! What tests and tools share: scenes from files and drawn at random, the kernel in every compiled size, and the
//! error measured by a stranger.
#![allow(missing_docs)] // a tool of this repository
#![allow(clippy::cast_precision_loss)] // sizes and counts are small
#![allow(clippy::missing_errors_doc, clippy::missing_panics_doc, clippy::must_use_candidate)]

mod contact_keys;
pub mod delassus;
pub mod format;
pub mod generate;
mod judge;
pub mod kernel;
pub mod measure;
pub mod method;
pub mod mixed;
pub mod mixed_measure;
pub mod rolling;
pub mod scene_file;
pub mod solve;

pub use contact_keys::ContactKeys;
