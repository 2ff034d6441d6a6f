//! The whole robot on the chip: the control loop of a quadruped of twelve motors, from encoder angles to torques, at 1 kHz.
//!
//! `cargo run --locked --profile firmware -p examples --example robot_firmware --target thumbv7em-none-eabihf` runs it on an emulated
//! Cortex-M4F, `cargo run --release -p examples --example robot_firmware` on the host, with the same bits.
//!
//! | file | what it does |
//! |---|---|
//! | `dynamics` | kinematics, `M` and bias from angles and velocities, with `spatial` (rigid bodies) and `model` (this robot) |
//! | `controller` | **a tick**: fills the scene, solves it, torques; holds impulses, and stops when they are too old |
//! | `plant` | the robot in place of a real one: the same dynamics and solver, not counted in the time of a tick |
//! | `run` | a drop, a push, a foot that is missed, encoders that break |
//! | `timing` | instructions of each stage, and deadlines |
//!
//! The controller asks in each tick: with which impulses would the ground push the feet in the next 20 ms if the joints held their
//! angles? The mean forces `r / h` of the feet, mapped to the joints by their Jacobians, are what motors have to bear; a weak feedback
//! on angles and rates does the rest. (Feedback alone lets the torso sag by 6 mm in place of 1 mm.) In a tick without a good solution the
//! last good impulses are held, for 20 ticks at most. Then the robot stops: its joints only damp.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[path = "../embedded/board.rs"]
mod board;
mod controller;
mod dynamics;
mod model;
#[cfg(target_os = "none")]
#[path = "../firmware/pace.rs"]
mod pace;
mod plant;
mod run;
mod spatial;
#[cfg(target_os = "none")]
mod timing;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    let (mut plant, mut controller) = (plant::Plant::new(), controller::Controller::new());
    let mut text = String::new();
    let result = run::run((&mut plant, &mut controller), &mut text, &mut ());
    print!("{text}");
    std::process::ExitCode::from(u8::from(result.is_err()))
}

#[cfg(target_os = "none")]
mod firmware {
    use crate::board::exit;
    use crate::controller::Controller;
    use crate::plant::Plant;
    use crate::timing::Timing;
    use crate::{pace, run};
    use core::fmt;
    use cortex_m_rt::entry;
    use cortex_m_semihosting::hio;

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo) -> ! {
        exit(false)
    }

    fn run(plant: &mut Plant, controller: &mut Controller) -> fmt::Result {
        let mut out = hio::hstdout().map_err(|()| fmt::Error)?;
        let mut timing = Timing::new();
        run::run((plant, controller), &mut out, &mut timing)?;
        timing.report(&mut out)
    }

    #[entry]
    fn main() -> ! {
        static mut PLANT: Plant = Plant::new();
        static mut CONTROLLER: Controller = Controller::new();
        let Some(peripherals) = cortex_m::Peripherals::take() else { exit(false) };
        pace::start(peripherals.SYST);
        exit(run(PLANT, CONTROLLER).is_ok())
    }
}
