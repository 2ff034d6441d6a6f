//! The smallest firmware that solves one scene: `.ci/firmware` takes the bytes of flash from it.
//!
//! The configuration (`--cfg restart`, `sweeps`, `newton`, `planar`, `frictionless`, `rover`) chooses the method and the scene: a
//! quadruped on four feet, or a rover on three wheels, each with a motor as a joint row. `--cfg empty` leaves the kernel out, and is what the
//! others are compared with.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("measures an image: add --target thumbv7em-none-eabihf");
}

#[cfg(target_os = "none")]
mod firmware {
    use cortex_m_rt::entry;
    use cortex_m_semihosting::debug::{self, EXIT_SUCCESS};

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo) -> ! {
        end()
    }

    fn end() -> ! {
        loop {
            debug::exit(EXIT_SUCCESS);
        }
    }

    #[cfg(empty)]
    #[entry]
    fn main() -> ! {
        end()
    }

    #[cfg(not(empty))]
    use {
        core::hint::black_box,
        stiction::{Scene, Settings},
    };

    #[cfg(all(not(empty), restart))]
    use stiction::{AdmmFactor, AdmmSolver};
    #[cfg(all(not(empty), not(restart)))]
    use stiction::{Factor, Solver};

    /// Velocities: of a body and its twelve or three joints.
    #[cfg(not(empty))]
    const N: usize = if cfg!(rover) { 9 } else { 18 };

    /// Rows of a contact.
    #[cfg(not(empty))]
    const D: usize = if cfg!(frictionless) {
        1
    } else if cfg!(planar) {
        2
    } else {
        3
    };

    /// Contacts.
    #[cfg(not(empty))]
    const C: usize = if cfg!(rover) { 3 } else { 4 };

    /// Joint rows: the rover's motors.
    #[cfg(not(empty))]
    const R: usize = if cfg!(rover) { 3 } else { 0 };

    #[cfg(all(not(empty), restart))]
    type OurFactor = AdmmFactor<f32, N, D, C>;
    #[cfg(all(not(empty), restart))]
    type OurSolver = AdmmSolver<f32, N, D, C>;
    #[cfg(all(not(empty), not(restart)))]
    type OurFactor = Factor<f32, N, D, C, R>;
    #[cfg(all(not(empty), not(restart)))]
    type OurSolver = Solver<f32, N, D, C, R, Chosen>;

    #[cfg(not(any(empty, restart, sweeps, newton)))]
    use stiction::AllPhases as Chosen;
    #[cfg(newton)]
    use stiction::SweepsAndNewton as Chosen;
    #[cfg(sweeps)]
    use stiction::SweepsOnly as Chosen;
    #[cfg(restart)]
    const NEW: OurSolver = OurSolver::new();
    #[cfg(not(any(empty, restart)))]
    const NEW: OurSolver = OurSolver::with_phases(Chosen);

    #[cfg(not(empty))]
    #[entry]
    fn main() -> ! {
        static mut SCENE: Scene<f32, N, D, C, R> = Scene::new();
        static mut FACTOR: OurFactor = OurFactor::empty();
        static mut SOLVER: OurSolver = NEW;
        let (scene, solver) = (black_box(SCENE), black_box(SOLVER));
        let prepared = FACTOR.prepare(scene);
        if prepared.is_ok() {
            let (push, settings) = black_box((nalgebra::SVector::zeros(), Settings::default()));
            let result = solver.solve(scene, FACTOR, &push, &settings);
            let _ = black_box(result);
        }
        end()
    }
}
