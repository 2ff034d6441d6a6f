//! The stored factor: what depends on `M` and `H` alone, computed once and reused by every solve.
//!
//! The note factorises `A = M + rho HᵀH` and solves with it at each iteration (step 2). With the
//! Delassus operator `W = H M⁻¹ Hᵀ` the same step is one symmetric product in contact space:
//! `H A⁻¹ = B H M⁻¹` with the resolvent `B = (I + rho W)⁻¹ = I - rho H A⁻¹ Hᵀ`, so that
//!
//! `H vᵏ⁺¹ + b = y + B (q + S - y)`, `y = û - ζ̂`, `q = H v_free + w`, `S_i = mu_i s_i e_N`.
//!
//! That needs `(D·C)²` multiplications against `N² + 2·N·D·C` through the factor of `A`, and a new
//! `rho` never touches the `N × N` factor again.

use crate::factor::penalty::{default_penalty, is_usable};
use crate::factor::resolvent::Resolvent;
use crate::linalg::blocks::ContactMatrix;
use crate::linalg::sparsity::Support;
use crate::{Error, Real, Scene};

mod delassus;
mod parts;
mod penalty;
mod products;
pub(crate) mod resolvent;

pub use parts::FactorParts;

/// For how many solves a scene is prepared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solves {
    /// For one by [`crate::Solver`]: without the resolvent `(I + rho W)⁻¹`, which is up to three fifths of the work (the more,
    /// the more contact rows a dof), and which most solves do without. A solve that needs it computes it for itself, to the
    /// same bits: a cold start where contacts have more rows than they move dofs and may slip or hold, or sweeps or a guess
    /// that fail.
    One,
    /// For many, by any solver: with the resolvent.
    Many,
}

/// The fingerprint of a factor that is taken on trust.
const BAKED: u32 = u32::MAX;

