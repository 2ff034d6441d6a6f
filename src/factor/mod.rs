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
use crate::linalg::blocks::{ContactMatrix, ContactVector, multiply_transposed};
use crate::linalg::hints::{opaque, opaque_mut, rolled};
use crate::linalg::sparsity::{GROUP, Support, add_columns, add_products};
use crate::linalg::substitution::{solve_lower, solve_upper};
use crate::{Error, Real, Scene};

mod delassus;
mod parts;
mod penalty;
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

    /// `y = W x`
    #[inline]
    pub(crate) fn delassus_times(&self, x: &[[T; D]], y: &mut [[T; D]]) {
        multiply_transposed(&self.delassus, x, y);
    }

    /// `X_i` and where it is not zero, of the contacts in use.
    #[inline]
    fn whitened(&self) -> impl Iterator<Item = (&[[T; D]; N], Support)> {
        let whitened = self.whitened.get(..self.contacts).unwrap_or_default();
        opaque(whitened).iter().zip(self.supports.iter().copied())
    }

    /// From `g` to the `x` of `Uᵀ D⁻¹ x = g`, from which [`Self::contact_velocity`] and
    /// [`Self::velocity`] start.
    pub(crate) fn whiten(&self, g: &mut [T; N]) {
        solve_upper(&self.mass, g);
    }

    /// `H M⁻¹ g` for a `g` that was whitened. Returns `gᵀ M⁻¹ g`.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn contact_velocity(&self, g: &[T; N], u: &mut ContactVector<T, D, C>) -> T {
        let mut scaled = *g;
        let mut energy = T::ZERO;
        for (i, (scaled, row)) in opaque_mut(&mut scaled)
            .iter_mut()
            .zip(&self.mass)
            .enumerate()
        {
            rolled();
            let g = *scaled;
            *scaled *= row.get(i).copied().unwrap_or(T::ZERO);
            energy += g * *scaled;
        }
        let (scaled, last) = scaled.as_chunks::<GROUP>();
        for (u, (whitened, support)) in opaque_mut(u).iter_mut().zip(self.whitened()) {
            let (columns, rest) = whitened.as_chunks::<GROUP>();
            let mut sums = [T::ZERO; D];
            for group in support.groups::<N>() {
                rolled();
                if let (Some(columns), Some(g)) = (columns.get(group), scaled.get(group)) {
                    add_columns(columns, g, &mut sums);
                }
            }
            add_columns(rest, last, &mut sums);
            *u = sums;
        }
        energy
    }

    /// `W_NN d` for one `d_i` a contact, and `|H_Nᵀ d|` in the norm of `M⁻¹`; by way of `H_Nᵀ d`,
    /// so that both are small where that is.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn normal_products(&self, d: &[T; C]) -> ([T; C], T) {
        let mut momentum = [T::ZERO; N];
        let mut impulse = [[T::ZERO; D]; C];
        for (impulse, &d) in impulse.iter_mut().zip(d) {
            if let Some(normal) = impulse.first_mut() {
                *normal = d;
            }
        }
        self.add_whitened(&impulse, &mut momentum);
        let energy = self.contact_velocity(&momentum, &mut impulse);
        let mut product = [T::ZERO; C];
        for (product, velocity) in product.iter_mut().zip(&impulse).take(self.contacts) {
            *product = velocity.first().copied().unwrap_or(T::ZERO);
        }
        (product, energy.max(T::ZERO).square_root())
    }

    /// Adds `Hᵀ r`, whitened, to `g`.
    #[cfg_attr(target_os = "none", inline(never))]
    fn add_whitened(&self, r: &[[T; D]], g: &mut [T; N]) {
        let (g, last) = g.as_chunks_mut::<GROUP>();
        for (&r, (whitened, support)) in opaque(r).iter().zip(self.whitened()) {
            if r == [T::ZERO; D] {
                continue;
            }
            let (columns, rest) = whitened.as_chunks::<GROUP>();
            for group in support.groups::<N>() {
                rolled();
                if let (Some(columns), Some(g)) = (columns.get(group), g.get_mut(group)) {
                    add_products(columns, r, g);
                }
            }
            add_products(rest, r, last);
        }
    }

    /// `v = M⁻¹ (Hᵀ r + g)` for a `g` that was whitened.
    pub(crate) fn velocity(&self, g: &[T; N], r: &[[T; D]], v: &mut [T; N]) {
        *v = *g;
        self.add_whitened(r, v);
        solve_lower(&self.mass, v);
    }
}
