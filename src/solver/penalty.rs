//! Penalties of Newton's method, and of ADMM once that has failed.

use crate::Real;
use crate::admm::Change;
use crate::problem::residual::quotient;
use crate::solver::tuning;

/// The penalties `rho_i = scale alpha_i`, and how they are adapted.
#[derive(Clone, Debug)]
pub(crate) struct Penalty<T> {
    pub(crate) scale: T,
    /// `rho |ζᵏ⁺¹ - ζ̂ᵏ|²` and `rho |ũᵏ⁺¹ - ûᵏ|²` of the last iteration.
    primal: T,
    dual: T,
    pub(super) restarts: usize,
    /// The work at which the next restart is due.
    due: usize,
}

impl<T: Real> Penalty<T> {
    /// No solve yet.
    pub(crate) const fn none() -> Self {
        Self {
            scale: T::ZERO,
            primal: T::ZERO,
            dual: T::ZERO,
            restarts: 0,
            due: 0,
        }
    }

    /// The effective masses of the contacts.
    pub(crate) fn new() -> Self {
        Self {
            scale: T::ONE,
            primal: T::ONE,
            dual: T::ONE,
            restarts: 0,
            due: tuning::first_restart(),
        }
    }

    pub(crate) fn has_ever_restarted(&self) -> bool {
        self.restarts > 0
    }

    /// Remembers how far the last iteration moved.
    pub(crate) fn observe(&mut self, change: &Change<T>) {
        self.primal = change.primal;
        self.dual = change.dual;
    }

    /// Raises the penalties where the primal residual is the larger, by the square root of the ratio, at most tenfold. A
    /// solve that has cost [`tuning::first_restart`], and after that each [`tuning::next_restart`], tries another size
    /// altogether, and is told so.
    pub(crate) fn update(&mut self, work: usize) -> bool {
        if work >= self.due {
            self.due = work + tuning::next_restart();
            let scale = tuning::SCALES.get(self.restarts % tuning::SCALES.len());
            self.scale = scale.map_or(T::ONE, |&scale| T::literal(scale));
            self.restarts += 1;
            return true;
        }
        let (ten, tenth) = (T::literal(10.0), T::literal(0.1));
        let factor = quotient(self.primal, self.dual).square_root().square_root();
        let factor = factor.min(ten).max(tenth);
        let two = T::ONE + T::ONE;
        if factor > two || factor * two < T::ONE {
            self.scale *= factor;
        }
        false
    }
}
