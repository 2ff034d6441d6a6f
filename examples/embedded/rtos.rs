//! What the programs under a real-time framework share: clock and watchdog of the emulated board, and the ends of a program.
//!
//! Logs leave by `defmt` over semihosting; `qemu-run` decodes them. On a board `defmt-rtt` does not stop the core for it.
#![allow(unsafe_code)] // registers of the watchdog, signatures of handlers

use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{SCB, SYST};
use cortex_m_rt::{ExceptionFrame, exception};
use defmt_semihosting as _;
use semihosting::process::exit;

/// `SysTick` and the watchdog of the emulated board count at 25 MHz.
const NANOSECONDS_A_COUNT: u32 = 40;
const COUNTS_A_MILLISECOND: u32 = 1_000_000 / NANOSECONDS_A_COUNT;

/// Ticks so far.
static MILLISECONDS: AtomicU32 = AtomicU32::new(0);
/// Of them, those whose control was not done when the next one began.
static LATE: AtomicU32 = AtomicU32::new(0);
/// The longest time from a tick to its control (ns).
static LONGEST_DELAY: AtomicU32 = AtomicU32::new(0);

defmt::timestamp!("{=u32:us}", microseconds());

/// Lets `SysTick` interrupt at every millisecond.
pub(crate) fn start_clock(timer: &mut SYST) {
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(COUNTS_A_MILLISECOND - 1);
    timer.clear_current();
    timer.enable_counter();
    timer.enable_interrupt();
}

/// Counts a tick, in the handler of `SysTick`; returns how many there were before.
pub(crate) fn count_tick() -> u32 {
    MILLISECONDS.fetch_add(1, Ordering::Relaxed)
}

/// Runs the control of a tick, and notes whether it was in time.
pub(crate) fn in_time(tick: u32, control: impl FnOnce()) {
    LONGEST_DELAY.fetch_max(since_tick(), Ordering::Relaxed);
    control();
    LATE.fetch_add(u32::from(is_over(tick)), Ordering::Relaxed);
}

/// Logs how the control loop has kept time.
pub(crate) fn report() {
    let [ticks, late, delay] =
        [&MILLISECONDS, &LATE, &LONGEST_DELAY].map(|count| count.load(Ordering::Relaxed));
    defmt::info!("control: {} ticks, {} late, at most {} ns after its tick", ticks, late, delay);
}

/// Is the time of this tick over?
pub(crate) fn is_over(tick: u32) -> bool {
    MILLISECONDS.load(Ordering::Relaxed) != tick + 1 || SCB::is_pendst_pending()
}

/// Nanoseconds since `SysTick` has asked for an interrupt.
fn since_tick() -> u32 {
    (COUNTS_A_MILLISECOND - 1 - SYST::get_current()) * NANOSECONDS_A_COUNT
}

fn microseconds() -> u32 {
    MILLISECONDS.load(Ordering::Relaxed) * 1000 + since_tick() / 1000
}

/// The board's watchdog: it calls [`NonMaskableInt`] when it has not been fed for its period, and resets after another.
pub(crate) struct Watchdog(*mut u32);

// Safety: nobody else has its registers.
unsafe impl Send for Watchdog {}

impl Watchdog {
    const LOAD: usize = 0;
    const CONTROL: usize = 2;
    const CLEAR: usize = 3;

    /// Starts it with a period in milliseconds.
    pub(crate) fn start(period: u32) -> Self {
        let watchdog = Self(0x4000_8000 as *mut u32);
        watchdog.write(Self::LOAD, period * COUNTS_A_MILLISECOND);
        watchdog.write(Self::CONTROL, 0b11); // interrupt, then reset
        watchdog
    }

    /// Its period begins again.
    pub(crate) fn feed(&mut self) {
        self.write(Self::CLEAR, 1);
    }

    fn write(&self, register: usize, value: u32) {
        // Safety: registers of the CMSDK watchdog of the MPS2 boards.
        unsafe { self.0.add(register).write_volatile(value) };
    }
}

#[exception]
unsafe fn NonMaskableInt() -> ! {
    defmt::error!("watchdog: the solver gives no sign of life");
    exit(1) // a robot would let its motors brake, and start again
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    defmt::error!("HardFault at {=u32:#010x}", frame.pc());
    exit(1)
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    defmt::error!("{}", defmt::Display2Format(info));
    exit(1)
}
