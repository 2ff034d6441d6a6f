//! A race to a tolerance: this crate, and the loop by hand in contact space (`examples/embedded/gauss_seidel.rs`).

use crate::counter::Counter;
use crate::gauss_seidel::GaussSeidel;
use crate::records::{Records, Step};
use cortex_m_semihosting::hprintln;
use stiction::{Factor, Real, Settings, Solver};

/// Sweeps after which the loop gives up.
const MOST: usize = 400;

/// The scenes raced on: those that are measured, and some of `tests/scenes`.
pub(crate) struct Races<T: Real> {
    on_box: Race<T, 6, 3, 4>,
    quadruped: Race<T, 18, 3, 4>,
    planar: Race<T, 18, 2, 4>,
    frictionless: Race<T, 18, 1, 4>,
    walker: Race<T, 9, 2, 4>,
    stack: Race<T, 18, 3, 12>,
    ice: Race<T, 18, 3, 4>,
    trot: Race<T, 18, 3, 5>,
    conveyor: Race<T, 6, 3, 4>,
    skid: Race<T, 10, 3, 4>,
    slope: Race<T, 6, 3, 4>,
}

impl<T: Real> Races<T> {
    pub(crate) const fn new() -> Self {
        let planar = include_bytes!("quadruped_planar.bin");
        let frictionless = include_bytes!("quadruped_frictionless.bin");
        Self {
            on_box: Race::new("box", include_bytes!("box.bin")),
            quadruped: Race::new("quadruped", include_bytes!("quadruped.bin")),
            planar: Race::new("quadruped_planar", planar),
            frictionless: Race::new("quadruped_frictionless", frictionless),
            walker: Race::new("walker", include_bytes!("walker.bin")),
            stack: Race::new("stack", include_bytes!("stack.bin")),
            ice: Race::new("ice", include_bytes!("ice.bin")),
            trot: Race::new("trot", include_bytes!("trot.bin")),
            conveyor: Race::new("conveyor", include_bytes!("conveyor.bin")),
            skid: Race::new("skid", include_bytes!("skid.bin")),
            slope: Race::new("slope", include_bytes!("slope.bin")),
        }
    }

    /// All of them. `None` if something does not succeed.
    pub(crate) fn measure(&mut self, counter: &mut Counter) -> Option<()> {
        self.quadruped.measure(counter)?;
        self.ice.measure(counter)?;
        self.trot.measure(counter)?;
        self.planar.measure(counter)?;
        self.frictionless.measure(counter)?;
        self.walker.measure(counter)?;
        self.skid.measure(counter)?;
        self.on_box.measure(counter)?;
        self.conveyor.measure(counter)?;
        self.slope.measure(counter)?;
        self.stack.measure(counter)
    }
}

struct Race<T: Real, const N: usize, const D: usize, const C: usize> {
    scene: &'static str,
    records: &'static [u8],
    step: Step<T, N, D, C>,
    factor: Factor<T, N, D, C>,
    solver: Solver<T, N, D, C>,
    peer: GaussSeidel<T, N, D, C>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Race<T, N, D, C> {
    const fn new(scene: &'static str, records: &'static [u8]) -> Self {
        Self {
            scene,
            records,
            step: Step::new(),
            factor: Factor::empty(),
            solver: Solver::new(),
            peer: GaussSeidel::new(None),
        }
    }

    /// Prepare and solve cold, both contestants. `None` if something does not succeed.
    fn measure(&mut self, counter: &mut Counter) -> Option<()> {
        self.step.read(&mut Records::new(self.records))?;
        let push = self.step.push;
        let mut ok = true;
        let print = |name: &str, count: u32| hprintln!("{} race_{} {}", self.scene, name, count);
        let scene = &self.step.scene;
        print("prepare", counter.count(|| ok &= self.factor.prepare(scene).is_ok())?);
        print("gs_prepare", counter.count(|| ok &= self.peer.prepare(scene, &push).is_some())?);
        print("gs_sweep", counter.count(|| _ = self.peer.sweep(scene))?);
        for (at, tolerance) in [("1e-2", 1e-2), ("1e-3", 1e-3), ("1e-4", 1e-4), ("1e-5", 1e-5)] {
            let settings = Settings::new(T::literal(tolerance));
            self.solver.reset();
            let solve = || {
                let solved = self.solver.solve(scene, &self.factor, &push, &settings);
                ok &= solved.is_ok_and(|solution| solution.is_solved());
            };
            let count = counter.count(solve)?;
            hprintln!("{} race_{} {}", self.scene, at, count);
            self.peer.reset();
            let mut sweeps = MOST;
            let until = || sweeps = self.peer.solve(scene, settings.tolerance, MOST);
            // Of hundreds of sweeps the timer loses count.
            if let Some(count) = counter.count(until)
                && sweeps < MOST
            {
                hprintln!("{} race_gs_{} {}", self.scene, at, count);
                hprintln!("{} race_gs_sweeps_{} {}", self.scene, at, sweeps);
            }
        }
        ok.then_some(())
    }
}
