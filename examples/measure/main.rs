//! Instructions, RAM and stack of the kernel on an emulated Cortex-M (`.ci/firmware` runs it), or cycles on a board
//! (`examples/embedded/boards`).
//!
//! A line is `scene quantity value`. A warm solve starts from the solution of a free impulse 1 % smaller. Beside it the loop that
//! one writes by hand in contact space (`race`).
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("measures on an emulated board: run .ci/firmware");
}

#[cfg(target_os = "none")]
#[path = "../embedded/board.rs"]
mod board;
#[cfg(target_os = "none")]
#[path = "../embedded/counter.rs"]
mod counter;
#[cfg(target_os = "none")]
mod derivative;
#[cfg(target_os = "none")]
#[path = "../embedded/gauss_seidel.rs"]
mod gauss_seidel;
#[cfg(target_os = "none")]
mod limits;
#[cfg(target_os = "none")]
mod phases;
#[cfg(target_os = "none")]
mod race;
#[cfg(target_os = "none")]
#[path = "../embedded/records.rs"]
mod records;
#[cfg(target_os = "none")]
mod sharing;
#[cfg(target_os = "none")]
#[path = "../embedded/stack.rs"]
mod stack;

#[cfg(target_os = "none")]
mod measure {
    use crate::board::exit;
    use crate::counter::Counter;
    use crate::derivative;
    use crate::limits::Limits;
    use crate::phases::OfPhases;
    use crate::race::Races;
    use crate::records::{Records, Step};
    use crate::sharing::Sharing;
    use crate::stack::stack_bytes;
    use core::hint::black_box;
    use cortex_m_rt::entry;
    use cortex_m_semihosting::hprintln;
    use nalgebra::SVector;
    use stiction::{
        AdmmFactor, AdmmSolver, AllPhases, Factor, Real, Settings, Solver, Status, SweepsAndNewton,
        SweepsOnly,
    };

    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo) -> ! {
        hprintln!("{}", info);
        exit(false)
    }

    struct Bench<T: Real, const N: usize, const D: usize, const C: usize> {
        name: &'static str,
        records: &'static [u8],
        step: Step<T, N, D, C>,
        factor: Factor<T, N, D, C>,
        admm_factor: AdmmFactor<T, N, D, C>,
        solver: Solver<T, N, D, C>,
        admm: AdmmSolver<T, N, D, C>,
    }

    impl<T: Real, const N: usize, const D: usize, const C: usize> Bench<T, N, D, C> {
        const fn new(name: &'static str, records: &'static [u8]) -> Self {
            Self {
                name,
                records,
                step: Step::new(),
                factor: Factor::empty(),
                admm_factor: AdmmFactor::empty(),
                solver: Solver::new(),
                admm: AdmmSolver::new(),
            }
        }

        fn print(&self, quantity: &str, value: u32) {
            hprintln!("{} {} {}", self.name, quantity, value);
        }

        #[inline(never)]
        fn prepare(&mut self) -> bool {
            black_box(&mut self.factor).prepare(&self.step.scene).is_ok()
        }

        #[inline(never)]
        fn prepare_admm(&mut self) -> bool {
            black_box(&mut self.admm_factor).prepare(&self.step.scene).is_ok()
        }

        #[inline(never)]
        fn solve(&mut self, push: &SVector<T, N>, settings: &Settings<T>) -> bool {
            let solution = self.solver.solve(&self.step.scene, &self.factor, push, settings);
            solution.is_ok_and(|solution| solution.status == Status::Solved)
        }

        #[inline(never)]
        fn iterate(&mut self, push: &SVector<T, N>, settings: &Settings<T>) -> bool {
            let admm = black_box(&mut self.admm);
            admm.reset();
            admm.solve(&self.step.scene, &self.admm_factor, push, settings).is_ok()
        }

        /// All quantities; `None` if something does not succeed.
        fn measure(&mut self, counter: &mut Counter) -> Option<()> {
            self.step.read(&mut Records::new(self.records))?;
            let push = self.step.push;
            let mut ok = true;

            let count = counter.count(|| ok &= self.prepare())?;
            self.print("prepare", count);
            let count = counter.count(|| ok &= self.prepare_admm())?;
            self.print("prepare_restart", count);

            // Iterations and Newton steps: the difference of two solves that differ in them alone.
            let mut exact = Settings::new(T::literal(1e-30));
            let mut limited = |bench: &mut Self, iterations| {
                exact.budget = iterations;
                let count = counter.count(|| ok &= bench.iterate(&push, &exact));
                (count, bench.admm.solution().work.iterations)
            };
            let (few, more) = (limited(self, 2), limited(self, 10));
            if more.1 == few.1 + 8 {
                self.print("iteration", more.0?.checked_sub(few.0?)? / 8);
            }
            let mut limited = |bench: &mut Self, iterations| {
                bench.solver.reset();
                exact.budget = iterations;
                let count = counter.count(|| _ = bench.solve(&push, &exact));
                let solution = bench.solver.solution();
                (count, (solution.work.total() - 10 * solution.work.newton_steps, solution.work.newton_steps))
            };
            let mut last = limited(self, 0);
            for iterations in 1..8 {
                let next = limited(self, iterations);
                let (done, steps) = last.1;
                if next.1 == (done, steps + 1) {
                    self.print("newton_step", next.0?.checked_sub(last.0?)?);
                    break;
                }
                last = next;
            }

            let before = push * T::literal(0.99);
            for (cold, warm, tolerance) in [
                ("cold_1e-3", "warm_1e-3", 1e-3),
                ("cold_1e-4", "warm_1e-4", 1e-4),
                ("cold_1e-5", "warm_1e-5", 1e-5),
            ] {
                let settings = Settings::new(T::literal(tolerance));
                self.solver.reset();
                let count = counter.count(|| ok &= self.solve(&push, &settings))?;
                self.print(cold, count);
                self.solver.reset();
                ok &= self.solve(&before, &settings);
                let count = counter.count(|| ok &= self.solve(&push, &settings))?;
                self.print(warm, count);
            }

            let fine = Settings::new(T::literal(1e-5));
            let data = (&self.step.scene, &self.factor);
            derivative::measure(self.name, data, self.solver.solution(), &fine, counter)?;
            self.measure_pieces(counter, &push)?;
            let settings = Settings::new(T::literal(1e-5));
            self.solver.reset();
            let bytes = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
            let prepare = stack_bytes(|| _ = black_box(self.prepare()));
            let solve = stack_bytes(|| _ = black_box(self.solve(&push, &settings)));
            let iterate = stack_bytes(|| _ = black_box(self.iterate(&push, &settings)));
            self.print("stack_prepare", bytes(prepare));
            self.print("stack_solve", bytes(solve));
            self.print("stack_restart", bytes(iterate));
            self.print("ram_scene", bytes(size_of_val(&self.step.scene)));
            self.print("ram_factor", bytes(size_of_val(&self.factor)));
            self.print("ram_solver", bytes(size_of_val(&self.solver)));
            self.print("ram_restart", bytes(size_of_val(&self.admm)));
            let all = stack_bytes(|| ok &= self.solve_by_all_phases(&push));
            self.print("stack_all_phases", bytes(all));
            ok.then_some(())
        }

        /// What a solve in pieces costs more than in one, for each piece, and the longest piece.
        fn measure_pieces(&mut self, counter: &mut Counter, push: &SVector<T, N>) -> Option<()> {
            let whole = Settings::new(T::literal(1e-5));
            let piece = Settings { budget: 1, ..whole };
            let mut pieces = 0;
            let mut counted = |settings: &Settings<T>| {
                self.solver.reset();
                counter.count(|| {
                    pieces = 1;
                    let (scene, factor) = (&self.step.scene, &self.factor);
                    while self.solver.advance(scene, factor, push, settings) == Ok(false) {
                        pieces += 1;
                    }
                })
            };
            let all = counted(&whole)?;
            let in_pieces = counted(&piece)?;
            // The stack is solved by the first.
            if let Some(more) = in_pieces.saturating_sub(all).checked_div(pieces - 1) {
                self.print("piece", more);
            }
            self.solver.reset();
            let (mut longest, mut has_ended) = (0, false);
            while !has_ended {
                let (scene, factor) = (&self.step.scene, &self.factor);
                let solver = &mut self.solver;
                let count = counter.count(|| {
                    has_ended = solver.advance(scene, factor, push, &piece) != Ok(false);
                })?;
                longest = longest.max(count);
            }
            self.print("slice", longest);
            Some(())
        }

        /// A solve that goes through sweeps, Newton's method, a search for a proof and the interior point: its tolerance is out
        /// of reach, and a contact penetrates a little. `false` if it has left one out.
        #[inline(never)]
        fn solve_by_all_phases(&mut self, push: &SVector<T, N>) -> bool {
            let Some(contact) = self.step.scene.contacts().first() else {
                return false;
            };
            let mut offset = contact.offset;
            if let Some(normal) = offset.iter_mut().next() {
                *normal = T::literal(-1e-3);
            }
            let settings = Settings { budget: 2000, ..Settings::new(T::literal(1e-30)) };
            self.solver.reset();
            let set = self.step.scene.set_offset(0, &offset);
            let solved = self.solve(push, &settings);
            let work = self.solver.solution().work;
            // Newton's method takes 30 steps in a row at most.
            set.is_ok() && !solved && work.newton_steps > 60 && work.proof_searches == 1
        }
    }

    /// Double precision where the core has it.
    #[cfg(double)]
    type Number = f64;
    #[cfg(not(double))]
    type Number = f32;

    const ON_A_BOX: (&str, &[u8]) = ("box", include_bytes!("box.bin"));
    const ON_A_QUADRUPED: (&str, &[u8]) = ("quadruped", include_bytes!("quadruped.bin"));
    const ALL: (&str, AllPhases) = ("all", AllPhases);
    const NEWTON: (&str, SweepsAndNewton) = ("newton", SweepsAndNewton);
    const SWEEPS: (&str, SweepsOnly) = ("sweeps", SweepsOnly);

    #[entry]
    fn main() -> ! {
        static mut WHOLE_BOX: OfPhases<Number, 6, AllPhases> = OfPhases::new(ON_A_BOX, ALL);
        static mut WHOLE_QUADRUPED: OfPhases<Number, 18, AllPhases> = OfPhases::new(ON_A_QUADRUPED, ALL);
        static mut LEAN_BOX: OfPhases<Number, 6, SweepsAndNewton> = OfPhases::new(ON_A_BOX, NEWTON);
        static mut LEANER_BOX: OfPhases<Number, 6, SweepsOnly> = OfPhases::new(ON_A_BOX, SWEEPS);
        static mut LEAN_QUADRUPED: OfPhases<Number, 18, SweepsAndNewton> =
            OfPhases::new(ON_A_QUADRUPED, NEWTON);
        static mut LEANER_QUADRUPED: OfPhases<Number, 18, SweepsOnly> = OfPhases::new(ON_A_QUADRUPED, SWEEPS);
        static mut BOX: Bench<Number, 6, 3, 4> = Bench::new("box", include_bytes!("box.bin"));
        static mut QUADRUPED: Bench<Number, 18, 3, 4> =
            Bench::new("quadruped", include_bytes!("quadruped.bin"));
        static mut PLANAR: Bench<Number, 18, 2, 4> =
            Bench::new("quadruped_planar", include_bytes!("quadruped_planar.bin"));
        static mut FRICTIONLESS: Bench<Number, 18, 1, 4> =
            Bench::new("quadruped_frictionless", include_bytes!("quadruped_frictionless.bin"));
        static mut WALKER: Bench<Number, 9, 2, 4> = Bench::new("walker", include_bytes!("walker.bin"));
        static mut STACK: Bench<Number, 18, 3, 12> = Bench::new("stack", include_bytes!("stack.bin"));
        static mut LIMITS: Limits<Number> = Limits::new();
        static mut RACES: Races<Number> = Races::new();
        static mut SHARING: Sharing<Number> = Sharing::new();
        let Some(peripherals) = cortex_m::Peripherals::take() else { exit(false) };
        let mut counter = Counter::start(peripherals);
        if counter.counts_cycles() {
            hprintln!("a board: cycles, not instructions");
        }
        let done = [
            BOX.measure(&mut counter),
            QUADRUPED.measure(&mut counter),
            PLANAR.measure(&mut counter),
            FRICTIONLESS.measure(&mut counter),
            WALKER.measure(&mut counter),
            STACK.measure(&mut counter),
            LIMITS.measure(include_bytes!("quadruped.bin"), &mut counter),
            RACES.measure(&mut counter),
            SHARING.measure(&mut counter),
            WHOLE_BOX.measure(&mut counter),
            WHOLE_QUADRUPED.measure(&mut counter),
            LEAN_BOX.measure(&mut counter),
            LEANER_BOX.measure(&mut counter),
            LEAN_QUADRUPED.measure(&mut counter),
            LEANER_QUADRUPED.measure(&mut counter),
        ];
        exit(done.iter().all(Option::is_some))
    }
}
