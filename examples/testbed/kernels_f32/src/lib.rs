//! The kernel in single precision, in every size of [`testbed::kernel`].
//!
//! A package for each number type: nothing else compiles the kernel, and two cores do it at once.

use stiction::Settings;
use testbed::kernel::{self, Answer, Kernel, Shape};
use testbed::mixed::{self, MixedFile, Times};

/// The kernel in the smallest compiled size that holds scenes of this shape.
///
/// # Errors
/// No size does.
pub fn kernel(shape: Shape) -> Result<Box<dyn Kernel>, String> {
    kernel::smallest::<f32>(shape)
}

/// Solves a scene of contacts and joint rows, so many times from nothing.
///
/// # Errors
/// No compiled size holds it, or the kernel refuses it.
pub fn solve_mixed(
    file: &MixedFile,
    settings: &Settings<f64>,
    repeat: u32,
) -> Result<(Answer, Times), String> {
    mixed::solve::<f32>(file, settings, repeat)
}

/// Solves scenes of contacts and joint rows one after the other, each with a warm start from the last.
#[must_use]
pub fn solve_all(files: &[MixedFile], settings: &Settings<f64>) -> Vec<Result<Answer, String>> {
    mixed::solve_all::<f32>(files, settings)
}
