//! Pages to read beside the code.

#[doc = include_str!("guide/method.md")]
pub mod method {}

#[doc = include_str!("guide/rows.md")]
pub mod rows {}

#[doc = include_str!("guide/error.md")]
pub mod error {}

#[doc = include_str!("guide/numbers.md")]
pub mod numbers {}

#[doc = include_str!("guide/firmware.md")]
pub mod firmware {}

#[doc = include_str!("guide/tuning.md")]
pub mod tuning {}

#[doc = include_str!("guide/note.md")]
pub mod note {}
