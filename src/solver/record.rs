//! The record of a solve that is under way.

use crate::linalg::blocks::ContactVector;
use crate::{Real, Status};

/// What a solve has found so far.
#[derive(Clone, Debug)]
pub(crate) struct Record<T, const D: usize, const C: usize> {
    /// Was one begun?
    is_begun: bool,
    /// How it ended; `Unsolved` if it has not.
    pub(super) status: Status,
    /// The best impulse so far, and the first part of its error as contact space sees it.
    pub(super) best: ContactVector<T, D, C>,
    pub(super) natural_map: Option<T>,
    /// Number of corrections, see [`super::monitor::Monitor::consider`], and what they left at the last pause.
    pub(super) corrections: u8,
    pub(super) bases: ContactVector<T, D, C>,
    /// Does the problem count `|stop|`?
    pub(super) counts_stopping: bool,
    /// Was a proof of infeasibility looked for?
    pub(super) has_sought_proof: bool,
    /// The best natural map when it last halved, and the work until then.
    pub(super) milestone: Option<(T, usize)>,
}

impl<T: Real, const D: usize, const C: usize> Record<T, D, C> {
    /// No solve yet.
    pub(crate) const fn none() -> Self {
        Self {
            is_begun: false,
            status: Status::Unsolved,
            best: [[T::ZERO; D]; C],
            natural_map: None,
            counts_stopping: false,
            corrections: 0,
            bases: [[T::ZERO; D]; C],
            has_sought_proof: false,
            milestone: None,
        }
    }

    /// Forgets a solve. (An impulse and its base without the rest say nothing.)
    pub(crate) fn forget(&mut self) {
        self.is_begun = false;
        self.status = Status::Unsolved;
        self.natural_map = None;
        self.counts_stopping = false;
        self.corrections = 0;
        self.has_sought_proof = false;
        self.milestone = None;
    }

    /// Begins a solve.
    pub(crate) fn begin(&mut self) {
        self.forget();
        self.is_begun = true;
    }

    /// Is there a solve to go on with?
    pub(crate) fn is_paused(&self) -> bool {
        self.is_begun && !self.is_over()
    }

    /// Has the solve ended, not just its budget?
    pub(crate) fn is_over(&self) -> bool {
        self.status != Status::Unsolved
    }
}
