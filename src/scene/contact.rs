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
    /// A warm start follows it: a contact starts from the one that had its key in the last solve,
    /// wherever in the list that stood, and from rest if there was none. Of several contacts with
    /// one key the first follows the first, the second the second, so that all keys may be 0 where
    /// contacts neither come nor go nor change their order.
    pub key: u32,
}

impl<T: Real, const N: usize, const D: usize> Contact<T, N, D> {
    /// What stands in a place that is not used.
    pub(super) const fn none() -> Self {
        Self {
            jacobian: SMatrix::from_array_storage(ArrayStorage([[T::ZERO; D]; N])),
            offset: SVector::from_array_storage(ArrayStorage([[T::ZERO; D]; 1])),
            mu: T::ZERO,
            key: 0,
        }
    }
}
