//! How long a call takes at most, held to `Kernel::worst_cycles`: on an emulated Cortex-M4F (`.ci/firmware` runs it).
//!
//! Scenes of each size come from `bake by-size`, by the variable `SCENES`. All are solved as they are, disturbed by little and by much, and
//! with numbers where there were zeros; to tolerances from 1e-2 to 1e-30, cold, warm and going on. A line is `phases size budget promise
//! instructions`, where the promise is in cycles and the last column is the dearest call, preparing included.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("measures on an emulated board: run .ci/firmware");
}

#[cfg(target_os = "none")]
#[path = "../embedded/board.rs"]
mod board;
#[cfg(target_os = "none")]
#[allow(dead_code)] // nobody asks what it counts
#[path = "../embedded/counter.rs"]
mod counter;
#[cfg(target_os = "none")]
mod scene;

#[cfg(target_os = "none")]
mod worst_case {
    use crate::board::exit;
    use crate::counter::Counter;
    use crate::scene::{Given, Random};
    use core::hint::black_box;
    use cortex_m_rt::entry;
    use cortex_m_semihosting::hprintln;
    use stiction::{
        AllPhases, Contact, Error, Kernel, Phases, Scene, Settings, Surface, SweepsAndNewton, SweepsOnly,
    };

    /// Cycles that are fewer than the instructions that the counter can count.
    const COUNTED: usize = 16_000_000 * 18 / 10;
    const BUDGETS: [usize; 7] = [0, 1, 10, 30, 100, 300, 1_000];
    const TOLERANCES: [f32; 5] = [1e-4, 1e-30, 1e-6, 1e-2, 3e-7];
    /// By how much a scene is disturbed, in one variant after the other.
    const DISTURBED: [f32; 6] = [0.0, 1e-3, 0.1, 0.5, 3.0, 30.0];

    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo) -> ! {
        hprintln!("{}", info);
        exit(false)
    }

    /// Measures all scenes of a size and some phases; `None` if the counter overflows or a scene is refused.
    #[inline(never)]
    fn measure<P: Phases, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>(
        (name, phases): (&str, P),
        scenes: &[&[f32]],
        push: Push<N, D, C, R, S>,
        counter: &mut Counter,
    ) -> Option<()> {
        let mut kernel = Kernel::<f32, N, D, C, R, S, P>::with_phases(phases);
        let mut random = Random(1);
        for budget in BUDGETS {
            let promise = Kernel::<f32, N, D, C, R, S, P>::worst_cycles(budget);
            if promise > COUNTED {
                break;
            }
            let mut dearest = 0;
            for (k, numbers) in scenes.iter().enumerate() {
                for (variant, &share) in DISTURBED.iter().chain(&DISTURBED).enumerate() {
                    let mut given = Given::<N, D, C, R>::read(numbers, S > 0)?;
                    given.disturb(share, &mut random);
                    if variant >= DISTURBED.len() {
                        given.make_dense(&mut random);
                    }
                    let tolerance = *TOLERANCES.get((k + variant) % TOLERANCES.len())?;
                    let settings = Settings { budget, ..Settings::new(tolerance) };
                    kernel.solver_mut().reset();
                    given.fill(kernel.scene_mut(), push)?;
                    for call in 0..4 {
                        if call == 2 {
                            given.disturb(0.01, &mut random);
                            given.fill(kernel.scene_mut(), push)?; // a tick later
                        }
                        let free_impulse = black_box(given.push());
                        let count = counter.count(|| {
                            let solved = if call % 2 == 0 {
                                kernel.solve(free_impulse, &settings)
                            } else {
                                kernel.resume(free_impulse, &settings)
                            };
                            black_box(solved.is_ok());
                        })?;
                        dearest = dearest.max(count);
                    }
                }
            }
            hprintln!("{} {},{},{},{},{} {} {} {}", name, N, D, C, R, S, budget, promise, dearest);
        }
        Some(())
    }

    /// How a contact is added, which differs by size.
    pub(crate) type Push<const N: usize, const D: usize, const C: usize, const R: usize, const S: usize> =
        fn(&mut Scene<f32, N, D, C, R, S>, &Contact<f32, N, D>, &Surface<f32>) -> Result<usize, Error>;

    /// Measures each size.
    macro_rules! sizes {
        ($(($n:tt, $d:tt, $c:tt, $r:tt, $s:tt) [$($phases:ident)*]: $($scene:expr,)*;)*) => {
            fn all(counter: &mut Counter) -> Option<()> {
                $({
                    let scenes: &[&[f32]] = &[$(&$scene),*];
                    $(
                        let phases = (stringify!($phases), $phases);
                        measure::<_, $n, $d, $c, $r, $s>(phases, scenes, push!($s), counter)?;
                    )*
                })*
                Some(())
            }
        };
    }

    macro_rules! push {
        (0) => {
            |scene, contact, _| scene.push(contact)
        };
        ($surfaces:tt) => {
            Scene::push_on
        };
    }

    include!(env!("SCENES"));

    #[entry]
    fn main() -> ! {
        let Some(peripherals) = cortex_m::Peripherals::take() else { exit(false) };
        let mut counter = Counter::start(peripherals);
        exit(all(&mut counter).is_some())
    }
}
