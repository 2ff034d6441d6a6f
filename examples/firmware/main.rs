//! A control loop with frictional contact on a Cortex-M.
//!
//! `cargo run --release -p examples --example firmware --target thumbv7em-none-eabihf` runs it on an emulated
//! Cortex-M4F, `cargo run --release -p examples --example firmware` on the host. A line is a time step: its
//! contacts (= stick, ~ slip, o open), ADMM iterations + Newton steps, the error, and each
//! contact's impulse by the bits of its numbers, which are the same on all machines.
//!
//! On the board a step begins with a tick of a 1 kHz timer and ends with the time it took to
//! factorise and to solve; QEMU counts 8 ns an instruction (`-icount shift=3`), as no board does.
//! A last line tells how many steps took longer than their millisecond. `--cfg fault` ends with a
//! fault, to see that it is reported.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[path = "../embedded/board.rs"]
mod board;
#[cfg(target_os = "none")]
mod pace;
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
    use crate::pace;
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

    fn run<T: Real>(name: &str, trot: &mut Trot<T>) -> Option<bool> {
        hprintln!("{}", name);
        let (mut ok, mut steps, mut late) = (true, 0, 0);
        let mut out = hio::hstdout().ok()?;
        loop {
            pace::wait();
            let start = pace::counts();
            if !trot.sense() {
                break;
            }
            ok &= trot.solve();
            let time = pace::counts().wrapping_sub(start) / pace::COUNTS_A_MICROSECOND;
            steps += 1;
            late += u32::from(time > 1000);
            trot.report(&mut out).ok()?;
            writeln!(out, "; {time} us").ok()?;
        }
        writeln!(out, ";{name}: {steps} steps at 1 kHz, {late} of them late").ok()?;
        Some(ok)
    }

    #[entry]
    fn main() -> ! {
        static mut SINGLE: Trot<f32> = Trot::new();
        static mut DOUBLE: Trot<f64> = Trot::new();
        let Some(peripherals) = cortex_m::Peripherals::take() else { exit(false) };
        if cfg!(fault) {
            cortex_m::asm::udf();
        }
        pace::start(peripherals.SYST);
        let single = run("f32", SINGLE);
        let double = run("f64", DOUBLE);
        exit(single == Some(true) && double == Some(true))
    }
}
