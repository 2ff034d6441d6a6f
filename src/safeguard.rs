//! What keeps Newton's method from doing harm: regularisation, patience, balanced penalties.

use crate::Real;
use crate::admm::Change;
use crate::newton::Point;
use crate::residual::quotient;

/// How much Newton's steps are regularised, and when they are worth trying.
#[derive(Clone, Debug)]
pub(crate) struct Caution<T> {
    level: T,
    /// The energy at which the last step was rejected, how often that has happened, and how often
    /// it was waited since.
    rejected: Option<T>,
    rejections: usize,
    waited: usize,
}

impl<T: Real> Caution<T> {
    /// Of no solve yet.
    pub(crate) const fn none() -> Self {
        Self {
            level: T::ZERO,
            rejected: None,
            rejections: 0,
            waited: 0,
        }
    }

    pub(crate) fn new() -> Self {
        Self {
            level: T::literal(1e-3),
            ..Self::none()
        }
    }

    /// For a start from the last solution. Of a singular scene other directions are without effect
    /// now than were then, and a larger `λ` keeps the impulses from drifting along them.
    pub(crate) fn warm() -> Self {
        Self {
            level: T::ONE,
            ..Self::new()
        }
    }

    /// Is a step worth trying? After a rejection first-order iterations must have brought the
    /// energy down, or have been tried twice.
    pub(crate) fn allows<const D: usize, const C: usize>(
        &mut self,
        point: &Point<T, D, C>,
    ) -> bool {
        let waiting = self
            .rejected
            .is_some_and(|energy| point.energy > energy * T::literal(0.09));
        if waiting && self.waited < 2 {
            self.waited += 1;
            return false;
        }
        self.waited = 0;
        true
    }

    /// Has one step been rejected, and only one? The time to doubt that there is a solution.
    pub(crate) fn is_first_rejection(&self) -> bool {
        self.rejections == 1
    }

    /// `λ`: vanishes with the error, down to what rounding makes of `W`, so that the last steps are
    /// Newton's (but from the last solution on, where the error at the start is given).
    pub(crate) fn regularisation(&self, natural_map: T) -> T {
        let lambda = self.level * T::literal(1e-3) * natural_map.min(T::ONE)
            + T::literal(1e-12).max(T::EPSILON * T::literal(64.0));
        lambda.min(T::literal(0.3))
    }

    /// Forgets the rejections, for a new beginning.
    pub(crate) fn forget(&mut self) {
        self.level = T::ONE;
        self.rejected = None;
        self.waited = 0;
    }

    /// A full step was accepted.
    pub(crate) fn relax(&mut self) {
        self.level = (self.level * T::literal(0.1)).max(T::literal(1e-3));
    }

    /// A step was rejected at this energy.
    pub(crate) fn reject(&mut self, energy: T) {
        self.level = (self.level * T::literal(10.0))
            .max(T::ONE)
            .min(T::literal(1e6));
        self.rejected = Some(energy);
        self.rejections += 1;
    }
}

/// The penalties `rho_i = scale alpha_i` of Newton's method, and of ADMM once it has failed.
#[derive(Clone, Debug)]
pub(crate) struct Balance<T> {
    pub(crate) scale: T,
    /// `rho |ζᵏ⁺¹ - ζ̂ᵏ|²` and `rho |ũᵏ⁺¹ - ûᵏ|²` of the last iteration.
    primal: T,
    dual: T,
    restarts: usize,
    restarted: bool,
    /// The work at which the next restart is due.
    due: usize,
}

impl<T: Real> Balance<T> {
    /// Of no solve yet.
    pub(crate) const fn none() -> Self {
        Self {
            scale: T::ZERO,
            primal: T::ZERO,
            dual: T::ZERO,
            restarts: 0,
            restarted: false,
            due: 0,
        }
    }

    pub(crate) fn new() -> Self {
        Self {
            scale: T::ONE,
            primal: T::ONE,
            dual: T::ONE,
            due: 300,
            ..Self::none()
        }
    }

    pub(crate) fn has_restarted(&self) -> bool {
        self.restarted
    }

    pub(crate) fn has_ever_restarted(&self) -> bool {
        self.restarts > 0
    }

    /// Does this restart look for a solution elsewhere? Every fourth does, and the next goes back.
    pub(crate) fn turns_aside(&self) -> bool {
        self.restarts % 4 == 3
    }

    /// Remembers how far the last iteration moved.
    pub(crate) fn observe(&mut self, change: &Change<T>) {
        self.primal = change.primal;
        self.dual = change.dual;
    }

    /// Raises the penalties where the primal residual is the larger, by the square root of the
    /// ratio, at most tenfold. A search that has cost 300 iterations' worth of work, and after that
    /// each 1000, tries another size altogether.
    pub(crate) fn update(&mut self, cost: usize) {
        let scale = |value| T::literal(value);
        let scales = [
            scale(10.0),
            scale(0.1),
            scale(100.0),
            scale(0.01),
            scale(3.0),
            scale(0.3),
            scale(1000.0),
            scale(1e-3),
        ];
        if cost >= self.due {
            self.due = cost + 1000;
            let scale = scales.get(self.restarts % scales.len()).copied();
            self.scale = scale.unwrap_or(T::ONE);
            self.restarts += 1;
            self.restarted = true;
            return;
        }
        self.restarted = false;
        let (ten, tenth) = (T::literal(10.0), T::literal(0.1));
        let factor = quotient(self.primal, self.dual).square_root().square_root();
        let factor = factor.min(ten).max(tenth);
        let two = T::ONE + T::ONE;
        if factor > two || factor * two < T::ONE {
            self.scale *= factor;
        }
    }
}
