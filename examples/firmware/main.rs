//! A control loop with frictional contact on a Cortex-M.
//!
//! `cargo run --release --example firmware --target thumbv7em-none-eabihf` runs it on an emulated
//! Cortex-M4F, `cargo run --release --example firmware` on the host. A line is a time step: its
//! contacts (= stick, ~ slip, o open), ADMM iterations + Newton steps, the error, and each
//! contact's impulse by the bits of its numbers, which are the same on all machines. On the
//! board it ends with the instructions it took to factorise and to solve.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[path = "../embedded/board.rs"]
mod board;
#[cfg(target_os = "none")]
#[path = "../embedded/counter.rs"]
mod counter;
#[path = "../embedded/records.rs"]
mod records;
mod trot;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    fn run<T: stiction::Real>(name: &str) -> bool {
        println!("{name}");
        let mut trot = trot::Trot::<T>::new();
        let mut ok = true;
        while trot.sense() {
            ok &= trot.solve();
            let mut line = String::new();
            ok &= trot.report(&mut line).is_ok();
            println!("{line}");
        }
        ok
    }
    let ok = run::<f32>("f32") & run::<f64>("f64");
    std::process::ExitCode::from(u8::from(!ok))
}

#[cfg(target_os = "none")]
mod firmware {
    use crate::board::exit;
    use crate::counter::Counter;
    use crate::trot::Trot;
    use core::fmt::Write;
    use cortex_m_rt::entry;
    use cortex_m_semihosting::{hio, hprintln};
    use stiction::Real;

    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo) -> ! {
        hprintln!("{}", info);
        exit(false)
    }

    fn run<T: Real>(name: &str, trot: &mut Trot<T>, counter: &mut Counter) -> Option<bool> {
        hprintln!("{}", name);
        let mut ok = true;
        let mut out = hio::hstdout().ok()?;
        while trot.sense() {
            let count = counter.instructions(|| ok &= trot.solve());
            trot.report(&mut out).ok()?;
            writeln!(out, "; {} instructions", count.unwrap_or(u32::MAX)).ok()?;
        }
        Some(ok)
    }

    #[entry]
    fn main() -> ! {
        static mut SINGLE: Trot<f32> = Trot::new();
        static mut DOUBLE: Trot<f64> = Trot::new();
        let Some(peripherals) = cortex_m::Peripherals::take() else {
            exit(false)
        };
        let mut counter = Counter::start(peripherals.SYST);
        let single = run("f32", SINGLE, &mut counter);
        let double = run("f64", DOUBLE, &mut counter);
        exit(single == Some(true) && double == Some(true))
    }
}
