//! What a solve carries from one piece of work to the next.

use crate::linalg::stacked::StackedMatrix;
use crate::real::Real;
use crate::sets::jacobian::Jacobian;
use crate::sets::pairs::Pairs;
use crate::solver::monitor::Monitor;
use crate::solver::point::NewtonPoint;

/// Where a solve is, for all phases.
#[derive(Clone, Debug)]
pub(crate) struct State<T: Real, const D: usize, const C: usize, const R: usize> {
    pub(super) point: NewtonPoint<T, D, C, R>,
    pub(super) sweeps: Sweeps<T, C>,
    pub(super) path: CentralPath<T, D, C, R>,
    /// What of the Jacobian is not in the matrix.
    pub(super) jacobian: Jacobian<T, D, C, R>,
    /// The one matrix that a solve needs beside the factor, factorised: by turns that of a Newton step and that of the central
    /// path.
    pub(super) matrix: StackedMatrix<T, D, C, R>,
    /// Is the matrix that of the Jacobian?
    pub(super) holds_jacobian: bool,
}

impl<T: Real, const D: usize, const C: usize, const R: usize> State<T, D, C, R> {
    /// No solve yet.
    pub(crate) const fn none() -> Self {
        Self {
            point: NewtonPoint::none(),
            sweeps: Sweeps::none(),
            path: CentralPath::none(),
            jacobian: Jacobian::none(),
            matrix: StackedMatrix::zero(),
            holds_jacobian: false,
        }
    }

    /// Forgets the Jacobian that is kept.
    pub(super) fn forget(&mut self) {
        self.holds_jacobian = false;
    }

    /// Shows the point to the monitor.
    pub(super) fn consider<const N: usize, const S: usize>(
        &self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) {
        let point = &self.point;
        monitor.consider(&point.r, &point.u, point.estimate);
    }

    /// The same where it may be asked whether all can stay at rest: not in sweeps.
    pub(super) fn consider_answer<const N: usize, const S: usize>(
        &self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) {
        if monitor.record.asks_for_rest() {
            let point = &self.point;
            monitor.consider_rest(&point.r, &point.u, point.estimate);
        } else {
            self.consider(monitor);
        }
    }

    /// Answers what is asked about the point.
    pub(super) fn judge<const N: usize, const S: usize>(
        &self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) {
        if monitor.record.asks_for_rest() {
            let point = &self.point;
            monitor.judge_rest(&point.r, &point.u, point.estimate);
        } else {
            monitor.judge();
        }
    }
}

/// Sweeps, from one to the next.
#[derive(Clone, Debug)]
pub(crate) struct Sweeps<T, const C: usize> {
    /// Slip multiplier `λ` of each contact.
    pub(super) multipliers: [T; C],
    /// Sweeps so far.
    pub(super) done: u16,
    /// Sweeps to make, however slow they are.
    pub(super) at_least: u16,
    /// Did they begin without impulses?
    pub(super) is_cold: bool,
    /// Does the central path follow?
    pub(super) lead_to_path: bool,
}

impl<T: Real, const C: usize> Sweeps<T, C> {
    /// No sweep yet.
    pub(crate) const fn none() -> Self {
        Self {
            multipliers: [T::ZERO; C],
            done: 0,
            at_least: 0,
            is_cold: false,
            lead_to_path: false,
        }
    }
}

/// Where on a central path a solve is.
#[derive(Clone, Debug)]
pub(crate) struct CentralPath<T: Real, const D: usize, const C: usize, const R: usize> {
    pub(super) pairs: Pairs<T, D, C, R>,
    /// Weight of friction.
    pub(super) beta: T,
    /// `tau` of the last point that had one.
    pub(super) tau: T,
    /// Steps on this path.
    pub(super) steps: usize,
    /// Was the last one too short?
    pub(super) is_stuck: bool,
    /// The merit at Newton's last trial on this path.
    pub(super) tried: Option<T>,
    pub(super) jams: usize,
}

impl<T: Real, const D: usize, const C: usize, const R: usize> CentralPath<T, D, C, R> {
    /// No solve yet.
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
