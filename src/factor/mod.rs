//! [`Factor`]: everything that depends on `M` and `H` alone, computed once for any number of solves; [`AdmmFactor`] adds the resolvent.
//!
//! The *Delassus operator* `W = H M⁻¹ Hᵀ` maps contact impulses to the contact velocities that they cause ([`crate::guide::error`]). A
//! vector that was multiplied by the inverse Cholesky factor of `M` is called *whitened* ([`crate::guide::method`]).
//!
//! The note factorises `A = M + rho HᵀH` and solves with it in each iteration (step 2). With `W` the same step is one symmetric
//! product in contact space: `H A⁻¹ = B H M⁻¹` with the *resolvent* `B = (I + rho W)⁻¹ = I - rho H A⁻¹ Hᵀ`, so that
//!
//! `H vᵏ⁺¹ + w + S = y + B (q + S - y)`, `y = û - ζ̂`, `q = H v_free + w`, `S_i = mu_i s_i e_N`,
//!
//! with the extrapolated iterates `û` and `ζ̂` of the note. (Elsewhere `û` is the augmented velocity.)
//!
//! That takes `(D·C)²` multiplications, against `N² + 2·N·D·C` through the factor of `A`. A new `rho` does not change the factor of `M`.

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
/// A solve reads a factor and does not change it. So a factor serves any number of solves, and may be a `static`. It does not depend on
/// friction coefficients, offsets and the free impulse. A [`crate::Kernel`] keeps its factor up to date.
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
    /// Numbers of contacts and joint rows.
    counts: Counts,
    /// Fingerprint of the scene's `M` and `H`; 0 if empty.
    fingerprint: u64,
    /// Velocities that the scene does not use: rows and columns that stay zero.
    unused: usize,
    /// Number of dofs that contacts and joint rows move.
    moved: usize,
    /// Estimate of the relative rounding of `W`.
    uncertainty: T,
    /// Are there rows of contacts that were set to zero, because their inverse mass was mere rounding?
    has_dropped_rows: bool,
    /// Cholesky factor `L` of `M = Lᵀ D⁻¹ L`, with the reciprocals of the pivots `D` on its diagonal.
    mass: [[T; N]; N],
    /// Whitened contacts `X_i`: `Lᵀ D⁻¹ X_i = H_iᵀ`.
    whitened: [[[T; D]; N]; C],
    /// Whitened joint rows.
    whitened_rows: [[[T; 1]; N]; R],
    /// Nonzero columns of each `X_iᵀ`.
    supports: [Support; C],
    /// `W = H M⁻¹ Hᵀ`.
    delassus: Delassus<T, D, C, R>,
    /// Effective mass matrices `W_ii⁻¹`; zero if `W_ii` is singular, or nearly so.
    effective_mass: [[[T; D]; D]; C],
}

/// Relative rounding of `W` up to which bounds may be derived from it.
const CERTAIN: f64 = 0.1;

/// The extent of a factor before more joint rows are appended.
pub(crate) struct Checkpoint {
    counts: Counts,
    fingerprint: u64,
    moved: usize,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize> Factor<T, N, D, C, R> {
    /// An empty factor for [`Self::prepare`]. It is all zeros, so a `static` takes no flash.
    #[must_use]
    pub const fn empty() -> Self {
        Self {
            counts: Counts { contacts: 0, rows: 0 },
            fingerprint: 0,
            unused: 0,
            moved: 0,
            uncertainty: T::ZERO,
            has_dropped_rows: false,
            mass: [[T::ZERO; N]; N],
            whitened: [[[T::ZERO; D]; N]; C],
            whitened_rows: [[[T::ZERO; 1]; N]; R],
            supports: [Support::none(); C],
            delassus: Delassus::zero(),
            effective_mass: [[[T::ZERO; D]; D]; C],
        }
    }

    /// The factor of a scene.
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
    /// [`Error::SceneIncomplete`]; [`Error::MassNotPositiveDefinite`]; [`Error::DelassusOutOfRange`] and [`Error::RowOutOfRange`]. The factor
    /// is then empty.
    pub fn prepare<const S: usize>(&mut self, scene: &Scene<T, N, D, C, R, S>) -> Result<(), Error> {
        let result = scene.check_complete();
        let result = result.and_then(|()| self.compute_delassus(scene));
        let result = result.and_then(|()| self.check(scene));
        if result.is_err() {
            self.clear();
        }
        result
    }

    /// Counts the dofs that contacts and joint rows move, and refuses a `W` outside the range of the number type.
    fn check<const S: usize>(&mut self, scene: &Scene<T, N, D, C, R, S>) -> Result<(), Error> {
        self.moved = scene.moved_dofs();
        for (contact, source) in scene.contacts().iter().enumerate() {
            // An inverse mass that underflows would make the contact immovable.
            let normal = self.delassus.inverse_mass(contact, 0);
            let trace = self.delassus.trace(contact);
            let vanishes =
                normal < T::least_normal() && normal >= trace * rounding_share() && normal_moves(source);
            if vanishes || !trace.is_finite() {
                return Err(Error::DelassusOutOfRange { contact });
            }
        }
        for (j, row) in scene.rows().iter().enumerate() {
            let inverse_mass = self.delassus.row_inverse_mass(j);
            let moves = row.compliance > T::ZERO || row.row.iter().any(|&entry| entry != T::ZERO);
            if !inverse_mass.is_finite() || inverse_mass < T::least_normal() && moves {
                return Err(Error::RowOutOfRange { key: row.key });
            }
        }
        Ok(())
    }

    /// Appends the joint rows of a scene from index `first` on. `M`, the contacts and the rows before have to be those of the factor.
    pub(crate) fn extend<const S: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, R, S>,
        first: usize,
    ) -> Result<(), Error> {
        let envelope = envelope(&self.mass, self.velocities());
        self.counts = scene.counts();
        self.append_rows(scene, first, &envelope);
        self.check(scene)
    }

