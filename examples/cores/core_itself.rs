//! Start-up, and a word to the debugger that QEMU is. Data stand in RAM already, as QEMU loads them there: no board does.
#![allow(unsafe_code)]

use core::fmt;
use core::panic::PanicInfo;

/// Writes to the console of QEMU.
pub(crate) struct Out;

impl fmt::Write for Out {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.bytes().for_each(|byte| call(WRITE_CHARACTER, (&raw const byte).addr()));
        Ok(())
    }
}

const WRITE_CHARACTER: usize = 0x03;
const EXIT: usize = 0x18;
/// Reasons of an exit: the program has ended, or something else.
const ENDED: usize = 0x2_0026;
const FAILED: usize = 0x2_0023;

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    exit(FAILED)
}

fn exit(reason: usize) -> ! {
    loop {
        call(EXIT, reason);
    }
}

/// Behind the start-up, with a stack.
#[unsafe(no_mangle)]
extern "C" fn started() -> ! {
    exit(if crate::run() { ENDED } else { FAILED })
}

/// A fault of any kind.
#[unsafe(no_mangle)]
extern "C" fn fault() -> ! {
    exit(FAILED)
}

/// Semihosting.
#[cfg(target_arch = "arm")]
fn call(operation: usize, argument: usize) {
    // SAFETY: the debugger reads what the argument points to.
    unsafe {
        core::arch::asm!("bkpt #0xab", inlateout("r0") operation => _, in("r1") argument, options(nostack));
    }
}

#[cfg(target_arch = "riscv32")]
fn call(operation: usize, argument: usize) {
    // SAFETY: as above. The three instructions are the sign that it is no breakpoint; no page boundary may part them.
    unsafe {
        core::arch::asm!(
            ".option push", ".option norvc", ".balign 16",
            "slli x0, x0, 0x1f", "ebreak", "srai x0, x0, 7", ".option pop",
            inlateout("a0") operation => _, in("a1") argument, options(nostack),
        );
    }
}

/// The table of vectors, and a start-up of these instructions.
#[cfg(target_arch = "arm")]
macro_rules! start {
    ($($instruction:literal),*) => {
        core::arch::global_asm!(
            ".section .vectors, \"a\"",
            ".word STACK, start",
            ".rept 14",
            ".word fault",
            ".endr",
            ".section .text.start, \"ax\"",
            ".global start",
            ".thumb_func",
            "start:",
            $($instruction,)*
            "bl started",
        );
    };
}

#[cfg(all(target_arch = "arm", not(target_abi = "eabihf")))]
start!();

// With access to the coprocessors 10 and 11, the registers of numbers.
#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
start!(
    "movw r0, #0xed88",
    "movt r0, #0xe000",
    "ldr r1, [r0]",
    "orr r1, r1, #0xf00000",
    "str r1, [r0]",
    "dsb",
    "isb"
);

// With the registers of numbers in use, if there are any.
#[cfg(target_arch = "riscv32")]
core::arch::global_asm!(
    ".section .vectors, \"ax\"",
    ".option arch, +zicsr",
    ".global start",
    "start: la sp, STACK",
    "la t0, trapped",
    "csrw mtvec, t0",
    "li t0, 0x2000",
    "csrs mstatus, t0",
    "call started",
    ".balign 4",
    "trapped: call fault",
);
