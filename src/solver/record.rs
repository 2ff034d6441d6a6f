//! The record of a solve: its findings, which survive a pause.

use crate::linalg::stacked::Stacked;
use crate::problem::Age;
use crate::real::Real;
use crate::solution::Status;

/// What a call does with the last solve.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Call {
    /// It begins another solve.
    Begin,
    /// It begins the same solve again, with more joint rows. Earlier passes of the call took this work from its budget.
    Append(usize),
    /// It continues the solve.
    Resume,
}

impl Call {
    /// Work of the passes before in the same call.
    pub(crate) const fn spent(self) -> usize {
        if let Self::Append(spent) = self { spent } else { 0 }
    }
}

/// The rest question, "can all bodies stay at rest?", and how far a solve is with it (see [`super::rest`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)] // so that `Closed` is zero, and a new solver takes no flash
pub(super) enum RestQuestion {
    /// The question is not asked: the last solution was not at rest, or no path has jammed.
    Closed,
    /// The question is answered, or was given up.
    Answered,
    /// The last solution was at rest. The question opens if the solve finds a solution in which a body moves.
    Pending,
    /// The question is open. The best impulses so far are a solution, in which a body slides or is about to.
    OpenWithSolution,
    /// The question is open, and no solution is known yet.
    Open,
    /// The same, asked because a path has jammed.
    OpenAfterJam,
    /// The last solution is at rest and still solves the scene. The solve looks for impulses farther inside the cones.
    Centring,
}

/// The check of the error that is due before the search continues.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)] // so that `None` is zero, and a new solver takes no flash
pub(super) enum Check {
    /// No check.
    None,
    /// The estimate of the best impulses is within the tolerance: their error is computed.
    Error,
    /// A bound on rounding exceeds the tolerance: the error is computed with twice the digits.
    ExactError,
}

/// The measure by which impulses are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)] // so that `Estimate` is zero, and a new solver takes no flash
pub(crate) enum Measure {
    /// The estimate of their error.
    Estimate,
    /// Their error, with its bounds on rounding.
    Error,
}

/// Is a solve under way?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Begun {
    No = 0, // so that a new record is all zeros
    Yes,
    /// Yes, and with joint limits, which no other call knows.
    WithLimits,
}

/// The least estimate when it last halved, and the work up to then.
#[derive(Clone, Copy, Debug)]
pub(super) struct Milestone<T> {
    pub(super) estimate: T,
    pub(super) work: usize,
}

/// The findings of a solve so far.
#[derive(Clone, Debug)]
pub(crate) struct Record<T, const D: usize, const C: usize, const R: usize> {
    begun: Begun,
    /// Fingerprint of the data, once a call has ended before the solve.
    fingerprint: u64,
    /// End of the solve; `Unsolved` while it is under way.
    pub(super) status: Status,
    /// Best impulses so far.
    pub(super) best: Stacked<T, D, C, R>,
    /// Estimate of their error (see [`super::monitor`]), or that error.
    pub(super) best_estimate: Option<T>,
    /// Which of both `best_estimate` is.
    pub(super) measure: Measure,
    pub(super) check: Check,
    pub(super) factor_age: Age,
    /// Number of corrections of the velocities, see [`super::refinement`].
    pub(super) corrections: u8,
    /// Constant terms of the velocities, corrections included, at the last pause.
    pub(super) bases: Stacked<T, D, C, R>,
    /// Does the expected size of the impulses include `|stop|` ([`crate::guide::error`])?
    pub(super) counts_stopping: bool,
    /// Was a proof of infeasibility looked for?
    pub(super) has_sought_proof: bool,
    /// Were impulses refused because they are doubtful?
    pub(super) has_doubted: bool,
    pub(super) milestone: Option<Milestone<T>>,
    pub(super) rest: RestQuestion,
}

impl<T: Real, const D: usize, const C: usize, const R: usize> Record<T, D, C, R> {
    /// The record before any solve.
    pub(crate) const fn none() -> Self {
        Self {
            begun: Begun::No,
            fingerprint: 0,
            status: Status::Unsolved,
            best: Stacked::zero(),
            best_estimate: None,
            measure: Measure::Estimate,
            check: Check::None,
            counts_stopping: false,
            factor_age: Age::New,
            corrections: 0,
            bases: Stacked::zero(),
            has_sought_proof: false,
            has_doubted: false,
            milestone: None,
            rest: RestQuestion::Closed,
        }
    }

    /// Forgets a solve. (`best` and `bases` are not read before they are written again.)
    pub(crate) fn forget(&mut self) {
        self.begun = Begun::No;
        self.status = Status::Unsolved;
        self.best_estimate = None;
        self.measure = Measure::Estimate;
        self.check = Check::None;
        self.counts_stopping = false;
        self.corrections = 0;
        self.has_sought_proof = false;
        self.has_doubted = false;
        self.milestone = None;
        self.rest = RestQuestion::Closed;
    }

    /// Begins a solve.
    pub(crate) fn begin(&mut self) {
        self.forget();
        self.begun = Begun::Yes;
    }

    /// Notes that the solve has joint limits, unless it has ended, and includes the fingerprint of their rows in that of the data.
    pub(crate) fn note_limits(&mut self, fingerprint: impl FnOnce() -> u64) {
        if self.begun == Begun::Yes && !self.is_over() {
            self.begun = Begun::WithLimits;
            self.fingerprint ^= fingerprint();
        }
    }

    /// Is a solve with joint limits paused?
    pub(crate) fn has_limits(&self) -> bool {
        self.begun == Begun::WithLimits && !self.is_over()
    }

    /// Keeps the fingerprint of the data, unless the solve has ended.
    pub(crate) fn pause(&mut self, fingerprint: impl FnOnce() -> u64) {
        if !self.is_over() {
            self.fingerprint = fingerprint();
        }
    }

    /// Is a solve of data with this fingerprint paused?
    pub(crate) fn is_paused(&self, fingerprint: impl FnOnce() -> u64) -> bool {
        self.begun != Begun::No && !self.is_over() && self.fingerprint == fingerprint()
    }

    /// [`Call::Resume`] if a solve of data with this fingerprint is paused, otherwise [`Call::Begin`].
    pub(crate) fn resume(&self, fingerprint: impl FnOnce() -> u64) -> Call {
        if self.is_paused(fingerprint) { Call::Resume } else { Call::Begin }
    }

    /// Has the solve ended, not only the budget of its call?
    pub(crate) fn is_over(&self) -> bool {
        self.status != Status::Unsolved
    }
}
