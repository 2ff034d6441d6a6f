//! How a program on an emulated board ends.

use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};

/// Ends QEMU with exit code 0 or 1.
pub(crate) fn exit(ok: bool) -> ! {
    loop {
        debug::exit(if ok { EXIT_SUCCESS } else { EXIT_FAILURE });
    }
}
