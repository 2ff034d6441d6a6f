//! The stack a call needs, by painting below the stack pointer and looking what is left.
#![allow(unsafe_code)] // the one way to see it

use core::hint::black_box;
use core::ptr;

const PAINT: u32 = 0xC0DE_57AC;
const WORDS: usize = 16 * 1024;

/// Bytes of stack `f` uses at its deepest, to the word.
#[inline(never)]
pub(crate) fn stack_bytes(f: impl FnOnce()) -> usize {
    let top = cortex_m::register::msp::read() as *mut u32;
    // SAFETY: below the stack pointer nothing lives, and no interrupt is enabled.
    let word = |i: usize| unsafe { top.sub(i) };
    for i in 1..=WORDS {
        // SAFETY: the board has 4 MiB of RAM, of which the stack is what the statics leave.
        unsafe { ptr::write_volatile(word(i), PAINT) };
    }
    black_box(f)();
    // SAFETY: as above.
    let untouched = |&i: &usize| unsafe { ptr::read_volatile(word(i)) } == PAINT;
    let free = (1..=WORDS).rev().take_while(untouched).count();
    (WORDS - free) * size_of::<u32>()
}
