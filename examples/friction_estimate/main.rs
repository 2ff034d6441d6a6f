//! Estimates a friction coefficient from measured velocities, step by step, as on board: `f32`, no allocation.
//!
//! `cargo run --release -p examples --example friction_estimate` runs it on the host, with `--profile firmware --target thumbv7em-none-eabihf` on
//! an emulated Cortex-M4F. The numbers are the same.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[path = "../embedded/board.rs"]
mod board;
mod drive;
mod estimator;

#[cfg(not(target_os = "none"))]
fn main() -> Result<(), stiction::Error> {
    let mut drive = drive::Drive::new();
    drive.begin()?;
    for _ in 0..drive::STEPS / 20 {
        let line = drive.go_on(20)?;
        println!("{line}");
    }
    Ok(())
}

#[cfg(target_os = "none")]
mod firmware {
    use crate::board::exit;
    use crate::drive::{Drive, STEPS};
    use cortex_m_rt::entry;
    use cortex_m_semihosting::hprintln;

    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo) -> ! {
        hprintln!("{}", info);
        exit(false)
    }

    fn run(drive: &mut Drive) -> Result<(), stiction::Error> {
        drive.begin()?;
        for _ in 0..STEPS / 20 {
            let line = drive.go_on(20)?;
            hprintln!("{}", line);
        }
        Ok(())
    }

    #[entry]
    fn main() -> ! {
        static mut DRIVE: Drive = Drive::new();
        exit(run(DRIVE).is_ok())
    }
}
