//! The smallest firmware that solves one scene: `.ci/firmware` takes the bytes of flash from it.
//!
//! The configuration (`--cfg restart`, `planar`, `frictionless`) chooses the method and the scene;
//! `--cfg empty` leaves the kernel out, and is what the others are compared with.
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
    use stiction::{AdmmFactor as Factor, AdmmSolver as Solver};
    #[cfg(all(not(empty), not(restart)))]
    use stiction::{Factor, Solver};

    #[cfg(not(empty))]
    const D: usize = if cfg!(frictionless) {
        1
    } else if cfg!(planar) {
        2
    } else {
        3
    };

    #[cfg(not(empty))]
    #[entry]
    fn main() -> ! {
        static mut SCENE: Scene<f32, 18, D, 4> = Scene::new();
        static mut FACTOR: Factor<f32, 18, D, 4> = Factor::empty();
        static mut SOLVER: Solver<f32, 18, D, 4> = Solver::new();
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
