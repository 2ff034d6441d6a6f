//! Levenberg-Marquardt damping of Newton's steps, and when one is worth trying.

use crate::Real;
use crate::solver::tuning;

/// How much Newton's steps are damped.
#[derive(Clone, Debug)]
pub(crate) struct Damping<T> {
    level: T,
    /// The merit at which the last step was rejected, how often it was waited since, and rejections in all.
    rejected: Option<T>,
    waited: u8,
    rejections: u8,
}

impl<T: Real> Damping<T> {
    /// No solve yet.
    pub(crate) const fn none() -> Self {
        Self {
            level: T::ZERO,
            rejected: None,
            waited: 0,
            rejections: 0,
        }
    }

    /// Little.
    pub(crate) fn new() -> Self {
        Self {
            level: tuning::least_level(),
            ..Self::none()
        }
    }

    /// For a start from the last solution. Of a singular scene other directions are without effect
    /// now than were then, and more damping keeps the impulses from drifting along them.
    pub(crate) fn warm() -> Self {
        Self {
            level: T::ONE,
            ..Self::none()
        }
    }

    /// Is a step worth trying at this merit? After a rejection first-order iterations must have brought it
    /// down, or have been tried twice.
    pub(crate) fn allows(&mut self, merit: T) -> bool {
        let waiting = self
            .rejected
            .is_some_and(|rejected| merit > rejected * tuning::fall_after_rejection());
        if waiting && usize::from(self.waited) < tuning::patience() {
            self.waited += 1;
            return false;
        }
        self.waited = 0;
        true
    }

    /// `λ`: vanishes with the error, down to what rounding makes of `W`, so that the last steps are Newton's.
    pub(crate) fn at(&self, natural_map: T) -> T {
        let lambda = self.level * tuning::damping::<T>() * natural_map.min(T::ONE)
            + T::literal(1e-12).max(T::EPSILON * T::literal(64.0));
        lambda.min(tuning::largest_damping())
    }

    /// Forgets the rejections, for a penalty of another size.
    pub(crate) fn restart(&mut self) {
        self.level = T::ONE;
        self.rejected = None;
        self.waited = 0;
    }

    /// A full step was accepted.
    pub(crate) fn relax(&mut self) {
        self.level = (self.level * T::literal(0.1)).max(tuning::least_level());
    }

    /// A step was rejected at this merit.
    pub(crate) fn reject(&mut self, merit: T) {
        self.level = (self.level * T::literal(10.0))
            .max(T::ONE)
            .min(tuning::largest_level());
        self.rejected = Some(merit);
        self.rejections = self.rejections.saturating_add(1);
    }

    /// Has one step been rejected, and only one? The time to doubt that there is a solution.
    pub(crate) fn is_first_rejection(&self) -> bool {
        self.rejections == 1
    }
}
