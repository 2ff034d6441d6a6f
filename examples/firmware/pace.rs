//! A clock of 1 kHz: `SysTick` interrupts at every millisecond.

use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::asm::wfi;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::exception;

/// `SysTick` of the emulated boards runs at 25 MHz. On an STM32F4 it runs at the core's clock.
pub(crate) const COUNTS_A_MICROSECOND: u32 = 25;
const COUNTS_A_MILLISECOND: u32 = 1000 * COUNTS_A_MICROSECOND;

static MILLISECONDS: AtomicU32 = AtomicU32::new(0);

#[exception]
fn SysTick() {
    MILLISECONDS.fetch_add(1, Ordering::Relaxed);
}

/// Starts the clock.
pub(crate) fn start(mut timer: SYST) {
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(COUNTS_A_MILLISECOND - 1);
    timer.clear_current();
    timer.enable_counter();
    timer.enable_interrupt();
}

/// Sleeps until the next millisecond begins.
pub(crate) fn wait() {
    let now = MILLISECONDS.load(Ordering::Relaxed);
    while MILLISECONDS.load(Ordering::Relaxed) == now {
        wfi();
    }
}

/// Counts of the timer since the clock was started. They begin again at 0 after three minutes.
pub(crate) fn counts() -> u32 {
    loop {
        let milliseconds = MILLISECONDS.load(Ordering::Relaxed);
        let left = SYST::get_current();
        // Otherwise an interrupt came between the two.
        if MILLISECONDS.load(Ordering::Relaxed) == milliseconds {
            let passed = COUNTS_A_MILLISECOND - 1 - left;
            return milliseconds.wrapping_mul(COUNTS_A_MILLISECOND).wrapping_add(passed);
        }
    }
}
