//! How steps ended.

use super::stepper::Report;
use stiction::Status;

/// How steps ended: how many, and how; for Python as numbers in this order.
#[derive(Clone, Copy, Default)]
pub(super) struct Tally {
    steps: usize,
    pub(super) unsolved: usize,
    worst_unsolved: f64,
    max_error: f64,
    contradictions: usize,
    fallbacks: usize,
    crowded: usize,
    blind: usize,
    last: (i64, f64, usize),
}

/// The numbers of a [`Tally`]; at last status, error and work of the last step.
pub(super) type Numbers = (usize, usize, f64, f64, usize, usize, usize, usize, (i64, f64, usize));

impl Tally {
    pub(super) fn add(&mut self, report: &Report) {
        let ends = &report.ends;
        self.steps += 1;
        self.contradictions += usize::from(ends.contradicts);
        self.fallbacks += usize::from(ends.gave_way);
        self.crowded += usize::from(ends.is_crowded);
        self.blind += usize::from(report.is_blind);
        if ends.status != Status::Solved {
            self.unsolved += 1;
            self.worst_unsolved = self.worst_unsolved.max(ends.error);
        }
        self.max_error = self.max_error.max(ends.error);
        self.last = (ends.status as i64, ends.error, ends.work);
    }

    pub(super) fn numbers(&self) -> Numbers {
        let &Self {
            steps,
            unsolved,
            worst_unsolved,
            max_error,
            contradictions,
            fallbacks,
            crowded,
            blind,
            last,
        } = self;
        (steps, unsolved, worst_unsolved, max_error, contradictions, fallbacks, crowded, blind, last)
    }

    pub(super) fn of(numbers: Numbers) -> Self {
        let (steps, unsolved, worst_unsolved, max_error, contradictions, fallbacks, crowded, blind, last) =
            numbers;
        Self { steps, unsolved, worst_unsolved, max_error, contradictions, fallbacks, crowded, blind, last }
    }
}
