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

use crate::error::Error;
use crate::factor::delassus::{normal_moves, rounding_share};
use crate::linalg::cholesky::envelope;
use crate::linalg::sparsity::Support;
use crate::linalg::stacked::{Counts, Stacked};
use crate::real::Real;
use crate::scene::Scene;
use nalgebra::SVector;

mod admm_factor;
mod delassus;
mod penalty;
mod products;
pub(crate) mod resolvent;

pub use admm_factor::AdmmFactor;
pub(crate) use delassus::Delassus;

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
pub struct Factor<T: Real, const N: usize, const D: usize, const C: usize, const R: usize = 0> {
    /// Contacts and joint rows.
    counts: Counts,
    /// Fingerprint of the scene's `M` and `H`; 0 if empty.
    fingerprint: u64,
    /// Number of dofs that contacts and joint rows move.
    moved: usize,
    /// Bound on the rounding of `W`, relative to it.
    uncertainty: T,
    /// `M = Uᵀ D⁻¹ U`.
    mass: [[T; N]; N],
    /// `X_i`, `Uᵀ D⁻¹ X_i = H_iᵀ`
    whitened: [[[T; D]; N]; C],
    /// The same of joint rows.
    whitened_rows: [[[T; 1]; N]; R],
    /// Nonzero columns of the `X_iᵀ`.
    supports: [Support; C],
    /// `W = H M⁻¹ Hᵀ`.
    delassus: Delassus<T, D, C, R>,
    /// `W_ii⁻¹`; zero where that is singular, or nearly so.
    effective_mass: [[[T; D]; D]; C],
}

/// How far a factor reaches, before it takes in more joint rows.
pub(crate) struct Checkpoint {
    counts: Counts,
    fingerprint: u64,
    moved: usize,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>
    Factor<T, N, D, C, R>
{
    /// An empty factor, to be filled by [`Self::prepare`]: all zeros, so that a `static` of it takes
    /// no flash.
    #[must_use]
    pub const fn empty() -> Self {
        Self {
            counts: Counts {
                contacts: 0,
                rows: 0,
            },
            fingerprint: 0,
            moved: 0,
            uncertainty: T::ZERO,
            mass: [[T::ZERO; N]; N],
            whitened: [[[T::ZERO; D]; N]; C],
            whitened_rows: [[[T::ZERO; 1]; N]; R],
            supports: [Support::none(); C],
            delassus: Delassus::zero(),
            effective_mass: [[[T::ZERO; D]; D]; C],
        }
    }

    /// The factor of a scene, see [`Self::prepare`].
    ///
    /// # Errors
    /// As [`Self::prepare`].
    pub fn new<const S: usize>(scene: &Scene<T, N, D, C, R, S>) -> Result<Self, Error> {
        let mut factor = Self::empty();
        factor.prepare(scene)?;
        Ok(factor)
    }

    /// Factorises a scene in place.
    ///
    /// # Errors
    /// [`Error::SceneIncomplete`]; [`Error::MassNotPositiveDefinite`]; [`Error::DelassusOutOfRange`] and [`Error::RowOutOfRange`]. The factor is then empty.
    pub fn prepare<const S: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, R, S>,
    ) -> Result<(), Error> {
        let result = scene.check_complete();
        let result = result.and_then(|()| self.compute_delassus(scene));
        let result = result.and_then(|()| self.check(scene));
        if result.is_err() {
            self.clear();
        }
        result
    }

    /// Is `W` in the range of the number type? Counts the dofs that contacts and joint rows move.
    fn check<const S: usize>(&mut self, scene: &Scene<T, N, D, C, R, S>) -> Result<(), Error> {
        self.moved = scene.moved_dofs();
        for (contact, source) in scene.contacts().iter().enumerate() {
            // A normal that only seems to move nothing would be called immovable.
            let normal = self.delassus.inverse_mass(contact, 0);
            let trace = self.delassus.trace(contact);
            let vanishes = normal < T::least_normal()
                && normal >= trace * rounding_share()
                && normal_moves(source);
            if vanishes || !trace.is_finite() {
                return Err(Error::DelassusOutOfRange { contact });
            }
        }
        for (j, row) in scene.rows().iter().enumerate() {
            let own = self.delassus.row_inverse_mass(j);
            let moves = row.compliance > T::ZERO || row.row.iter().any(|&entry| entry != T::ZERO);
            if !own.is_finite() || own < T::least_normal() && moves {
                return Err(Error::RowOutOfRange { key: row.key });
            }
        }
        Ok(())
    }

    /// Takes in the joint rows of a scene from `first` on. `M`, the contacts and the rows before have to be those that it has.
    pub(crate) fn extend<const S: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, R, S>,
        first: usize,
    ) -> Result<(), Error> {
        let envelope = envelope(&self.mass);
        self.counts = scene.counts();
        self.append_rows(scene, first, &envelope);
        self.check(scene)
    }

    /// How far it reaches.
    pub(crate) const fn checkpoint(&self) -> Checkpoint {
        Checkpoint {
            counts: self.counts,
            fingerprint: self.fingerprint,
            moved: self.moved,
        }
    }

    /// Lets go of the rows that it has taken in since.
    pub(crate) const fn go_back(&mut self, to: &Checkpoint) {
        (self.counts, self.fingerprint, self.moved) = (to.counts, to.fingerprint, to.moved);
    }

    /// `v_free = M⁻¹ p`
    pub(crate) fn free_velocity(&self, free_impulse: &SVector<T, N>) -> SVector<T, N> {
        let [mut whitened] = free_impulse.data.0;
        self.whiten(&mut whitened);
        let mut velocity = *free_impulse;
        let [v] = &mut velocity.data.0;
        self.velocity(&whitened, &Stacked::zero(), v);
        velocity
    }

    /// Empties it.
    pub(crate) fn clear(&mut self) {
        self.counts = Counts {
            contacts: 0,
            rows: 0,
        };
        self.fingerprint = 0;
    }

    /// Number of dofs that contacts move.
    pub(crate) const fn moved(&self) -> usize {
        self.moved
    }

    /// True if it belongs to the scene's current `M` and `H`. Compared by a 64-bit hash.
    #[must_use]
    pub fn is_current<const S: usize>(&self, scene: &Scene<T, N, D, C, R, S>) -> bool {
        self.counts == scene.counts() && self.fingerprint == scene.fingerprint()
    }

    /// Number of contacts of the scene this was computed for.
    pub(crate) const fn contacts(&self) -> usize {
        self.counts.contacts
    }

    /// Mean effective mass `alpha_i = D / trace(W_ii)` (kg) of a contact, the step of the natural map; 0 for a contact
    /// that nothing moves.
    pub(crate) fn natural_map_step(&self, contact: usize) -> T {
        let trace = self.delassus.trace(contact);
        if trace > T::ZERO {
            T::count(D) / trace
        } else {
            T::ZERO
        }
    }

    /// Effective mass `alpha_j = 1 / W_jj` of a joint row, its step of the natural map; 0 if nothing moves it.
    pub(crate) fn row_step(&self, row: usize) -> T {
        let own = self.delassus.row_inverse_mass(row);
        if own > T::ZERO { T::ONE / own } else { T::ZERO }
    }

    /// `W`
    pub(crate) const fn delassus(&self) -> &Delassus<T, D, C, R> {
        &self.delassus
    }

    /// `W_ii⁻¹`
    pub(crate) const fn effective_mass(&self) -> &[[[T; D]; D]; C] {
        &self.effective_mass
    }

    /// Bound on the rounding of `W`, relative to it.
    pub(crate) const fn uncertainty(&self) -> T {
        self.uncertainty
    }
}
