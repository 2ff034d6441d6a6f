//! Semismooth Newton on the fixed-point map of ADMM, in contact space: the point.
//!
//! With one vector `z` a contact, `P = Π_{K*}(z)` and `r = rho_i (P - z)`, the impulse lies in `K`
//! and is complementary to `P` whatever `z` is; a solution is a root of
//!
//! `E(z) = W r + q + S(P) - P`, `S_i = mu_i |P_Ti| e_N`.
//!
//! `E` needs no resolvent: the penalty is only a scale here, so each contact has its own, its
//! effective mass `rho_i = alpha_i`; a joint row too, with an interval in place of the cone. A step `d` solves the linearised
//! equation, see [`crate::sets::jacobian`].

use crate::linalg::stacked::Stacked;
use crate::real::Real;

/// A point `z` and what follows from it.
#[derive(Clone, Debug)]
pub(crate) struct Point<T, const D: usize, const C: usize, const R: usize> {
    pub(crate) z: Stacked<T, D, C, R>,
    /// `P = Π_{K*}(z)`
    pub(crate) p: Stacked<T, D, C, R>,
    /// `r`
    pub(crate) r: Stacked<T, D, C, R>,
    /// `u = W r + q`
    pub(crate) u: Stacked<T, D, C, R>,
    /// `E(z)`
    pub(crate) residual: Stacked<T, D, C, R>,
    /// Merit function `Σ alpha_i |E_i|²`, what a step has to reduce.
    pub(crate) merit: T,
    /// First part of the error.
    pub(crate) natural_map: T,
}

impl<T: Real, const D: usize, const C: usize, const R: usize> Point<T, D, C, R> {
    /// No point yet.
    pub(crate) const fn none() -> Self {
        Self {
            z: Stacked::zero(),
            p: Stacked::zero(),
            r: Stacked::zero(),
            u: Stacked::zero(),
            residual: Stacked::zero(),
            merit: T::ZERO,
            natural_map: T::ZERO,
        }
    }
}
