//! The kernel in double precision, in every size of [`testbed::kernel`].
//!
//! A package for each number type: nothing else compiles the kernel, and two cores do it at once.

use testbed::kernel::{self, Kernel, Shape};

/// The kernel in the smallest compiled size that holds scenes of this shape.
///
/// # Errors
/// No size does.
pub fn kernel(shape: Shape) -> Result<Box<dyn Kernel>, String> {
    kernel::smallest::<f64>(shape)
}
