//! Settings of a solve (tolerance, budget, contact law), and the work of a solve.

use crate::error::Error;
use crate::real::Real;

/// The contact law that is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Model {
    /// Coulomb's law, with the De Saxcé shift `mu |u_T|` (default).
    Coulomb = 0, // so that a new solver is all zeros
    /// Its convex relaxation, without the shift: a sliding contact separates with normal speed `mu |u_T|`. The error then measures the
    /// relaxed law. [`crate::guide::forces`] shares out forces with it.
    ConvexRelaxation,
}

/// Settings of a solve: tolerance, budget and contact law.
///
/// ```
/// use stiction::{Model, Settings};
///
/// let tick = Settings { budget: 100, ..Settings::new(1e-4) }; // Coulomb's law
/// let relaxed = Settings { model: Model::ConvexRelaxation, ..tick };
/// assert_eq!(Settings::<f32>::default().budget, 1_000);
/// # assert_eq!(relaxed.tolerance, 1e-4);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings<T> {
    /// Error up to which a solution counts as solved (dimensionless, not negative), see [`crate::Solution::error`].
    pub tolerance: T,
    /// Work that one call may do, in units of [`Work::total`]. A call ends between two pieces of work, so it exceeds its budget by at most
    /// 19. With a budget of 0 it computes the error of the best known point; [`crate::Solver::advance`] takes it for 1. Below 1,000 it looks for no proof of a jam.
    /// [`crate::guide::tick`] derives a budget from the time of a tick.
    pub budget: usize,
    /// The contact law that is solved.
    pub model: Model,
    /// Speed along its tangents up to which a contact counts as one that sticks ([`crate::ContactMode`], m/s); 0 by default. It changes names
    /// and no motion. In [`crate::LeastImpulses`] a contact that opens no faster may push.
    pub still: T,
}

impl<T: Real> Settings<T> {
    /// Settings for Coulomb's law with a budget of 1,000, which solves 99.5 % of the random scenes of [`crate::guide::reports::scenes`]; most
    /// of those are made to be hard.
    #[must_use]
    pub const fn new(tolerance: T) -> Self {
        Self { tolerance, budget: 1_000, model: Model::Coulomb, still: T::ZERO }
    }
}

impl<T: Real> Settings<T> {
    /// Are tolerance and speed numbers that are not negative?
    pub(crate) fn check(&self) -> Result<(), Error> {
        let mut limits = [self.tolerance, self.still].into_iter();
        let refused = limits.any(|limit| !limit.is_finite() || limit < T::ZERO);
        if refused { Err(Error::InvalidTolerance) } else { Ok(()) }
    }
}

impl<T: Copy> Settings<T> {
    /// The settings of one of many calls, each of which does some work.
    pub(crate) fn of_a_piece(&self) -> Self {
        Self { budget: self.budget.max(1), ..*self }
    }
}

impl<T: Real> Default for Settings<T> {
    /// Tolerance 1e-4, which `f32` reaches as well.
    fn default() -> Self {
        Self::new(T::literal(1e-4))
    }
}

/// The work of a solve, by kind.
///
/// ```
/// use stiction::Work;
///
/// let work = Work { sweeps: 3, newton_steps: 1, ..Work::default() };
/// assert_eq!(work.total(), 16); // of `Settings::budget`
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Work {
    /// Iterations of ADMM.
    pub iterations: usize,
    /// Gauss-Seidel sweeps.
    pub sweeps: usize,
    /// Chord steps: Newton steps with the Jacobian of an earlier step.
    pub chord_steps: usize,
    /// Newton steps with a new Jacobian, and steps along the central path.
    pub newton_steps: usize,
    /// Searches for a proof that a scene is infeasible, at most one in a solve.
    pub proof_searches: usize,
}

impl Work {
    /// No work.
    pub(crate) const fn none() -> Self {
        Self { iterations: 0, sweeps: 0, chord_steps: 0, newton_steps: 0, proof_searches: 0 }
    }

    /// Sum of the work in iterations of ADMM, at most the largest `usize`. A sweep and a chord step count 2; a Newton step, a step along the
    /// central path and a search for a proof count 10.
    #[must_use]
    #[inline]
    pub const fn total(&self) -> usize {
        let searches = self.proof_searches.saturating_mul(10);
        self.on_solution().saturating_add(searches)
    }

    /// [`Self::total`] without searches for a proof, which bring no solution nearer.
    #[inline]
    pub(crate) const fn on_solution(&self) -> usize {
        let twos = self.sweeps.saturating_add(self.chord_steps);
        let tens = self.newton_steps.saturating_mul(10);
        let rest = twos.saturating_mul(2).saturating_add(tens);
        self.iterations.saturating_add(rest)
    }
}
