//! One contact, as it is given.

use crate::Real;
use nalgebra::{ArrayStorage, SMatrix, SVector};

/// One contact with friction: `u_i = H_i v + w_i`, `K*_mu ∋ u_i + mu_i |u_Ti| e_N ⟂ r_i ∈ K_mu`.
///
/// `N` generalised velocities, `D` rows, the normal first, pointing out of the obstacle.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact<T, const N: usize, const D: usize> {
    /// Contact Jacobian `H_i`, `D × N`.
    pub jacobian: SMatrix<T, D, N>,
    /// Offset `w_i` (m/s): velocity of a moving surface, gap over time step, restitution.
    pub offset: SVector<T, D>,
    /// Coulomb friction coefficient `mu_i >= 0`.
    pub mu: T,
    /// Which contact it is, in numbers of your own: a foot, a pair of features.
    ///
    /// A contact starts from the impulse that the contact with the same key had in the last solve, at any index, and
    /// from zero if there was none. If several contacts share a key, the first follows the first, the second the second:
    /// all keys may be 0 if contacts never come, go or change their order. [`crate::ContactSolution::key`] gives it back.
    pub key: u32,
}

impl<T: Real, const N: usize, const D: usize> Contact<T, N, D> {
    /// A place that is not used.
    pub(super) const fn none() -> Self {
        Self {
            jacobian: SMatrix::from_array_storage(ArrayStorage([[T::ZERO; D]; N])),
            offset: SVector::from_array_storage(ArrayStorage([[T::ZERO; D]; 1])),
            mu: T::ZERO,
            key: 0,
        }
    }
}
