//! The control loop: forty steps of a trotting quadruped, each started from the one before.

use crate::records::{Records, Step};
use core::fmt::{self, Display, Write};
use nalgebra::SVector;
use stiction::{ContactMode, Factor, Real, Settings, Solution, Solver, heapless};

const N: usize = 18;
const D: usize = 3;
const C: usize = 5;

/// Forty consecutive 2 ms steps of the Go2 trotting at `mu` = 0.8, see `examples/bake`: feet and
/// calves touch down and lift off, two to five contacts at a time.
static STEPS: &[u8] = include_bytes!("trot.bin");

/// Work that a step has time for.
const BUDGET: usize = 100;

/// Error of a solution that is good enough, if the budget ends before it is solved.
const ENOUGH: f64 = 1e-2;

/// All that lives from step to step.
pub(crate) struct Trot<T: Real> {
    records: Records<'static>,
    step: Step<T, N, D, C>,
    factor: Factor<T, N, D, C>,
    solver: Solver<T, N, D, C>,
    /// The last good impulses (N·s), each with the key of its contact: a foot keeps its own when others come and go.
    impulses: heapless::Vec<(u32, SVector<T, D>), C>,
    count: usize,
}

impl<T: Real> Trot<T> {
    pub(crate) const fn new() -> Self {
        Self {
            records: Records::new(STEPS),
            step: Step::new(),
            factor: Factor::empty(),
            solver: Solver::new(),
            impulses: heapless::Vec::new(),
            count: 0,
        }
    }

    /// Reads the next step, as a robot would its state; `false` after the last.
    pub(crate) fn sense(&mut self) -> bool {
        if self.step.read(&mut self.records).is_none() {
            return false;
        }
        self.count += 1;
        true
    }

    /// Prepares and solves. Returns `false` if nothing good came of it: the impulses of an earlier step stay.
    pub(crate) fn solve(&mut self) -> bool {
        let Step { scene, push, .. } = &self.step;
        let settings = Settings { budget: BUDGET, ..Settings::default() };
        let prepared = self.factor.prepare(scene);
        let solver = &mut self.solver;
        match prepared.and_then(|()| solver.solve(scene, &self.factor, push, &settings)) {
            Ok(solution) if solution.is_usable(T::literal(ENOUGH)) => {
                self.impulses.clear();
                for contact in &solution.contacts {
                    // There is room: both hold `C`.
                    let _ = self.impulses.push((contact.key, contact.impulse));
                }
                true
            }
            _ => false,
        }
    }

    /// A line on the last solution, and every impulse that the robot would use by its bits.
    pub(crate) fn report(&self, out: &mut impl Write) -> fmt::Result {
        let solution = self.solver.solution();
        write!(out, "{:2} {}", self.count, Summary(solution))?;
        for (key, impulses) in &self.impulses {
            write!(out, "  {key}:")?;
            for impulse in impulses {
                // An f32 as it is, an f64 rounded towards it and what is left.
                let high: f32 = impulse.to_subset_unchecked();
                let low = *impulse - T::literal(f64::from(high));
                write!(out, " {:08x}", high.to_bits())?;
                if low != T::ZERO {
                    let low: f32 = low.to_subset_unchecked();
                    write!(out, "+{:08x}", low.to_bits())?;
                }
            }
        }
        Ok(())
    }
}

/// What the contacts do, and how that was found.
struct Summary<'a, T: Real>(&'a Solution<T, N, D, C>);

impl<T: Real> Display for Summary<'_, T> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let solution = self.0;
        let error: f64 = solution.error.to_subset_unchecked();
        for contact in &solution.contacts {
            out.write_str(match contact.mode {
                ContactMode::Open => "o",
                ContactMode::Stick => "=",
                ContactMode::Slip => "~",
            })?;
        }
        let (total, steps) = (solution.work.total(), solution.work.newton_steps);
        let iterations = total - 10 * steps;
        write!(out, " {iterations}+{steps} {error:.1e}")
    }
}
