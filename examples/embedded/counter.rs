//! What work takes: cycles on a board, instructions under QEMU.
//!
//! A Cortex-M3 or larger counts its cycles in `DWT::CYCCNT`. QEMU's stands still, so there `SysTick` counts: with `-icount shift=10` an
//! instruction takes 1024 ns of virtual time, and the reference clock of an `mps2` board runs at 1 MHz, so that a tick is 1000/1024 of an
//! instruction. Those are instructions under emulation, not the cycles of a core.

use cortex_m::Peripherals;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{DWT, SYST};

const RELOAD: u32 = 0x00ff_ffff;

/// Counts instructions, up to 16 million at a time, or cycles, up to 4 billion.
pub(crate) struct Counter {
    timer: SYST,
    cycles: bool,
    overhead: u32,
}

impl Counter {
    /// Starts the counters and measures what a measurement costs.
    pub(crate) fn start(mut peripherals: Peripherals) -> Self {
        peripherals.DCB.enable_trace();
        DWT::unlock(); // a Cortex-M7 asks for it
        peripherals.DWT.enable_cycle_counter();
        let start = DWT::cycle_count();
        let cycles = (0..10).any(|_| DWT::cycle_count() != start);
        let mut timer = peripherals.SYST;
        timer.set_clock_source(SystClkSource::External);
        timer.set_reload(RELOAD);
        timer.clear_current();
        timer.enable_counter();
        let mut counter = Self {
            timer,
            cycles,
            overhead: 0,
        };
        counter.overhead = counter.count(|| {}).unwrap_or(0);
        counter
    }

    /// Whether it counts cycles.
    pub(crate) const fn counts_cycles(&self) -> bool {
        self.cycles
    }

    /// Instructions executed by `f`, or its cycles; `None` if the timer wrapped.
    #[inline(never)]
    pub(crate) fn count(&mut self, f: impl FnOnce()) -> Option<u32> {
        if !self.cycles {
            self.timer.clear_current(); // and the wrapped flag
            while SYST::get_current() == 0 {}
        }
        let start = self.now();
        f();
        let end = self.now();
        if self.cycles {
            return Some(end.wrapping_sub(start).saturating_sub(self.overhead));
        }
        let instructions = (u64::from(start.wrapping_sub(end)) * 1000).div_ceil(1024);
        let instructions = u32::try_from(instructions).ok()?;
        (!self.timer.has_wrapped()).then(|| instructions.saturating_sub(self.overhead))
    }

    /// The cycle counter, which counts up, or the timer, which counts down.
    fn now(&self) -> u32 {
        if self.cycles {
            DWT::cycle_count()
        } else {
            SYST::get_current()
        }
    }
}
