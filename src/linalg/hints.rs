//! Hints that stop the compiler from unrolling on microcontrollers; no effect on desktops.

use core::hint::black_box;

/// A slice of a length that the compiler does not know on microcontrollers: unrolled loops over dofs or contacts are
/// several times as large there and hardly faster.
#[inline]
pub(crate) fn opaque<T>(slice: &[T]) -> &[T] {
    if cfg!(target_os = "none") {
        black_box(slice)
    } else {
        slice
    }
}

/// [`opaque`], to be written to.
#[inline]
pub(crate) fn opaque_mut<T>(slice: &mut [T]) -> &mut [T] {
    if cfg!(target_os = "none") {
        black_box(slice)
    } else {
        slice
    }
}

/// Stops the loop around it from being unrolled on microcontrollers, at no instruction: unrolled fourfold, it would be larger
/// and hardly faster.
///
/// (For the same target functions stay one copy each with a stack frame of its own: `inline(never)`.)
#[inline]
pub(crate) fn rolled() {
    if cfg!(target_os = "none") {
        black_box(());
    }
}