    /// The present extent, for [`Self::restore`].
    pub(crate) const fn checkpoint(&self) -> Checkpoint {
        Checkpoint { counts: self.counts, fingerprint: self.fingerprint, moved: self.moved }
    }

    /// Removes the joint rows that were appended since a checkpoint.
    pub(crate) const fn restore(&mut self, to: &Checkpoint) {
        (self.counts, self.fingerprint, self.moved) = (to.counts, to.fingerprint, to.moved);
    }

    /// Free velocity `v_free = M⁻¹ p` for a free impulse `p`.
    pub(crate) fn free_velocity(&self, free_impulse: &SVector<T, N>) -> SVector<T, N> {
        let [mut whitened] = free_impulse.data.0;
        self.whiten(&mut whitened);
        let mut velocity = *free_impulse;
        let [v] = &mut velocity.data.0;
        self.velocity(&whitened, &Stacked::zero(), v);
        velocity
    }

    /// Makes the factor empty.
    pub(crate) fn clear(&mut self) {
        self.counts = Counts { contacts: 0, rows: 0 };
        self.fingerprint = 0;
    }

    /// Changes the entries of `W`, as bits that flip.
    #[cfg(test)]
    pub(crate) fn spoil(&mut self) {
        for entry in self.delassus.contacts.as_flattened_mut().as_flattened_mut().as_flattened_mut() {
            *entry += T::ONE;
        }
    }

    /// Number of dofs that contacts and joint rows move.
    pub(crate) const fn moved(&self) -> usize {
        self.moved
    }

    /// True if `M`, Jacobians, compliance, contacts and joint rows of the scene are those of the factor. A 64-bit hash tells.
    #[must_use]
    pub fn is_current<const S: usize>(&self, scene: &Scene<T, N, D, C, R, S>) -> bool {
        self.counts == scene.counts()
            && self.unused == scene.unused()
            && self.fingerprint == scene.fingerprint()
    }

    /// Velocities of the scene this was computed for.
    #[inline]
    pub(crate) const fn velocities(&self) -> usize {
        N.saturating_sub(self.unused)
    }

    /// Makes room for another number of velocities: what the new ones do not use is zero.
    #[cold]
    #[inline(never)]
    pub(super) fn set_unused(&mut self, unused: usize) {
        self.unused = unused;
        self.mass = [[T::ZERO; N]; N];
        self.whitened = [[[T::ZERO; D]; N]; C];
        self.whitened_rows = [[[T::ZERO; 1]; N]; R];
    }

    /// Number of contacts of the scene this was computed for.
    pub(crate) const fn contacts(&self) -> usize {
        self.counts.contacts
    }

    /// Mean effective mass `alpha_i = D / trace(W_ii)` (kg) of a contact; 0 for a contact that nothing moves.
    pub(crate) fn mean_effective_mass(&self, contact: usize) -> T {
        let trace = self.delassus.trace(contact);
        if trace > T::ZERO { T::count(D) / trace } else { T::ZERO }
    }

    /// Harmonic mean of the [mean effective masses](Self::mean_effective_mass) of all contacts that move; 0 if there is none.
    pub(crate) fn common_effective_mass(&self) -> T {
        let (mut sum, mut count) = (T::ZERO, 0);
        for trace in (0..self.counts.contacts).map(|contact| self.delassus.trace(contact)) {
            sum += trace;
            count += if trace > T::ZERO { D } else { 0 };
        }
        if sum > T::ZERO { T::count(count) / sum } else { T::ZERO }
    }

    /// Effective mass `alpha_j = 1 / W_jj` of a joint row; 0 for a row that nothing moves.
    pub(crate) fn row_effective_mass(&self, row: usize) -> T {
        let w = self.delassus.row_inverse_mass(row);
        if w > T::ZERO { T::ONE / w } else { T::ZERO }
    }

    /// `W`
    pub(crate) const fn delassus(&self) -> &Delassus<T, D, C, R> {
        &self.delassus
    }

    /// Effective mass matrices `W_ii⁻¹` of the contacts.
    pub(crate) const fn effective_mass(&self) -> &[[[T; D]; D]; C] {
        &self.effective_mass
    }

    /// Does a velocity that was computed from it balance the momentum but for rounding?
    pub(crate) fn balances(&self) -> bool {
        !self.has_dropped_rows && self.uncertainty < T::literal(CERTAIN)
    }

    /// Is `M` as good as singular: would it be, if one of its diagonal entries were rounded down?
    pub(crate) fn is_uncertain(&self) -> bool {
        self.uncertainty >= T::literal(delassus::GROWTH)
    }

    /// Estimate of the relative rounding of `W`.
    pub(crate) const fn uncertainty(&self) -> T {
        self.uncertainty
    }
}
