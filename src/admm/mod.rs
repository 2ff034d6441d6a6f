//! The alternating direction method of multipliers (ADMM) of [the note](crate::guide::note): one iteration, and the solver.

mod iterate;
mod solver;

pub use solver::AdmmSolver;

/// How ADMM extrapolates from one iterate to the next, `û = ũ + c (ũ - ũ_previous)` and `ζ` likewise, see
/// [`crate::guide::note`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Acceleration {
    /// Algorithm 2: Nesterov's sequence, which starts again when the residual `e_k` has not decreased (default).
    Restart = 0, // so that a new solver is all zeros, and takes no flash
    /// Algorithm 1: Nesterov's sequence, `tau` of step 5.
    Nesterov = 1,
    /// Plain ADMM, `c = 0`.
    Plain = 2,
}

/// When ADMM updates the tangential speed `s` in `b(s) = w + mu s e_N`. [`crate::guide::note`] measures both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum SlipUpdate {
    /// At every iteration, `s_i = |ũ_Ti|` (default).
    EveryIteration = 0, // as above
    /// In an outer loop, each time the convex problem with `s` frozen is solved.
    OuterLoop = 1,
}
