//! The stored factor: what depends on `M` and `H` alone, computed once and reused by every solve; for ADMM with the
//! resolvent.
//!
//! The note factorises `A = M + rho HᵀH` and solves with it at each iteration (step 2). With the
//! Delassus operator `W = H M⁻¹ Hᵀ` the same step is one symmetric product in contact space:
//! `H A⁻¹ = B H M⁻¹` with the resolvent `B = (I + rho W)⁻¹ = I - rho H A⁻¹ Hᵀ`, so that
//!
//! `H vᵏ⁺¹ + b = y + B (q + S - y)`, `y = û - ζ̂`, `q = H v_free + w`, `S_i = mu_i s_i e_N`.
//!
//! That needs `(D·C)²` multiplications against `N² + 2·N·D·C` through the factor of `A`, and a new
//! `rho` never touches the `N × N` factor again.

use crate::factor::delassus::reaches;
use crate::factor::penalty::moved_dofs;
use crate::laws::{Coulomb, Laws, Room};
use crate::linalg::blocks::ContactMatrix;
use crate::linalg::hints::opaque;
use crate::linalg::sparsity::Support;
use crate::{Error, Real, Scene};
use nalgebra::SVector;

mod admm_factor;
mod delassus;
mod extended;
mod parts;
mod penalty;
mod products;
pub(crate) mod resolvent;
mod scales;

pub use admm_factor::{AdmmFactor, AdmmFactorParts};
pub use parts::FactorParts;

/// The fingerprint of a factor from [`Factor::from_parts`], which is not checked.
const BAKED: u64 = u64::MAX;

/// Cholesky factor of the mass matrix and Delassus operator `W = H M⁻¹ Hᵀ` of a scene.
///
/// A solve reads it and does not change it. It may serve any number of solves and stand in a `static`. Friction
/// coefficients, offsets and the free impulse are no part of it. [`crate::Kernel`] keeps one up to date by itself.
///
/// ```
/// use nalgebra::{Matrix2, matrix, vector};
/// use stiction::{Contact, Error, Factor, Scene, Settings, Solver};
///
/// let mut scene = Scene::<f64, 2, 2, 1>::new();
/// scene.set_mass(&(Matrix2::identity() * 2.0))?;
/// scene.push(&Contact { jacobian: matrix![0.0, 1.0; 1.0, 0.0], offset: vector![0.0, 0.0], mu: 0.5, key: 0 })?;
/// let mut factor = Factor::new(&scene)?;
/// scene.set_friction(0, 0.8)?;
/// assert!(factor.is_current(&scene));
///
/// scene.set_mass(&(Matrix2::identity() * 3.0))?;
/// let (mut solver, push) = (Solver::new(), vector![0.1, -0.3]);
/// let refused = solver.solve(&scene, &factor, &push, &Settings::default());
/// assert_eq!(refused.err(), Some(Error::StaleFactor));
/// factor.prepare(&scene)?;
/// assert!(solver.solve(&scene, &factor, &push, &Settings::default())?.is_solved());
/// # Ok::<(), Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Factor<T: Real, const N: usize, const D: usize, const C: usize, L: Laws = Coulomb> {
    contacts: usize,
    /// Fingerprint of the scene's `M` and `H`; 0 if empty, [`BAKED`] if it comes from [`Self::from_parts`].
    fingerprint: u64,
    /// Number of dofs that contacts move.
    moved: usize,
    /// Bound on the rounding of `W`, relative to it.
    uncertainty: T,
    /// `M = Uᵀ D⁻¹ U`.
    mass: [[T; N]; N],
    /// `X_i`, `Uᵀ D⁻¹ X_i = H_iᵀ`
    whitened: [[[T; D]; N]; C],
    /// Nonzero columns of the `X_iᵀ`.
    supports: [Support; C],
    /// `W = H M⁻¹ Hᵀ`.
    delassus: ContactMatrix<T, D, C>,
    /// `W_ii⁻¹`; zero where that is singular, or nearly so.
    effective_mass: [[[T; D]; D]; C],
    /// By what the rows of `H` are scaled: those of joint rows to unit `W_jj`.
    scales: [L::Room<[T; D]>; C],
}

impl<T: Real, const N: usize, const D: usize, const C: usize, L: Laws> Factor<T, N, D, C, L> {
    /// An empty factor, to be filled by [`Self::prepare`]: all zeros, so that a `static` of it takes
    /// no flash.
    #[must_use]
    pub const fn empty() -> Self {
        Self {
            contacts: 0,
            fingerprint: 0,
            moved: 0,
            uncertainty: T::ZERO,
            mass: [[T::ZERO; N]; N],
            whitened: [[[T::ZERO; D]; N]; C],
            supports: [Support::none(); C],
            delassus: [[[[T::ZERO; D]; C]; D]; C],
            effective_mass: [[[T::ZERO; D]; D]; C],
            scales: [const { L::Room::EMPTY }; C],
        }
    }

