//! The error of joint rows, relative to an energy.
//!
//! `sqrt(Σ W_jj (λ_j - Π_j(λ_j - s_j / W_jj))²) / S` where `S²` is the largest of the work of all impulses,
//! `|Hᵀ r + Jᵀ λ|²` in the norm of `M⁻¹` with what compliance stores, of what each contact and each row would take if it
//! were alone, and of the ten-thousandth part of the free motion's `v·M v`. Rows are scaled to unit `W_jj`.
//!
//! A stop that is far from being reached, or a redundant loop that holds against itself, loosens nothing.

use crate::Real;
use crate::cone::square;
use crate::laws::{Laws, Room};
use crate::linalg::hints::rolled;
use crate::problem::ContactLaw;
use crate::problem::residual::{larger, quotient, root_sum, unit};
use crate::problem::row_laws::clamped;
use nalgebra::SVector;

/// The share of the free motion's energy that impulses are not compared with less than.
const SHARE: f64 = 1e-4;

/// What the error of joint rows is relative to, before there are impulses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Energies<T> {
    /// Brings roots of energies near 1.
    unit: T,
    /// In this unit.
    least: T,
}

impl<T: Real> Energies<T> {
    /// Of slots, with the free motion's `v·M v`.
    pub(super) fn new<const D: usize, L: Laws>(laws: &[ContactLaw<T, D, L>], free: T) -> Self {
        let mut largest = free.square_root() * T::literal(1e-2);
        for law in laws {
            rolled();
            if let Some(rows) = law.rows.get() {
                let alone = rows.working(rows.project(&-law.q).into());
                largest = larger(largest, &alone, T::ONE);
            } else {
                largest = larger(largest, law.q.as_slice(), law.alpha.square_root());
            }
        }
        let unit = unit(largest);
        let mut alone = T::ZERO;
        for law in laws {
            rolled();
            if let Some(rows) = law.rows.get() {
                let pushes = rows.working(rows.project(&-law.q).into());
                alone += square(&pushes.map(|push| push * unit));
            } else {
                let root = law.alpha.square_root() * unit;
                let push = -law.augmented(&(law.q * root));
                alone += law.cone.projected_square(&push);
            }
        }
        let free = T::literal(SHARE) * (free * unit) * unit;
        Self {
            unit,
            least: alone.max(free),
        }
    }

    /// The root of the energy that impulses are compared with at least.
    pub(super) fn root(&self) -> T {
        self.least.square_root() / self.unit
    }

    /// What momenta are compared with at least, in the norm `Σ e_k² / M_kk`: where stiction holds against a spring nothing
    /// moves, and what is left of impulses that cancel each other is rounding.
    pub(super) fn momentum(&self) -> T {
        self.root() * T::literal(1e-2)
    }

    /// The size of impulses, in units of what the velocities to be changed explain.
    pub(crate) fn share<const D: usize, L: Laws>(
        &self,
        laws: &[ContactLaw<T, D, L>],
        impulses: impl Iterator<Item = [T; D]>,
    ) -> T {
        let mut squares = T::ZERO;
        for (law, impulse) in laws.iter().zip(impulses) {
            rolled();
            if law.alpha > T::ZERO {
                let scale = self.unit / law.alpha.square_root();
                squares += square(&law.working(impulse).map(|r| r * scale));
            }
        }
        quotient(squares, self.least).square_root()
    }

    /// The larger of the error of contacts and that of joint rows, from velocities `u` (`W r + q`, or `H v + w` and the squares
    /// of bounds on its rounding, one a slot) and what of them is not of impulses.
    pub(super) fn larger<const D: usize, L: Laws>(
        &self,
        contacts: T,
        laws: &[ContactLaw<T, D, L>],
        (u, r): (&[[T; D]], &[[T; D]]),
        noise: &[T],
        q: impl Fn(&ContactLaw<T, D, L>) -> SVector<T, D>,
    ) -> T {
        let (mut residual, mut noises) = (T::ZERO, T::ZERO);
        for (i, ((law, u), r)) in laws.iter().zip(u).zip(r).enumerate() {
            rolled();
            let Some(rows) = law.rows.get() else { continue };
            let noise = noise.get(i).copied().unwrap_or(T::ZERO);
            for ((&u, &r), bounds) in u.iter().zip(r).zip(&rows.bounds) {
                let push = r - u;
                let other = clamped(push, bounds);
                // Not `r - push`: a large impulse would round it.
                let off = if other == push { u } else { r - other };
                let off = off * self.unit;
                residual += off * off;
                // At a bound it stays there whatever of this size was added to its velocity?
                let beyond = push - other;
                let stays = other == r && beyond * beyond > noise;
                if !stays {
                    noises += noise * self.unit * self.unit;
                }
            }
        }
        if residual + noises == T::ZERO {
            return contacts;
        }
        let of = |size| root_sum(residual, noises, size);
        if of(self.least) <= contacts {
            return contacts;
        }
        contacts.max(of(self.work(laws, (u, r), noise, q).max(self.least)))
    }

    /// The work of all impulses, less what rounding may have added to it.
    fn work<const D: usize, L: Laws>(
        &self,
        laws: &[ContactLaw<T, D, L>],
        (u, r): (&[[T; D]], &[[T; D]]),
        noise: &[T],
        q: impl Fn(&ContactLaw<T, D, L>) -> SVector<T, D>,
    ) -> T {
        let [mut work, mut squares, mut noises] = [T::ZERO; 3];
        for (i, ((law, u), r)) in laws.iter().zip(u).zip(r).enumerate() {
            rolled();
            if *r == [T::ZERO; D] {
                continue;
            }
            for ((&u, &q), r) in u.iter().zip(q(law).iter()).zip(law.working(*r)) {
                let r = r * self.unit;
                work += r * ((u - q) * self.unit);
                squares += r * r;
            }
            noises += noise.get(i).copied().unwrap_or(T::ZERO);
        }
        // `u` and `q` are off by as much.
        let noise = (squares * (noises * self.unit * self.unit)).square_root();
        work - (noise + noise)
    }
}
