//! `lib.rs` once more, for double precision and with room for joint rows and surfaces.
#![allow(unsafe_code)]
#![allow(clippy::cast_possible_truncation)] // budgets and places are small

mod answers;
#[allow(dead_code, unreachable_pub, missing_docs, clippy::pedantic, clippy::unnecessary_cast)] // as the folder above is checked by itself
#[path = "with_rows.rs"]
mod c;
#[path = "../../../tests/fuzz/cases.rs"]
mod cases;
mod extremes;
mod given;
mod machine;
mod pointers;
mod scene;
mod sequences;
#[allow(dead_code)] // scenes have calls that C has not
#[path = "../../../tests/fuzz/steps.rs"]
mod steps;
