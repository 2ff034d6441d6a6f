//! Levenberg-Marquardt damping of Newton's steps.

use crate::Real;
use crate::solver::tuning;

/// How much Newton's steps are damped.
#[derive(Clone, Debug)]
pub(crate) struct Damping<T> {
    level: T,
}

impl<T: Real> Damping<T> {
    /// No solve yet.
    pub(crate) const fn none() -> Self {
        Self { level: T::ZERO }
    }

    /// Little.
    pub(crate) fn new() -> Self {
        Self {
            level: tuning::least_level(),
        }
    }

    /// For a start from the last solution. Of a singular scene other directions are without effect
    /// now than were then, and more damping keeps the impulses from drifting along them.
    pub(crate) fn warm() -> Self {
        Self { level: T::ONE }
    }

    /// `λ`: vanishes with the error, down to what rounding makes of `W`, so that the last steps are Newton's.
    pub(crate) fn at(&self, natural_map: T) -> T {
        let lambda = self.level * tuning::damping::<T>() * natural_map.min(T::ONE)
            + T::literal(1e-12).max(T::EPSILON * T::literal(64.0));
        lambda.min(tuning::largest_damping())
    }

    /// A full step was accepted.
    pub(crate) fn relax(&mut self) {
        self.level = (self.level * T::literal(0.1)).max(tuning::least_level());
    }

    /// A step was rejected.
    pub(crate) fn reject(&mut self) {
        self.level = (self.level * T::literal(10.0))
            .max(T::ONE)
            .min(tuning::largest_level());
    }
}
