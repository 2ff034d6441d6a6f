//! The library of the folder above, of the sizes in `sizes_with_rows.h`.

#[path = "../calls.rs"]
mod calls;
#[path = "../given.rs"]
mod given;
#[path = "../header.rs"]
mod header;
#[path = "../outcome.rs"]
mod outcome;
#[path = "../solver.rs"]
mod solver;
#[path = "../status.rs"]
mod status;

pub use calls::*;
pub use given::{ContactImpulse, JointRow, RowImpulse, Surface};
pub use header::{BYTES, C, D, L, N, R, Real, S};
pub use outcome::{ContactOutcome, RowOutcome, Solution, Violation};
pub use solver::{Kernel, Solver};
pub use status::{Culprit, Mode, RowMode, Status, turned};

const SIZES: &str = include_str!("sizes_with_rows.h");
