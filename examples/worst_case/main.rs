//! How long a call takes at most, held to `Kernel::worst_cycles`: on an emulated Cortex-M4F (`.ci/firmware` runs it).
//!
//! Scenes of each size come from `bake by-size`, by the variable `SCENES`. All are solved as they are, disturbed by little and by much, and
//! with numbers where there were zeros; to tolerances from 1e-2 to 1e-30, cold, warm and going on. From the dearest call of each budget hill
//! climbing looks for a dearer one. A line is `phases size budget promise instructions`, where the promise is in cycles and the last column
//! is the dearest call, preparing included; of slices, whose lines begin with `phases:slice`, the dearest after `prepare`.
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
        AllPhases, Contact, Error, Kernel, Model, Phases, Scene, Settings, Surface, SweepsAndNewton,
        SweepsOnly,
    };

    /// Cycles that are fewer than the instructions that the counter can count.
    const COUNTED: usize = 16_000_000 * 18 / 10;
    const BUDGETS: [usize; 8] = [0, 1, 10, 20, 40, 100, 300, 1_000];
    const SLICE_BUDGETS: [usize; 3] = [1, 10, 40];
    /// Slices of a tick that are measured.
    const SLICES: usize = 12;
    /// Steps of hill climbing on the data of the dearest call of a budget: those of large budgets take long.
    const fn steps(budget: usize) -> usize {
        6_000_usize.div_euclid(budget + 60)
    }
    const TOLERANCES: [f32; 5] = [1e-4, 1e-30, 1e-6, 1e-2, 3e-7];
    /// By how much a scene is disturbed, in one variant after the other.
    const DISTURBED: [f32; 6] = [0.0, 1e-3, 0.1, 0.5, 3.0, 30.0];

    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo) -> ! {
        hprintln!("{}", info);
        exit(false)
    }

    /// What a kernel of a size is measured with.
    struct Bench<'a, P, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize> {
        kernel: Kernel<f32, N, D, C, R, S, P>,
        push: Push<N, D, C, R, S>,
        counter: &'a mut Counter,
    }

    impl<P: Phases, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
        Bench<'_, P, N, D, C, R, S>
    {
        /// Instructions of the dearest call of a cold tick and a warm one, each solved and resumed, or prepared and then solved in slices.
        /// `None` if the scene is refused.
        fn dearest(&mut self, tick: &Tick<N, D, C, R>, budget: usize, in_slices: bool) -> Option<u32> {
            let settings = Settings { budget, ..tick.settings };
            let mut given = tick.given.clone();
            let mut random = Random(1);
            let mut dearest = 0;
            self.kernel.solver_mut().reset();
            for is_warm in [false, true] {
                if is_warm {
                    given.disturb(0.01, &mut random); // a tick later
                }
                given.fill(self.kernel.scene_mut(), self.push)?;
                if in_slices {
                    self.kernel.prepare().ok()?;
                }
                for _ in 0..if in_slices { SLICES } else { 2 } {
                    let free_impulse = black_box(given.push());
                    let kernel = &mut self.kernel;
                    let mut is_over = false;
                    let count = self.counter.count(|| {
                        is_over = if in_slices {
                            kernel.advance(free_impulse, &settings).unwrap_or(true)
                        } else {
                            black_box(kernel.resume(free_impulse, &settings).is_ok()) // the first is a solve
                        };
                    });
                    let count = count.unwrap_or(u32::MAX); // more than can be counted
                    dearest = dearest.max(count);
                    if is_over && in_slices {
                        break;
                    }
                }
            }
            Some(dearest)
        }
    }

    /// Measures all scenes of a size and some phases; `None` if a scene is refused.
    #[inline(never)]
    fn measure<P: Phases, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>(
        (name, phases): (&str, P),
        scenes: &[&[f32]],
        push: Push<N, D, C, R, S>,
        counter: &mut Counter,
    ) -> Option<()> {
        let mut bench = Bench { kernel: Kernel::with_phases(phases), push, counter };
        let mut random = Random(1);
        let whole = BUDGETS.iter().map(|&budget| (budget, false));
        for (budget, in_slices) in whole.chain(SLICE_BUDGETS.iter().map(|&budget| (budget, true))) {
            let promise = if in_slices {
                Kernel::<f32, N, D, C, R, S, P>::worst_slice_cycles(budget)
            } else {
                Kernel::<f32, N, D, C, R, S, P>::worst_cycles(budget)
            };
            if promise > COUNTED {
                continue;
            }
            let mut worst: Option<Tick<N, D, C, R>> = None;
            let mut dearest = 0;
            for (k, numbers) in scenes.iter().enumerate() {
                for (variant, &share) in DISTURBED.iter().chain(&DISTURBED).enumerate() {
                    let tolerance = *TOLERANCES.get((k + variant) % TOLERANCES.len())?;
                    let mut given = Given::<N, D, C, R>::read(numbers, S > 0)?;
                    given.disturb(share, &mut random);
                    if variant >= DISTURBED.len() {
                        given.make_dense(&mut random);
                    }
                    let tick = Tick { given, settings: Settings::new(tolerance) };
                    let count = bench.dearest(&tick, budget, in_slices)?;
                    if count > dearest {
                        (dearest, worst) = (count, Some(tick));
                    }
                }
            }
            // Hill climbing from there.
            let mut worst = worst?;
            for _ in 0..steps(budget) {
                let mut tick = worst.clone();
                tick.change(&mut random);
                if let Some(count) = bench.dearest(&tick, budget, in_slices)
                    && count > dearest
                {
                    (dearest, worst) = (count, tick);
                }
            }
            let slice = if in_slices { ":slice" } else { "" };
            hprintln!("{}{} {},{},{},{},{} {} {} {}", name, slice, N, D, C, R, S, budget, promise, dearest);
        }
        Some(())
    }

    /// A scene and how it is solved.
    #[derive(Clone)]
    struct Tick<const N: usize, const D: usize, const C: usize, const R: usize> {
        given: Given<N, D, C, R>,
        settings: Settings<f32>,
    }

    impl<const N: usize, const D: usize, const C: usize, const R: usize> Tick<N, D, C, R> {
        /// Changes a few numbers at random.
        fn change(&mut self, random: &mut Random) {
            for _ in 0..=random.below(4) {
                match random.below(8) {
                    0 => {
                        let tolerance = TOLERANCES.get(random.below(TOLERANCES.len()));
                        self.settings.tolerance = tolerance.copied().unwrap_or(1e-4);
                    }
                    1 => {
                        let is_relaxed = random.below(4) == 0;
                        self.settings.model =
                            if is_relaxed { Model::ConvexRelaxation } else { Model::Coulomb };
                    }
                    _ => self.given.change(random),
                }
            }
        }
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
