//! A quadruped's control loop in Embassy.
//!
//! `control` runs at 1 kHz in an executor of its own, at an interrupt's priority, and applies the last good impulses. `solve`
//! does a slice of work in each tick (`examples/embedded/slices.rs`), in the executor of thread mode: `control`
//! interrupts it, and waits for nothing but the moment in which new impulses are handed over. The watchdog is fed by
//! `control`, as long as the solver gives signs of life: `--cfg fault` lets it hang.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![allow(unsafe_code)] // the interrupt of an executor

#[cfg(target_os = "none")]
#[path = "../embedded/records.rs"]
mod records;
#[cfg(target_os = "none")]
#[path = "../embedded/rtos.rs"]
mod rtos;
#[cfg(target_os = "none")]
#[path = "../embedded/slices.rs"]
mod slices;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("runs on an emulated board: .ci/rtos");
}

#[cfg(target_os = "none")]
mod firmware {
    use crate::rtos::{self, Watchdog};
    use crate::slices::{Feet, Impulses, Slice};
    use core::cell::RefCell;
    use core::sync::atomic::{AtomicBool, Ordering};
    use cortex_m_rt::exception;
    use embassy_executor::{InterruptExecutor, Spawner};
    use embassy_sync::blocking_mutex::CriticalSectionMutex;
    use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
    use embassy_sync::signal::Signal;
    use lm3s6965::{Interrupt, interrupt};
    use semihosting::process::exit;
    use static_cell::ConstStaticCell;

    type TickSignal = Signal<CriticalSectionRawMutex, u32>;

    static CONTROL: InterruptExecutor = InterruptExecutor::new();
    static BEGIN_CONTROL: TickSignal = Signal::new();
    static BEGIN_SLICE: TickSignal = Signal::new();
    /// The last good ones.
    static IMPULSES: CriticalSectionMutex<RefCell<Impulses>> =
        CriticalSectionMutex::new(RefCell::new(Impulses::new()));
    /// Has the solver begun a slice since the watchdog was fed?
    static IS_ALIVE: AtomicBool = AtomicBool::new(true);
    static FEET: ConstStaticCell<Feet> = ConstStaticCell::new(Feet::new());

    #[exception]
    fn SysTick() {
        BEGIN_CONTROL.signal(rtos::count_tick());
    }

    #[interrupt]
    fn GPIOA() {
        // Safety: nothing else calls it, and it is enabled by `start`.
        unsafe { CONTROL.on_interrupt() }
    }

    #[embassy_executor::task]
    async fn control(mut watchdog: Watchdog) {
        loop {
            let tick = BEGIN_CONTROL.wait().await;
            rtos::in_time(tick, || {
                IMPULSES.lock(|impulses| {
                    core::hint::black_box(impulses.borrow()); // by key, into torques of the joints
                });
                if IS_ALIVE.swap(false, Ordering::Relaxed) {
                    watchdog.feed();
                }
            });
            BEGIN_SLICE.signal(tick);
        }
    }

    #[embassy_executor::task]
    async fn solve(feet: &'static mut Feet) {
        loop {
            let tick = BEGIN_SLICE.wait().await;
            while cfg!(fault) && tick == 20 {}
            IS_ALIVE.store(true, Ordering::Relaxed);
            match feet.slice(tick) {
                Slice::Nothing => {}
                Slice::Good(new) => IMPULSES.lock(|impulses| *impulses.borrow_mut() = new),
                Slice::End => exit(0),
            }
        }
    }

    #[embassy_executor::main]
    async fn main(spawner: Spawner) {
        let tasks = (control(Watchdog::start(10)), solve(FEET.take()));
        if let ((Ok(control), Ok(solve)), Some(mut core)) = (tasks, cortex_m::Peripherals::take()) {
            CONTROL.start(Interrupt::GPIOA).spawn(control);
            spawner.spawn(solve);
            rtos::start_clock(&mut core.SYST);
        }
    }
}