    /// The factor of a scene, see [`Self::prepare`].
    ///
    /// # Errors
    /// As [`Self::prepare`].
    pub fn new(scene: &Scene<T, N, D, C, L>) -> Result<Self, Error> {
        let mut factor = Self::empty();
        factor.prepare(scene)?;
        Ok(factor)
    }

    /// Factorises a scene in place.
    ///
    /// # Errors
    /// [`Error::MassNotPositiveDefinite`]; [`Error::DelassusOutOfRange`] and [`Error::RowOutOfRange`]. The factor is then empty.
    pub fn prepare(&mut self, scene: &Scene<T, N, D, C, L>) -> Result<(), Error> {
        let result = self.compute_delassus(scene);
        let result = result.and_then(|()| self.check(scene));
        if result.is_err() {
            self.clear();
        }
        result
    }

    /// Is `W` in the range of the number type? Counts the dofs that contacts move.
    fn check(&mut self, scene: &Scene<T, N, D, C, L>) -> Result<(), Error> {
        self.moved = moved_dofs(scene);
        for (contact, source) in opaque(scene.contacts()).iter().enumerate() {
            if let Some(rows) = scene.slot(contact).and_then(|slot| slot.rows) {
                let scales = self.scales(contact).into_iter().flatten();
                let mut keys = scales
                    .zip(rows.keys)
                    .filter(|(scale, _)| !scale.is_finite());
                if let Some((_, key)) = keys.next() {
                    return Err(Error::RowOutOfRange { key });
                }
            }
            // A normal that only seems to move nothing would be called immovable.
            let normal = self.inverse_mass(contact, 0);
            let vanishes = normal < T::least_normal() && reaches(source).first() == Some(&true);
            if vanishes || !self.trace(contact).is_finite() {
                return Err(Error::DelassusOutOfRange { contact });
            }
        }
        Ok(())
    }

    /// Empties it.
    fn clear(&mut self) {
        (self.contacts, self.fingerprint) = (0, 0);
    }

    /// Number of dofs that contacts move.
    pub(crate) const fn moved(&self) -> usize {
        self.moved
    }

    /// True if it belongs to the scene's current `M` and `H`. Compared by a 64-bit hash. A factor from
    /// [`Self::from_parts`] only needs the same number of contacts.
    #[must_use]
    pub fn is_current(&self, scene: &Scene<T, N, D, C, L>) -> bool {
        self.contacts == scene.contacts().len()
            && (self.fingerprint == BAKED || self.fingerprint == scene.fingerprint())
    }

    /// Number of contacts of the scene this was computed for.
    #[must_use]
    pub const fn contacts(&self) -> usize {
        self.contacts
    }

    /// Entry `k` of the diagonal of `W_ii`.
    fn inverse_mass(&self, contact: usize, k: usize) -> T {
        let row = self.delassus.get(contact).and_then(|rows| rows.get(k));
        let block = row.and_then(|row| row.get(contact));
        block
            .and_then(|block| block.get(k))
            .copied()
            .unwrap_or(T::ZERO)
    }

    /// `trace(W_ii)`
    fn trace(&self, contact: usize) -> T {
        (0..D).fold(T::ZERO, |trace, k| trace + self.inverse_mass(contact, k))
    }

    /// Mean effective mass `alpha_i = D / trace(W_ii)` (kg) of a contact, the step of the natural map; 0 for a contact
    /// that nothing moves.
    pub(crate) fn natural_map_step(&self, contact: usize) -> T {
        let trace = self.trace(contact);
        if trace > T::ZERO {
            T::count(D) / trace
        } else {
            T::ZERO
        }
    }

    /// `W`
    pub(crate) const fn delassus(&self) -> &ContactMatrix<T, D, C> {
        &self.delassus
    }

    /// `W_ii⁻¹`
    pub(crate) const fn effective_mass(&self) -> &[[[T; D]; D]; C] {
        &self.effective_mass
    }

    /// By what the rows of a slot are scaled, if they are.
    #[inline]
    pub(crate) fn scales(&self, slot: usize) -> Option<&[T; D]> {
        self.scales.get(slot).and_then(Room::get)
    }

    /// A velocity in the scaled rows of a slot; the physical one of an impulse there.
    #[inline]
    pub(crate) fn scaled(&self, slot: usize, velocity: SVector<T, D>) -> SVector<T, D> {
        match self.scales(slot) {
            Some(&scales) => velocity.component_mul(&scales.into()),
            None => velocity,
        }
    }

    /// An impulse in the scaled rows of a slot; the physical one of a velocity there. Nothing is left of a row that is
    /// scaled by 0.
    #[inline]
    pub(crate) fn unscaled(&self, slot: usize, impulse: SVector<T, D>) -> SVector<T, D> {
        let Some(scales) = self.scales(slot) else {
            return impulse;
        };
        impulse.zip_map(&(*scales).into(), |r, scale| {
            if scale > T::ZERO { r / scale } else { T::ZERO }
        })
    }

    /// Bound on the rounding of `W`, relative to it.
    pub(crate) const fn uncertainty(&self) -> T {
        self.uncertainty
    }
}
