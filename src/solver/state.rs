//! The state of a solve between two pieces of work.

use crate::linalg::stacked::StackedMatrix;
use crate::real::Real;
use crate::sets::jacobian::Jacobian;
use crate::sets::pairs::Pairs;
use crate::solver::monitor::Monitor;
use crate::solver::phases::Phases;
use crate::solver::point::NewtonPoint;

/// The state of a solve, for all phases.
#[derive(Clone, Debug)]
pub(crate) struct State<T: Real, const D: usize, const C: usize, const R: usize> {
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

    /// Moves the point to the best impulses so far.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn go_to_best<const N: usize, const S: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
    ) {
        if let Some(best) = monitor.best() {
            self.point.r = best;
            self.point.evaluate_impulses(monitor.problem);
        }
    }

    /// Shows the point to the monitor, as a solution or as an answer to the rest question.
    pub(super) fn consider<const N: usize, const S: usize>(
        &self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) {
        let point = &self.point;
        if monitor.problem.is_relaxed() {
            monitor.consider_rest(point);
        } else {
            monitor.consider(&point.r, &point.u, point.estimate);
        }
    }

    /// Makes the check of the error that is due.
    pub(super) fn check<P: Phases, const N: usize, const S: usize>(
        &self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) {
        if P::CENTRAL_PATH && monitor.problem.is_relaxed() {
            monitor.check_rest(&self.point);
        } else {
            monitor.check::<P>(&self.point.r, &self.point.u);
        }
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
    /// Number of jams of all paths of this solve.
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
