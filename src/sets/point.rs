//! The point of Newton's method: its unknown `z` and the impulses, velocities and residuals that follow from `z`.
//!
//! Newton's method works on the fixed-point equation of ADMM in contact space ([`crate::guide::method`]). Each contact has a vector
//! `z_i`, with `P_i = Π_{K*}(z_i)` and `r_i = alpha_i (P_i - z_i)`. For any `z_i` the impulse `r_i` lies in `K` and is complementary to
//! `P_i`. A solution is a root of
//!
//! `E(z) = W r + q + S(P) - P`, `S_i = mu_i |P_Ti| e_N`.
//!
//! The scale `alpha_i` is the mean effective mass of the contact. A joint row has an interval in place of the cone. A step `d`
//! solves the linearised equation and leads to `z + d`, see [`crate::sets::jacobian`].

use crate::linalg::stacked::Stacked;
use crate::real::Real;

/// A point `z`, and the impulses, velocities, residual, merit and error at `z`.
#[derive(Clone, Debug)]
pub(crate) struct NewtonPoint<T, const D: usize, const C: usize, const R: usize> {
    pub(crate) z: Stacked<T, D, C, R>,
    /// `P = Π_{K*}(z)`
    pub(crate) p: Stacked<T, D, C, R>,
    /// `r_i = alpha_i (P_i - z_i)`
    pub(crate) r: Stacked<T, D, C, R>,
    /// `u = W r + q`
    pub(crate) u: Stacked<T, D, C, R>,
    /// `E(z)`
    pub(crate) residual: Stacked<T, D, C, R>,
    /// Merit function `Σ alpha_i |E_i|²`, which a step has to reduce.
    pub(crate) merit: T,
    /// Estimate of the error, [`crate::problem::Problem::error_estimate`].
    pub(crate) estimate: T,
}

impl<T: Real, const D: usize, const C: usize, const R: usize> NewtonPoint<T, D, C, R> {
    /// All zeros.
    pub(crate) const fn none() -> Self {
        Self {
            z: Stacked::zero(),
            p: Stacked::zero(),
            r: Stacked::zero(),
            u: Stacked::zero(),
            residual: Stacked::zero(),
            merit: T::ZERO,
            estimate: T::ZERO,
        }
    }
}
