//! The contact solve of a trotting quadruped, cut into slices of work: one a tick, in a task below the control loop.
//!
//! A new state comes in every second tick. In each tick the solver gets a slice, and goes on in the next one with what it
//! could not finish. What is not solved before the next state is due has missed its deadline and is cut off: its impulses
//! are used if their error is small enough, the last good ones are held otherwise.

use crate::records::{Records, Step};
use crate::rtos;
use defmt::{Format, Formatter, write};
use nalgebra::SVector;
use stiction::{Kernel, Settings, Status, heapless};

/// Forty 2 ms steps of a Go2 at `mu` = 0.8 with two to five contacts, see `examples/bake`.
static STATES: &[u8] = include_bytes!("../firmware/trot.bin");
const TICKS_A_STATE: u32 = 2;

/// What the solver may do in a tick: less than it has time for, so that some solves take two, and some are not done then.
const SLICE: Settings<f32> = Settings { budget: 4, ..Settings::new(1e-5) };

/// Error of impulses that are good enough when time is over.
const ENOUGH: f32 = 1e-3;

/// Impulses (N·s), each with the key of its contact: a foot that is not in the list has none.
pub(crate) type Impulses = heapless::Vec<(u32, SVector<f32, 3>), 5>;

/// What came of a slice.
pub(crate) enum Slice {
    /// Nothing to apply: the solver waits for a state, is in the middle of a solve, or was cut off.
    Nothing,
    /// New impulses.
    Good(Impulses),
    /// There are no more states.
    End,
}

/// Recorded states in place of sensors, and the kernel: zeros at first, which take no flash.
pub(crate) struct Feet {
    records: Option<Records<'static>>,
    step: Step<f32, 18, 3, 5>,
    kernel: Kernel<f32, 18, 3, 5>,
    is_paused: bool,
    counts: Counts,
}

/// How solves ended.
struct Counts {
    states: u32,
    /// In the first and in the second tick.
    solved: [u32; 2],
    /// Missed the deadline, with impulses that were good enough, and not.
    used: u32,
    held: u32,
    /// Slices that took longer than their tick.
    late: u32,
}

impl Format for Counts {
    fn format(&self, fmt: Formatter<'_>) {
        let ([first, second], missed) = (self.solved, self.used + self.held);
        write!(fmt, "{} states, {} solved at once, {} in a second tick, ", self.states, first, second);
        write!(fmt, "{} deadlines missed: {} used, {} held; ", missed, self.used, self.held);
        write!(fmt, "{} slices longer than their tick", self.late);
    }
}

impl Feet {
    pub(crate) const fn new() -> Self {
        Self {
            records: None,
            step: Step::new(),
            kernel: Kernel::new(),
            is_paused: false,
            counts: Counts { states: 0, solved: [0; 2], used: 0, held: 0, late: 0 },
        }
    }

    /// Does the slice of a tick.
    pub(crate) fn slice(&mut self, tick: u32) -> Slice {
        let (kernel, counts) = (&mut self.kernel, &mut self.counts);
        let is_new = tick / TICKS_A_STATE >= counts.states;
        let result = if is_new {
            let records = self.records.get_or_insert(Records::new(STATES));
            if self.step.read(records).is_none() {
                defmt::info!("{}", kernel.solution());
                defmt::info!("solver: {}", counts);
                rtos::report();
                return Slice::End;
            }
            counts.states += 1;
            counts.held += u32::from(self.is_paused); // by a slice that took longer than its tick
            kernel.scene_mut().clone_from(&self.step.scene);
            kernel.solve(&self.step.push, &SLICE)
        } else if self.is_paused {
            kernel.resume(&self.step.push, &SLICE)
        } else {
            return Slice::Nothing;
        };
        counts.late += u32::from(rtos::is_over(tick));
        let state = counts.states;
        let solution = match result {
            Ok(solution) => solution,
            Err(error) => {
                counts.held += 1;
                self.is_paused = false;
                defmt::error!("state {}: {}", state, error);
                return Slice::Nothing;
            }
        };
        let is_last = (tick + 1).is_multiple_of(TICKS_A_STATE);
        self.is_paused = solution.status == Status::OutOfBudget && !is_last;
        if self.is_paused {
            return Slice::Nothing;
        }
        if solution.is_solved() {
            let [first, second] = &mut counts.solved;
            *if is_new { first } else { second } += 1;
        } else {
            let (status, error) = (solution.status, solution.error);
            let is_usable = solution.is_usable(ENOUGH);
            *if is_usable { &mut counts.used } else { &mut counts.held } += 1;
            defmt::warn!("state {}: {}, error {}, used: {}", state, status, error, is_usable);
            if !is_usable {
                return Slice::Nothing;
            }
        }
        let mut impulses = Impulses::new();
        for contact in &solution.contacts {
            let _ = impulses.push((contact.key, contact.impulse)); // there is room
        }
        Slice::Good(impulses)
    }
}
