//! How steps ended.

use super::stepper::Report;
use pyo3::prelude::*;
use stiction::Status;

/// How many steps there were, and how they ended; a dictionary in Python. Status, error and work are those of the last step.
#[derive(Clone, Copy, Default, FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
pub(super) struct Tally {
    steps: usize,
    pub(super) unsolved: usize,
    worst_unsolved: f64,
    max_error: f64,
    contradictions: usize,
    fallbacks: usize,
    crowded: usize,
    blind: usize,
    status: i64,
    error: f64,
    work: usize,
}

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
        (self.status, self.error, self.work) = (ends.status as i64, ends.error, ends.work);
    }
}
