//! Random calls of the C interface, beside a kernel that gets the same in Rust; and its header beside `cbindgen`'s.
//!
//! Whatever is put in, in whatever order, with null pointers and memory that was never initialised: no panic, the status
//! and the bits of the kernel in Rust, a text for each error, nothing called solved that is not, no NaN in what may be
//! used, and nothing written beside the `stiction`.
//!
//! `rows.rs` is the same for double precision and room for joint rows and surfaces; here there is none, and calls for them are
//! refused.
//!
//! `PROPTEST_CASES=100000 cargo test --release -p c_calls` takes as long as you like. A copy of the folder above needs
//! none of this.
#![cfg(test)]
#![allow(unsafe_code)]
#![allow(clippy::cast_possible_truncation)] // budgets and places are small

mod answers;
#[path = "../../../tests/fuzz/cases.rs"]
mod cases;
mod extremes;
mod given;
mod header;
mod machine;
mod pointers;
mod scene;
mod sequences;
#[allow(dead_code)] // scenes have calls that C has not
#[path = "../../../tests/fuzz/steps.rs"]
mod steps;

use c_firmware as c;
