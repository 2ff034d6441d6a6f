//! Gauss-Seidel's part of the method: the number of sweeps.
//!
//! A Newton step costs as much as five sweeps. Sweeps go on while they are fast, or while five more at the present rate
//! reach the tolerance (`after_five`).

use crate::laws::Laws;
use crate::solver::monitor::Monitor;
use crate::solver::newton::Newton;
use crate::solver::phases::{Phase, Solve};
use crate::solver::{gauss_seidel, relaxed_sweep, tuning};
use crate::{Model, Real};
use core::mem;

/// Sweeps, from one to the next.
#[derive(Clone, Debug)]
pub(crate) struct Sweeps<T, const C: usize> {
    /// Slip multiplier `λ` of each contact.
    pub(super) lambdas: [T; C],
    /// Sweeps so far.
    done: usize,
    /// Did they begin without impulses?
    is_cold: bool,
}

/// How sweeps get on.
pub(crate) enum Pace {
    /// Another one pays, or the solve is over.
    Continue,
    /// Newton's method is to go on from where they have led.
    Enough,
}

impl<T: Real, const C: usize> Sweeps<T, C> {
    /// No sweep yet.
    pub(crate) const fn none() -> Self {
        Self {
            lambdas: [T::ZERO; C],
            done: 0,
            is_cold: false,
        }
    }

    /// The Newton steps that are to follow.
    pub(crate) fn then(&self) -> Newton {
        if self.is_cold {
            Newton::new()
        } else {
            Newton::warm(false)
        }
    }
}

impl<T: Real, const D: usize, const C: usize, L: Laws> Solve<T, D, C, L> {
    /// Sweeps from the impulses and `u` of the point.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn begin_sweeps(&mut self) -> Phase {
        self.sweeps = Sweeps {
            is_cold: self.point.r == [[T::ZERO; D]; C],
            ..Sweeps::none()
        };
        Phase::Sweeps
    }

    /// One sweep, and its work.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn sweep_once<const N: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, L>,
    ) {
        monitor.solution.work.sweeps += 1;
        let (r, u) = (&mut self.point.r, &mut self.point.u);
        let lambdas = &mut self.sweeps.lambdas;
        match monitor.problem.model {
            Model::Coulomb => gauss_seidel::sweep(monitor.problem, r, u, lambdas),
            Model::ConvexRelaxation => relaxed_sweep::sweep(monitor.problem, r, u, lambdas),
        }
    }

    /// One sweep, and how they get on.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn sweep<const N: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, L>,
    ) -> Pace {
        self.sweep_once(monitor);
        let (r, u) = (&self.point.r, &self.point.u);
        let here = monitor.problem.natural_map_at(r, u);
        let last = mem::replace(&mut self.point.natural_map, here);
        self.consider(monitor);
        if monitor.is_over() {
            return Pace::Continue;
        }
        let (sweeps, tolerance) = (&mut self.sweeps, monitor.tolerance());
        sweeps.done += 1;
        // Of zero impulses the natural map says nothing.
        let first = sweeps.is_cold && sweeps.done == 1;
        let rate = if first { T::ZERO } else { here / last };
        let is_fast = rate < tuning::sweep_rate();
        let after_five = here * rate * rate * rate * rate * rate;
        let pays = is_fast && sweeps.done < tuning::fast_sweeps() || after_five <= tolerance;
        if here > tolerance && pays {
            Pace::Continue
        } else {
            Pace::Enough
        }
    }
}

#[cfg(test)]
mod tests;
