//! A solver of some phases or all: what it takes to 1e-4, cold and a tick later, and its stack.

use crate::counter::Counter;
use crate::records::{Records, Step};
use crate::stack::stack_bytes;
use core::hint::black_box;
use cortex_m_semihosting::hprintln;
use nalgebra::SVector;
use stiction::{Factor, Phases, Real, Settings, Solver};

pub(crate) struct OfPhases<T: Real, const N: usize, P> {
    scene: &'static str,
    phases: &'static str,
    records: &'static [u8],
    step: Step<T, N, 3, 4>,
    factor: Factor<T, N, 3, 4>,
    solver: Solver<T, N, 3, 4, 0, P>,
}

impl<T: Real, const N: usize, P: Phases> OfPhases<T, N, P> {
    pub(crate) const fn new(
        (scene, records): (&'static str, &'static [u8]),
        (phases, chosen): (&'static str, P),
    ) -> Self {
        Self {
            scene,
            phases,
            records,
            step: Step::new(),
            factor: Factor::empty(),
            solver: Solver::with_phases(chosen),
        }
    }

    /// `None` if something does not succeed.
    pub(crate) fn measure(&mut self, counter: &mut Counter) -> Option<()> {
        self.step.read(&mut Records::new(self.records))?;
        self.factor.prepare(&self.step.scene).ok()?;
        let push = self.step.push;
        let mut ok = true;
        let cold = counter.count(|| ok &= self.solve(&push))?;
        ok &= self.solve(&(push * T::literal(0.99)));
        let warm = counter.count(|| ok &= self.solve(&push))?;
        self.solver.reset();
        let stack = stack_bytes(|| ok &= black_box(self.solve(&push)));
        let Self { scene, phases, .. } = self;
        hprintln!("{} {}_cold_1e-4 {}", scene, phases, cold);
        hprintln!("{} {}_warm_1e-4 {}", scene, phases, warm);
        hprintln!("{} {}_stack {}", scene, phases, stack);
        hprintln!("{} {}_ram {}", scene, phases, size_of_val(&self.solver));
        ok.then_some(())
    }

    #[inline(never)]
    fn solve(&mut self, push: &SVector<T, N>) -> bool {
        let settings = Settings::new(T::literal(1e-4));
        let solution = self.solver.solve(&self.step.scene, &self.factor, push, &settings);
        solution.is_ok_and(|solution| solution.is_solved())
    }
}
