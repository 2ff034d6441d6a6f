//! Instructions of each stage of a tick, and deadlines that a chip would miss.
//!
//! QEMU counts instructions: with `-icount shift=3` an instruction takes 8 ns, a fifth of a count of the board's timer. A chip takes
//! 1.51 to 1.85 cycles for an instruction of this crate, by the model of `examples/cycles` for a Cortex-M4F without wait states, and
//! 1.8 to 2.8 with five wait states. So cycles are 1.8 times the instructions here, and 2.5 times with wait states. A deadline is
//! missed if a tick takes more cycles than a millisecond has at 168 MHz. On a board, read the core's cycle counter instead.

use crate::controller::{Clock, Stage};
use crate::pace;
use core::fmt::{self, Write};

/// Instructions in a count of the emulated timer.
const INSTRUCTIONS: u32 = 5;
/// Cycles of ten instructions, without and with wait states.
const CYCLES: [u32; 2] = [18, 25];
/// Cycles in a millisecond at 168 MHz.
const DEADLINE: u32 = 168_000;

/// Instructions of a stage in all ticks.
#[derive(Clone, Copy)]
struct Tally {
    times: u32,
    sum: u32,
    most: u32,
}

impl Tally {
    const NONE: Self = Self { times: 0, sum: 0, most: 0 };

    fn add(&mut self, instructions: u32) {
        self.times += 1;
        self.sum += instructions;
        self.most = self.most.max(instructions);
    }
}

/// Clock of the control loop.
pub(crate) struct Timing {
    /// Beginning of the tick, in counts of the timer.
    tick: u32,
    /// Beginning of its stage.
    stage: u32,
    stages: [Tally; 4],
    /// Ticks with a solve.
    whole: Tally,
    has_solved: bool,
    ticks: u32,
    missed: [u32; 2],
}

impl Timing {
    pub(crate) const fn new() -> Self {
        Self {
            tick: 0,
            stage: 0,
            stages: [Tally::NONE; 4],
            whole: Tally::NONE,
            has_solved: false,
            ticks: 0,
            missed: [0; 2],
        }
    }

    /// Writes a table. Its lines begin with a semicolon: there are none on the host.
    pub(crate) fn report(&self, out: &mut impl Write) -> fmt::Result {
        writeln!(out, ";instructions    mean    most")?;
        let names = ["dynamics", "fill", "solve", "torques", "tick"];
        for (name, tally) in names.iter().zip(self.stages.iter().chain([&self.whole])) {
            let mean = tally.sum.checked_div(tally.times).unwrap_or(0);
            writeln!(out, ";{name:12}{mean:8}{:8}", tally.most)?;
        }
        for (missed, cycles) in self.missed.iter().zip(CYCLES) {
            let (ticks, most) = (self.ticks, self.whole.most * cycles / 10);
            write!(out, ";{missed} of {ticks} deadlines missed at {cycles} cycles for ten instructions: ")?;
            writeln!(out, "at most {most} of {DEADLINE} cycles")?;
        }
        Ok(())
    }
}

impl Clock for Timing {
    fn wait(&mut self) {
        pace::wait();
        self.tick = pace::counts();
        self.stage = self.tick;
        self.has_solved = false;
    }

    fn end(&mut self, stage: Stage) {
        let now = pace::counts();
        let [dynamics, fill, solve, torques] = &mut self.stages;
        let tally = match stage {
            Stage::Dynamics => dynamics,
            Stage::Fill => fill,
            Stage::Solve => solve,
            Stage::Torques => torques,
        };
        tally.add(now.wrapping_sub(self.stage) * INSTRUCTIONS);
        self.has_solved |= matches!(stage, Stage::Solve);
        if matches!(stage, Stage::Torques) {
            let instructions = now.wrapping_sub(self.tick) * INSTRUCTIONS;
            self.ticks += 1;
            if self.has_solved {
                self.whole.add(instructions);
            }
            for (missed, cycles) in self.missed.iter_mut().zip(CYCLES) {
                *missed += u32::from(instructions * cycles / 10 > DEADLINE);
            }
        }
        self.stage = pace::counts();
    }
}
