//! The record of a solve that is under way.

use crate::linalg::stacked::Stacked;
use crate::real::Real;
use crate::scene::Scene;
use crate::solution::{Model, Settings, Status};
use nalgebra::SVector;

/// What a call does with the last solve.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Call {
    /// It begins another one.
    Begin,
    /// It begins again, with joint rows more.
    Append,
    /// It goes on.
    Resume,
}

/// Does a solve leave a rest, and may it?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)] // so that `Known` is zero, and a new solver takes no flash
pub(super) enum Rest {
    /// The last solution was not at rest, or whether all can stay is known.
    Known,
    /// The last solution was at rest.
    Before,
    /// It is asked whether all can stay. The best impulses so far are a solution in which something slides.
    Asked,
    /// The same, before any solution was found.
    AskedFirst,
    /// The last solution is at rest and good enough. It is asked whether impulses farther inside of the cones are, too.
    Centred,
}

/// What is to be found out about the point before the search goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)] // so that `Nothing` is zero, and a new solver takes no flash
pub(super) enum Question {
    /// Nothing.
    Nothing,
    /// Contact space says that its impulses are good enough. What is their error?
    Error,
    /// A bound on rounding exceeds the tolerance. What is the error, computed with twice the digits?
    ExactError,
}

/// Was a solve begun?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Begun {
    No = 0, // so that a new record is all zeros
    Yes,
    /// With limits, which no other call knows.
    WithLimits,
}

/// What a solve has found so far.
#[derive(Clone, Debug)]
pub(crate) struct Record<T, const D: usize, const C: usize, const R: usize> {
    begun: Begun,
    /// Fingerprint of its data, once a call has ended without an end of the solve.
    fingerprint: u64,
    /// How it ended; `Unsolved` if it has not.
    pub(super) status: Status,
    /// The best impulse so far, and the first part of its error as contact space sees it.
    pub(super) best: Stacked<T, D, C, R>,
    pub(super) estimate: Option<T>,
    /// What is asked about the point.
    pub(super) question: Question,
    /// Number of corrections, see [`super::monitor::Monitor::judge`], and what they left at the last pause.
    pub(super) corrections: u8,
    pub(super) bases: Stacked<T, D, C, R>,
    /// Does the problem count `|stop|`?
    pub(super) counts_stopping: bool,
    /// Was a proof of infeasibility looked for?
    pub(super) has_sought_proof: bool,
    /// The best natural map when it last halved, and the work until then.
    pub(super) milestone: Option<(T, usize)>,
    /// Whether it leaves a rest.
    pub(super) rest: Rest,
}

impl<T: Real, const D: usize, const C: usize, const R: usize> Record<T, D, C, R> {
    /// No solve yet.
    pub(crate) const fn none() -> Self {
        Self {
            begun: Begun::No,
            fingerprint: 0,
            status: Status::Unsolved,
            best: Stacked::zero(),
            estimate: None,
            question: Question::Nothing,
            counts_stopping: false,
            corrections: 0,
            bases: Stacked::zero(),
            has_sought_proof: false,
            milestone: None,
            rest: Rest::Known,
        }
    }

    /// Forgets a solve. (An impulse and its base without the rest say nothing.)
    pub(crate) fn forget(&mut self) {
        self.begun = Begun::No;
        self.status = Status::Unsolved;
        self.estimate = None;
        self.question = Question::Nothing;
        self.counts_stopping = false;
        self.corrections = 0;
        self.has_sought_proof = false;
        self.milestone = None;
        self.rest = Rest::Known;
    }

    /// Begins a solve.
    pub(crate) fn begin(&mut self) {
        self.forget();
        self.begun = Begun::Yes;
    }

    /// Remembers that the solve had limits.
    pub(crate) fn note_limits(&mut self) {
        if !self.is_over() {
            self.begun = Begun::WithLimits;
        }
    }

    /// Was a solve with limits paused?
    pub(crate) fn has_limits(&self) -> bool {
        self.begun == Begun::WithLimits
    }

    /// Remembers of which data the solve is, if it has not ended with the call.
    pub(crate) fn pause(&mut self, fingerprint: impl FnOnce() -> u64) {
        if !self.is_over() {
            self.fingerprint = fingerprint();
        }
    }

    /// Goes on if there is a solve of such data to go on with.
    pub(crate) fn resume(&self, fingerprint: impl FnOnce() -> u64) -> Call {
        if self.begun == Begun::Yes && !self.is_over() && self.fingerprint == fingerprint() {
            Call::Resume
        } else {
            Call::Begin
        }
    }

    /// Has the solve ended, not just its budget?
    pub(crate) fn is_over(&self) -> bool {
        self.status != Status::Unsolved
    }
}

/// Fingerprint of all that a solve depends on.
pub(crate) fn fingerprint<
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize,
    const S: usize,
>(
    scene: &Scene<T, N, D, C, R, S>,
    free_impulse: &SVector<T, N>,
    settings: &Settings<T>,
) -> u64 {
    let data = scene.data_fingerprint(free_impulse);
    settings.tolerance.hash(data) ^ u64::from(settings.model == Model::Coulomb)
}
