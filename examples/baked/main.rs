//! A scene that was factorised on the host: the firmware solves, and has no Cholesky code.
//!
//! `quadruped.rs` is what `cargo run -p bake -- rust tests/scenes/go2_stand.json` prints.
//! Its numbers are the bits the host computed. The same constants are checked by `main` on the
//! host against a factor computed anew.
#![cfg_attr(target_os = "none", no_std, no_main)]

use core::fmt::{Result, Write};
use stiction::{AdmmSolver, Settings};

#[cfg(target_os = "none")]
#[path = "../embedded/board.rs"]
mod board;

#[allow(clippy::unreadable_literal)] // bits
mod quadruped {
    use nalgebra::{ArrayStorage, SMatrix, SVector};
    use stiction::{AdmmFactor, AdmmFactorParts, Contact, FactorParts, Scene};
    include!("quadruped.rs");
}
use quadruped::{FACTOR, FREE_IMPULSE, SCENE};

/// Solves by Algorithm 2, with the stored factor alone.
fn report(solver: &mut AdmmSolver<f32, 18, 3, 4>, out: &mut impl Write) -> Result {
    let settings = Settings::new(1e-3);
    match solver.solve(&SCENE, &FACTOR, &FREE_IMPULSE, &settings) {
        Ok(solution) => {
            write!(out, "{:?}:", solution.status)?;
            for impulse in solution.contacts.iter().flat_map(|c| &c.impulse) {
                write!(out, " {:08x}", impulse.to_bits())?;
            }
            writeln!(out)
        }
        Err(error) => writeln!(out, "{error}"),
    }
}

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    let mut line = String::new();
    let _ = report(&mut AdmmSolver::new(), &mut line);
    print!("{line}");
    let anew = stiction::AdmmFactor::new(&SCENE)
        .ok()
        .and_then(|factor| factor.parts());
    std::process::ExitCode::from(u8::from(anew != FACTOR.parts()))
}

#[cfg(target_os = "none")]
mod firmware {
    use crate::board::exit;
    use cortex_m_rt::entry;
    use cortex_m_semihosting::hio;
    use stiction::AdmmSolver;

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo) -> ! {
        exit(false)
    }

    #[entry]
    fn main() -> ! {
        static mut SOLVER: AdmmSolver<f32, 18, 3, 4> = AdmmSolver::new();
        let written = hio::hstdout().is_ok_and(|mut out| crate::report(SOLVER, &mut out).is_ok());
        exit(written)
    }
}
