//! The library of the folder above, of the sizes in `sizes_with_rows.h`.

#[path = "../calls.rs"]
mod calls;
#[path = "../header.rs"]
mod header;
#[path = "../outcome.rs"]
mod outcome;
#[path = "../solver.rs"]
mod solver;
#[path = "../status.rs"]
mod status;

pub use calls::*;
pub use header::{BYTES, C, D, N, R, Real, S};
pub use outcome::{ContactOutcome, RowOutcome, Solution, Violation};
pub use solver::{ContactImpulse, JointRow, Kernel, RowImpulse, Solver, Surface};
pub use status::{Culprit, Mode, RowMode, Status, turned};

const SIZES: &str = include_str!("sizes_with_rows.h");