/// Cholesky factor of the mass matrix, Delassus operator and resolvent of a scene.
///
/// Read-only once computed; it may outlive any number of solves and stand in a `static`. Friction
/// coefficients, offsets and the free impulse are no part of it.
#[derive(Clone, Debug)]
pub struct Factor<T, const N: usize, const D: usize, const C: usize> {
    contacts: usize,
    /// That of the scene's `M` and `H`; 0 of none, [`BAKED`] of numbers that were computed elsewhere.
    fingerprint: u32,
    /// How many dofs contacts move.
    moved: usize,
    penalty: T,
    /// How far rounding may have moved `W`, relative to it.
    uncertainty: T,
    /// `M = Uᵀ D⁻¹ U`.
    mass: [[T; N]; N],
    /// `X_i`, `Uᵀ D⁻¹ X_i = H_iᵀ`
    whitened: [[[T; D]; N]; C],
    /// Of the `X_iᵀ`.
    supports: [Support; C],
    /// `W = H M⁻¹ Hᵀ`.
    delassus: ContactMatrix<T, D, C>,
    /// `W_ii⁻¹`; zero where that is singular, or nearly so.
    effective_mass: [[[T; D]; D]; C],
    resolvent: Resolvent<T, D, C>,
    /// Is the resolvent that of `W` and the penalty?
    is_complete: bool,
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Factor<T, N, D, C> {
    /// An empty factor, to be filled by [`Self::prepare`]: all zeros, so that a `static` of it takes
    /// no flash.
    #[must_use]
    pub const fn empty() -> Self {
        Self {
            contacts: 0,
            fingerprint: 0,
            moved: 0,
            penalty: T::ZERO,
            uncertainty: T::ZERO,
            mass: [[T::ZERO; N]; N],
            whitened: [[[T::ZERO; D]; N]; C],
            supports: [Support::none(); C],
            delassus: [[[[T::ZERO; D]; C]; D]; C],
            effective_mass: [[[T::ZERO; D]; D]; C],
            resolvent: Resolvent::empty(),
            is_complete: false,
        }
    }

    /// The factor of a scene, see [`Self::prepare`].
    ///
    /// # Errors
    /// As [`Self::prepare`].
    pub fn new(scene: &Scene<T, N, D, C>, solves: Solves) -> Result<Self, Error> {
        let mut factor = Self::empty();
        factor.prepare(scene, solves)?;
        Ok(factor)
    }

    /// Factorises a scene in place, with the default penalty ([`Self::penalty`]), for one solve or for many.
    ///
    /// # Errors
    /// [`Error::MassNotPositiveDefinite`]; [`Error::InvalidPenalty`] if `HᵀH / M` or `W` overflows; for many solves also
    /// if `W` is spread so wide that `I + rho W` is singular in this number type. The factor is then none.
    pub fn prepare(&mut self, scene: &Scene<T, N, D, C>, solves: Solves) -> Result<(), Error> {
        let result = self.compute(scene, solves);
        if result.is_err() {
            (self.contacts, self.fingerprint) = (0, 0);
        }
        result
    }

    fn compute(&mut self, scene: &Scene<T, N, D, C>, solves: Solves) -> Result<(), Error> {
        self.is_complete = false;
        self.compute_delassus(scene)?;
        (self.penalty, self.moved) = default_penalty(scene);
        let finite = (0..self.contacts).all(|contact| self.trace(contact).is_finite());
        if !is_usable(self.penalty) || !finite {
            return Err(Error::InvalidPenalty);
        }
        match solves {
            Solves::One => Ok(()),
            Solves::Many => self.set_penalty(self.penalty),
        }
    }

    /// Replaces the penalty `rho` (kg): one factorisation of `I + rho W`, none of `M`.
    ///
    /// # Errors
    /// [`Error::InvalidPenalty`] if `rho` is not positive and finite, or so large that
    /// `I + rho W` is singular in this number type. The factor keeps its old penalty.
    pub fn set_penalty(&mut self, penalty: T) -> Result<(), Error> {
        let (delassus, contacts) = (&self.delassus, self.contacts);
        let result = self.resolvent.compute(delassus, contacts, &[penalty; C]);
        if result.is_ok() {
            self.penalty = penalty;
            self.is_complete = true;
        } else if self.is_complete {
            let old = [self.penalty; C];
            self.is_complete = self.resolvent.compute(delassus, contacts, &old).is_ok();
        }
        result
    }

    /// The penalty `rho` (kg) of the augmented Lagrangian.
    #[must_use]
    pub const fn penalty(&self) -> T {
        self.penalty
    }

    /// How many dofs contacts move.
    pub(crate) const fn moved(&self) -> usize {
        self.moved
    }

    /// Was it computed for `M` and `H` as they are in a scene? Told by a fingerprint of their bits; numbers that were
    /// computed elsewhere ([`Self::from_parts`]) are taken on trust.
    #[must_use]
    pub fn is_current(&self, scene: &Scene<T, N, D, C>) -> bool {
        self.contacts == scene.contacts().len()
            && (self.fingerprint == BAKED || self.fingerprint == scene.fingerprint())
    }

    /// Number of contacts of the scene this was computed for.
    #[must_use]
    pub const fn contacts(&self) -> usize {
        self.contacts
    }

    /// `trace(W_ii)`
    fn trace(&self, contact: usize) -> T {
        let rows = self.delassus.get(contact).into_iter().flatten();
        rows.enumerate().fold(T::ZERO, |trace, (row, entries)| {
            let block = entries.get(contact).into_iter().flatten();
            trace + block.copied().nth(row).unwrap_or(T::ZERO)
        })
    }

    /// Step `alpha_i = D / trace(W_ii)` (kg) of the natural map; 0 for a contact that nothing moves.
    #[must_use]
    pub fn step(&self, contact: usize) -> T {
        let trace = self.trace(contact);
        if trace > T::ZERO {
            T::count(D) / trace
        } else {
            T::ZERO
        }
    }

    /// `(I + rho W)⁻¹`, unless the factor was made without.
    pub(crate) fn resolvent(&self) -> Option<&Resolvent<T, D, C>> {
        self.is_complete.then_some(&self.resolvent)
    }

    /// `W`
    pub(crate) const fn delassus(&self) -> &ContactMatrix<T, D, C> {
        &self.delassus
    }

    /// `W_ii⁻¹`
    pub(crate) const fn effective_mass(&self) -> &[[[T; D]; D]; C] {
        &self.effective_mass
    }

    /// How far rounding may have moved `W`, relative to it.
    pub(crate) const fn uncertainty(&self) -> T {
        self.uncertainty
    }
}
