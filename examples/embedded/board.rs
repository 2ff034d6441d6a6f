//! How a program on an emulated board ends, well or in a fault.
#![allow(unsafe_code)] // the signature of a fault handler

use cortex_m_rt::{ExceptionFrame, exception};
use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
use cortex_m_semihosting::hprintln;

/// Ends QEMU with exit code 0 or 1.
pub(crate) fn exit(ok: bool) -> ! {
    loop {
        debug::exit(if ok { EXIT_SUCCESS } else { EXIT_FAILURE });
    }
}

/// Reports where it happened, and ends QEMU with exit code 1.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    hprintln!("HardFault at {:#010x}, called from {:#010x}", frame.pc(), frame.lr());
    exit(false)
}
