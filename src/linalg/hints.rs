//! What a compiler is told of loops on a microcontroller, where flash counts; on a desktop nothing.

use core::hint::black_box;

/// A slice of whose length the compiler knows nothing where flash counts: loops over dofs or contacts
/// that it unrolls are several times as large and hardly faster.
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

/// Keeps the loop around it from being unrolled where flash counts, at no instruction: a compiler
/// unrolls loops over dofs or contacts fourfold, which makes them larger and hardly faster.
///
/// (For the same target functions stay one copy each with a stack frame of its own: `inline(never)`.)
#[inline]
pub(crate) fn rolled() {
    if cfg!(target_os = "none") {
        black_box(());
    }
}
