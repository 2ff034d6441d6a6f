//! The state of a solve between two pieces of work.

use crate::linalg::stacked::StackedMatrix;
use crate::real::Real;
use crate::sets::jacobian::Jacobian;
use crate::sets::pairs::Pairs;
use crate::sets::point::NewtonPoint;
use crate::solver::tuning;
use crate::solver::warm_start::WarmStartKind;

/// The next piece of work.
#[derive(Clone, Copy, Debug)]
#[repr(u8)] // so that `Idle` is zero, and a new solver takes no flash
pub(crate) enum Phase {
    /// No work: no solve was begun, or a known solution has ended it.
    Idle,
    /// The choice of the first phase. It waits while a check of the start is due.
    Start(WarmStartKind),
    /// A Gauss-Seidel sweep.
    Sweeps,
    /// A step of Newton's method.
    Newton(Newton),
    /// A step along the central path.
    CentralPath,
}

/// The failure of a phase.
#[derive(Clone, Copy, Debug)]
pub(super) enum Failure {
    /// A step of Newton's method was rejected, which began there.
    Rejected(Origin),
    /// The central path has jammed.
    Jammed,
}

/// What follows a piece of work: a phase, or a failure, from which the method has to recover.
pub(super) type Next = Result<Phase, Failure>;

/// The state of a solve, for all phases.
#[derive(Clone, Debug)]
pub(crate) struct State<T: Real, const D: usize, const C: usize, const R: usize> {
    /// The next piece of work.
    pub(super) phase: Phase,
    pub(super) point: NewtonPoint<T, D, C, R>,
    pub(super) sweeps: Sweeps<T, C>,
    pub(super) path: CentralPath<T, D, C, R>,
    /// The Jacobian of Newton's method, except for its matrix.
    pub(super) jacobian: Jacobian<T, D, C, R>,
    /// The only matrix that a solve needs beside the factor, factorised. Newton steps and steps along the central path share it.
    pub(super) matrix: StackedMatrix<T, D, C, R>,
    /// Does `matrix` belong to `jacobian`?
    pub(super) holds_jacobian: bool,
}

impl<T: Real, const D: usize, const C: usize, const R: usize> State<T, D, C, R> {
    /// The state before any solve.
    pub(crate) const fn none() -> Self {
        Self {
            phase: Phase::Idle,
            point: NewtonPoint::none(),
            sweeps: Sweeps::none(),
            path: CentralPath::none(),
            jacobian: Jacobian::none(),
            matrix: StackedMatrix::zero(),
            holds_jacobian: false,
        }
    }

    /// Forgets the kept Jacobian.
    pub(super) fn forget(&mut self) {
        self.holds_jacobian = false;
    }
}

/// The state of Newton's method between two steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Newton {
    /// Number of steps that it may still make.
    pub(super) remaining_steps: u8,
    /// May the next full step raise the merit?
    pub(super) may_raise_merit: bool,
    /// Does the next step begin with chord steps?
    pub(super) reuse: bool,
    /// Do sweeps come before a new Jacobian?
    pub(super) sweeps_first: bool,
    pub(super) origin: Origin,
}

/// The kind of point at which Newton's method began.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Origin {
    /// At zero impulses, or after sweeps, also those of a warm start.
    Cold,
    /// On the central path.
    Path,
    /// At the last solution.
    LastSolution,
    /// At the guess that all contacts stick, where the merit tells nothing.
    Guess,
}

impl Newton {
    /// Begins at zero impulses.
    pub(crate) fn new() -> Self {
        Self {
            remaining_steps: u8::try_from(tuning::newton_steps()).unwrap_or(u8::MAX),
            may_raise_merit: false,
            reuse: false,
            sweeps_first: false,
            origin: Origin::Cold,
        }
    }

    /// Begins after sweeps.
    pub(crate) fn after_sweeps() -> Self {
        Self { reuse: true, ..Self::new() }
    }

    /// Begins on the central path.
    pub(crate) fn finish() -> Self {
        Self { origin: Origin::Path, ..Self::new() }
    }

    /// Begins at the guess that all contacts stick.
    pub(crate) fn guessed() -> Self {
        Self { may_raise_merit: true, origin: Origin::Guess, ..Self::new() }
    }

    /// Begins at the same guess, to move impulses away from the boundaries of their cones with one Jacobian.
    pub(crate) fn centring() -> Self {
        Self { remaining_steps: 2, ..Self::guessed() }
    }

    /// Begins at the last solution.
    pub(crate) fn warm(sweeps_first: bool) -> Self {
        Self { reuse: true, sweeps_first, origin: Origin::LastSolution, ..Self::new() }
    }

    /// Newton's method with one remaining step.
    #[cfg(test)]
    pub(super) fn with_one_step() -> Self {
        Self { remaining_steps: 1, ..Self::new() }
    }

    /// Damping `δ` after Levenberg and Marquardt. It falls with the estimate of the error to a floor of 1e-12 (f32: 64 eps),
    /// about the rounding of a well-conditioned `W`, so that the last steps are hardly damped.
    pub(super) fn damping<T: Real>(self, estimate: T) -> T {
        let share: T =
            if matches!(self.origin, Origin::Path) { tuning::finish_damping() } else { tuning::damping() };
        share * estimate.min(T::ONE) + T::literal(1e-12).max(T::EPSILON * T::literal(64.0))
    }

    /// May it make no more steps?
    pub(crate) const fn is_spent(self) -> bool {
        self.remaining_steps == 0
    }
}

/// The state of Gauss-Seidel sweeps.
#[derive(Clone, Debug)]
pub(crate) struct Sweeps<T, const C: usize> {
    /// Slip multiplier `λ` of each contact ([`crate::guide::method`]).
    pub(super) multipliers: [T; C],
    /// Number of sweeps so far.
    pub(super) done: u16,
    /// Number of sweeps to make however slow they are.
    pub(super) at_least: u16,
}

impl<T: Real, const C: usize> Sweeps<T, C> {
    /// The state before the first sweep.
    pub(crate) const fn none() -> Self {
        Self { multipliers: [T::ZERO; C], done: 0, at_least: 0 }
    }
}

/// The state of the central path.
#[derive(Clone, Debug)]
pub(crate) struct CentralPath<T: Real, const D: usize, const C: usize, const R: usize> {
    pub(super) pairs: Pairs<T, D, C, R>,
    /// Weight `beta` of friction.
    pub(super) beta: T,
    /// The last finite `tau`.
    pub(super) tau: T,
    /// Number of steps on this path.
    pub(super) steps: usize,
    /// Was the last step too short?
    pub(super) is_stuck: bool,
    /// Merit at the last trial of Newton's method on this path.
    pub(super) tried: Option<T>,
    /// Number of paths that have jammed since the search began on the central path.
    pub(super) jams: usize,
}

impl<T: Real, const D: usize, const C: usize, const R: usize> CentralPath<T, D, C, R> {
    /// The state before the first path.
    pub(crate) const fn none() -> Self {
        Self {
            pairs: Pairs::none(),
            beta: T::ZERO,
            tau: T::ZERO,
            steps: 0,
            is_stuck: false,
            tried: None,
            jams: 0,
        }
    }
}
