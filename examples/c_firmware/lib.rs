//! The kernel behind a C interface; `stiction.h` beside this file is its header and says what each call does. Sizes are those
//! of `stiction_sizes.h`.
#![cfg_attr(target_os = "none", no_std)]

mod calls;
mod given;
mod header;
mod outcome;
mod solver;
mod status;

pub use calls::*;
pub use given::{ContactImpulse, JointRow, LawNumber, ModelNumber, RowImpulse, Surface};
pub use header::{BYTES, C, D, K, L, N, R, Real, S};
pub use outcome::{ContactOutcome, RowOutcome, Solution, Violation};
pub use solver::{Kernel, Solver};
pub use status::{Culprit, Law, Mode, Model, RowMode, Source, Status, turned};

/// The sizes, in the text of `stiction_sizes.h`.
const SIZES: &str = include_str!("stiction_sizes.h");

#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe extern "C" {
        safe fn abort() -> !;
    }
    abort() // never: stiction does not panic, but the language wants a handler
}
