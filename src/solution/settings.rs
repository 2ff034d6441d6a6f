//! How exactly and how long to solve, and the work that a solve has taken.

use crate::real::Real;

/// The contact law that is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Model {
    /// Coulomb's law, with the De Saxcé shift `mu |u_T|` (default).
    Coulomb,
    /// Its convex relaxation, without the shift: a sliding contact separates with normal speed `mu |u_T|`. The error then measures the
    /// relaxed law. [`crate::guide::forces`] shares out forces with it.
    ConvexRelaxation,
}

/// How exactly and how long to solve, and which law.
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
    /// Work that one call may do, in units of [`Work::total`]. A call ends between two pieces of work, and so exceeds its budget by 19 at
    /// most. With 0 it computes the error of the best known point. Below 1,000 it looks for no proof of a jam. [`crate::guide::tick`]
    /// goes from the time of a tick to a budget, and from one tick to the next.
    pub budget: usize,
    /// The contact law that is solved.
    pub model: Model,
}

impl<T> Settings<T> {
    /// Settings for Coulomb's law with a budget of 1,000. That solves 99.5 % of random scenes, most of them made to be hard
    /// ([`crate::guide::reports::scenes`]).
    #[must_use]
    pub const fn new(tolerance: T) -> Self {
        Self {
            tolerance,
            budget: 1_000,
            model: Model::Coulomb,
        }
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
    /// None.
    pub(crate) const fn none() -> Self {
        Self {
            iterations: 0,
            sweeps: 0,
            chord_steps: 0,
            newton_steps: 0,
            proof_searches: 0,
        }
    }

    /// Sum of the work, in iterations of ADMM: a sweep and a chord step count 2; a Newton step, a step along the central path and a search
    /// for a proof count 10. It saturates at the largest `usize`.
    #[must_use]
    #[inline]
    pub const fn total(&self) -> usize {
        let searches = self.proof_searches.saturating_mul(10);
        self.on_solution().saturating_add(searches)
    }

    /// That without searches for a proof, which bring no solution nearer.
    #[inline]
    pub(crate) const fn on_solution(&self) -> usize {
        let twos = self.sweeps.saturating_add(self.chord_steps);
        let tens = self.newton_steps.saturating_mul(10);
        let rest = twos.saturating_mul(2).saturating_add(tens);
        self.iterations.saturating_add(rest)
    }
}
