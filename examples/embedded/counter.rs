//! A QEMU `mps2` board as a measuring instrument: instruction counts.
//!
//! With `-icount shift=10` an instruction takes 1024 ns of virtual time, and the reference clock
//! of `SysTick` runs at 1 MHz, so that a tick is 1000/1024 of an instruction. These are
//! instructions under emulation, not the cycles of a core.

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

const RELOAD: u32 = 0x00ff_ffff;

/// Counts instructions, up to 16 million at a time.
pub(crate) struct Counter {
    timer: SYST,
    overhead: u32,
}

impl Counter {
    /// Starts the timer and measures what a measurement costs.
    pub(crate) fn start(mut timer: SYST) -> Self {
        timer.set_clock_source(SystClkSource::External);
        timer.set_reload(RELOAD);
        timer.clear_current();
        timer.enable_counter();
        let mut counter = Self { timer, overhead: 0 };
        counter.overhead = counter.instructions(|| {}).unwrap_or(0);
        counter
    }

    /// Instructions executed by `f`; `None` if the timer wrapped.
    #[inline(never)]
    pub(crate) fn instructions(&mut self, f: impl FnOnce()) -> Option<u32> {
        self.timer.clear_current(); // and the wrapped flag
        while SYST::get_current() == 0 {}
        let start = SYST::get_current();
        f();
        let ticks = start - SYST::get_current();
        let instructions = (u64::from(ticks) * 1000).div_ceil(1024);
        let instructions = u32::try_from(instructions).ok()?;
        (!self.timer.has_wrapped()).then(|| instructions.saturating_sub(self.overhead))
    }
}
