//! Sensors, motors and log for the program that `src/guide/firmware.md` prints; `.ci/firmware` puts them behind it. The leg of 2 kg stands on
//! the floor and is pushed harder in each of ten ticks, until it slides. Then a sensor breaks.

use core::fmt::Display;
use core::sync::atomic::{AtomicU16, Ordering::Relaxed};
use cortex_m_semihosting::debug::{self, EXIT_SUCCESS};
use cortex_m_semihosting::hprintln;

/// Ticks so far.
static TICK: AtomicU16 = AtomicU16::new(0);

/// Angles, velocity and force. One velocity is garbage, a number none the less.
pub fn sense() -> [crate::Vector; 3] {
    let tick = TICK.fetch_add(1, Relaxed);
    let push = if tick < 10 {
        f32::from(tick) * 2.0
    } else {
        f32::NAN
    };
    let falls = if tick == 5 { -1e6 } else { 0.0 };
    [[0.5, -1.0].into(), [0.0, falls].into(), [push, -2.0 * 9.81].into()]
}

/// Prints the torques. Those of the stop end the program.
pub fn apply(torques: &crate::Vector) {
    let [[hip, knee]] = torques.data.0;
    hprintln!("{:.2} {:.2}", hip, knee);
    if *torques == crate::Vector::zeros() {
        debug::exit(EXIT_SUCCESS);
    }
}

/// Prints a line of the log.
pub fn log(line: &dyn Display) {
    hprintln!("{}", line);
}
