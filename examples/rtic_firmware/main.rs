//! A quadruped's control loop in RTIC 2.
//!
//! `control` runs at 1 kHz and applies the last good impulses. `solve` runs below it, a slice of work in each tick
//! (`examples/embedded/slices.rs`); `control` interrupts it, and waits for nothing but the moment in which new impulses are
//! handed over. The watchdog is fed by `control`, as long as the solver gives signs of life: `--cfg fault` lets it hang.
#![cfg_attr(target_os = "none", no_std, no_main)]

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
#[rtic::app(device = lm3s6965, dispatchers = [GPIOA])]
mod app {
    use crate::rtos::{self, Watchdog};
    use crate::slices::{Feet, Impulses, Slice};
    use rtic_sync::make_signal;
    use rtic_sync::signal::{SignalReader, SignalWriter};
    use semihosting::process::exit;

    #[shared]
    struct Shared {
        /// The last good ones.
        impulses: Impulses,
        /// Has the solver begun a slice since the watchdog was fed?
        is_alive: bool,
    }

    #[local]
    struct Local {
        watchdog: Watchdog,
        begin_slice: SignalWriter<'static, u32>,
        slices: SignalReader<'static, u32>,
    }

    #[init]
    fn init(mut cx: init::Context) -> (Shared, Local) {
        let (begin_slice, slices) = make_signal!(u32);
        let watchdog = Watchdog::start(10);
        rtos::start_clock(&mut cx.core.SYST);
        let _ = solve::spawn();
        let shared = Shared { impulses: Impulses::new(), is_alive: true };
        let local = Local { watchdog, begin_slice, slices };
        (shared, local)
    }

    #[task(binds = SysTick, priority = 2, local = [watchdog, begin_slice], shared = [impulses, is_alive])]
    fn control(mut cx: control::Context) {
        let tick = rtos::count_tick();
        rtos::in_time(tick, || {
            cx.shared.impulses.lock(|impulses| {
                core::hint::black_box(impulses); // by key, into torques of the joints
            });
            if cx.shared.is_alive.lock(core::mem::take) {
                cx.local.watchdog.feed();
            }
        });
        cx.local.begin_slice.write(tick);
    }

    #[task(priority = 1, local = [slices, feet: Feet = Feet::new()], shared = [impulses, is_alive])]
    async fn solve(mut cx: solve::Context) {
        loop {
            let tick = cx.local.slices.wait().await;
            while cfg!(fault) && tick == 20 {}
            cx.shared.is_alive.lock(|alive| *alive = true);
            match cx.local.feet.slice(tick) {
                Slice::Nothing => {}
                Slice::Good(new) => cx.shared.impulses.lock(|impulses| *impulses = new),
                Slice::End => exit(0),
            }
        }
    }
}
