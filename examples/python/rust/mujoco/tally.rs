//! How steps ended.

use super::stepper::Report;
use stiction::Status;

/// Steps of a call: how many, and how they ended.
#[derive(Default)]
pub(super) struct Tally {
    steps: usize,
    pub(super) unsolved: usize,
    worst_error: f64,
    contradictions: usize,
    fallbacks: usize,
    crowded: usize,
    blind: usize,
    last: Option<(Status, f64, usize)>,
}

/// A [`Tally`] for Python: the six counts in order; status, error and work of the last step.
pub(super) type Numbers = (usize, usize, f64, usize, usize, usize, usize, (i64, f64, usize));

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
            self.worst_error = self.worst_error.max(ends.error);
        }
        self.last = Some((ends.status, ends.error, ends.work));
    }

    pub(super) fn numbers(&self) -> Numbers {
        let (status, error, work) = self.last.unwrap_or((Status::Unsolved, 0.0, 0));
        let last = (status as i64, error, work);
        (
            self.steps,
            self.unsolved,
            self.worst_error,
            self.contradictions,
            self.fallbacks,
            self.crowded,
            self.blind,
            last,
        )
    }
}
