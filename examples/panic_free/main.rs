//! Links only if the kernel reaches no panic: the panic handler calls a symbol nobody defines.
//!
//! No allocator is linked either, or the link would ask for one. Built by `.ci/firmware` at
//! `opt-level` 3 and "s"; `--cfg violate` puts an indexing panic in the kernel's place, to see that it is
//! caught.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod contacts;
#[cfg(target_os = "none")]
mod derivatives;
#[cfg(target_os = "none")]
mod helpers;
#[cfg(target_os = "none")]
mod rows;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("a proof by linking: add --target thumbv7em-none-eabihf");
}

#[cfg(target_os = "none")]
mod proof {
    use crate::contacts::Bench;
    use crate::helpers;
    use crate::rows::Rows;
    use core::fmt::{self, Write};
    use core::hint::black_box;
    use cortex_m_rt::entry;
    use cortex_m_semihosting::debug;
    use nalgebra::SVector;
    use stiction::Error;

    mod undefined {
        #![allow(unsafe_code)]
        unsafe extern "C" {
            pub(super) safe fn a_panic_is_reachable() -> !;
        }
    }

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo) -> ! {
        undefined::a_panic_is_reachable()
    }

    /// Takes text, as a log does.
    pub(crate) struct Sink;

    impl Write for Sink {
        fn write_str(&mut self, text: &str) -> fmt::Result {
            black_box(text);
            Ok(())
        }
    }

    /// Takes what a call returns, and writes an error out.
    pub(crate) fn take<V>(result: Result<V, Error>) {
        if let Err(error) = black_box(result) {
            let _ = write!(Sink, "{error}");
        }
    }

    #[entry]
    fn main() -> ! {
        static mut QUADRUPED: Bench<f32, 18, 3, 4, 0> = Bench::new();
        static mut STACK: Bench<f32, 18, 3, 12, 12> = Bench::new();
        static mut WALKER: Bench<f32, 9, 2, 4, 2> = Bench::new();
        static mut FRICTIONLESS: Bench<f64, 6, 1, 4, 0> = Bench::new();
        static mut COINS: Rows<f32, 12, 6, 4, 12, 4> = Rows::new();
        static mut ROVER: Rows<f32, 9, 3, 3, 3, 0> = Rows::new();
        static mut TRACKS: Rows<f64, 6, 4, 2, 1, 1> = Rows::new();
        static mut PENDULUM: Rows<f64, 2, 1, 0, 4, 0> = Rows::new();
        if cfg!(violate) {
            let push: SVector<f32, 3> = black_box(SVector::zeros());
            black_box(push[black_box(1)]);
            end() // the kernel would only take time to build
        }
        black_box(QUADRUPED).call();
        black_box(STACK).call();
        black_box(WALKER).call();
        black_box(FRICTIONLESS).call();
        black_box(COINS).call();
        black_box(ROVER).call();
        black_box(TRACKS).call();
        black_box(PENDULUM).call();
        helpers::call::<f32, 18, 3>();
        helpers::call::<f64, 6, 1>();
        helpers::call_spatial::<f32, 18>();
        end()
    }

    fn end() -> ! {
        loop {
            debug::exit(debug::EXIT_SUCCESS);
        }
    }
}
