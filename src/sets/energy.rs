//! The error of joint rows, relative to an energy: the third part of the error in [`crate::guide::error`].
//!
//! It is `sqrt(Σ W_jj (λ_j - Π_j(λ_j - s_j / W_jj))²) / S`. `S²` is the largest of three energies:
//!
//! - twice the energy of all impulses: `|Hᵀ r + Jᵀ λ|²` in the norm of `M⁻¹`, plus twice the energy stored in compliance;
//! - the sum of the same energies of the contacts and rows, each as if it were alone;
//! - a ten-thousandth of `v·M v` of the free motion.
//!
//! A stop that is far away or a redundant loop does not enlarge `S`.
//!
//! Energies are computed in a unit, a power of two, so that they neither overflow nor vanish. If a unit of mass, length or time
//! changes by a power of two, each number under a root changes by an even power of two, so no mantissa changes.

use crate::linalg::stacked::Stacked;
use crate::linalg::vector::{larger, quotient, root_sum, rounding_bound, square};
use crate::linalg::zip::{zip3, zip4};
use crate::real::Real;
use crate::sets::Sets;

/// Least `S²` as a share of `v·M v` of the free motion, and least square of the momentum's denominator as a share of the least
/// `S²`.
const SHARE: f64 = 1e-4;

/// The part of `S²` that does not depend on impulses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EnergyScale<T> {
    /// Root of the unit of energies: velocities and impulses are multiplied by it before they are squared.
    unit: T,
    /// The least `S²`, in the unit.
    floor: T,
}

/// Squares of bounds on the rounding of velocities.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VelocityNoise<T, const C: usize, const R: usize> {
    /// For all rows of each contact together, and for its normal row.
    pub(crate) contacts: [[T; 2]; C],
    /// For each joint row.
    pub(crate) rows: [T; R],
}

impl<T: Real> EnergyScale<T> {
    /// The scale of an empty scene.
    pub(crate) const fn none() -> Self {
        Self { unit: T::ONE, floor: T::ZERO }
    }

    /// The scale of these sets. `free` is `v·M v` of the free motion.
    pub(crate) fn new<const D: usize, const C: usize, const R: usize>(
        sets: &Sets<T, D, C, R>,
        free: T,
    ) -> Self {
        // Twice the exponent of the unit: a bound on the exponent of each energy.
        let mut exponent = (free * T::literal(SHARE)).exponent();
        for set in sets.contacts() {
            let fastest = larger(T::ZERO, set.q.as_slice(), T::ONE + set.shift_factor);
            exponent = exponent.max(2 * fastest.exponent() + set.alpha.exponent());
        }
        for set in sets.rows() {
            if set.alpha > T::ZERO {
                let alone = set.alone().abs();
                exponent = exponent.max(2 * alone.exponent() - set.alpha.exponent());
            }
        }
        let unit = T::power_of_two(-(exponent >> 1));
        let contacts = sets.contacts().iter().map(|set| set.alone_energy(unit));
        let rows = sets.rows().iter().map(|set| set.alone_energy(unit));
        let alone = contacts.chain(rows).fold(T::ZERO, |sum, energy| sum + energy);
        let free = T::literal(SHARE) * (free * unit) * unit;
        Self { unit, floor: alone.max(free) }
    }

    /// Least square of the denominator of the momentum's error, where momenta are multiplied by `unit` and their squares divided
    /// by a mass. Where stiction holds a body against a spring, impulses cancel each other, and their sum is rounding alone.
    pub(crate) fn momentum_floor(&self, unit: T) -> T {
        let ratio = unit / self.unit;
        self.floor * T::literal(SHARE) * (ratio * ratio)
    }

    /// Root of the energy of the impulses, relative to the root of the least `S²`: 1 for impulses of the expected size.
    pub(crate) fn ratio<const D: usize, const C: usize, const R: usize>(
        &self,
        sets: &Sets<T, D, C, R>,
        r: &Stacked<T, D, C, R>,
    ) -> T {
        let mut energy = T::ZERO;
        for (set, r) in sets.contacts().iter().zip(&r.contacts) {
            if set.alpha > T::ZERO {
                energy += square(&r.map(|r| r * self.unit)) / set.alpha;
            }
        }
        for (set, &r) in sets.rows().iter().zip(&r.rows) {
            if set.alpha > T::ZERO {
                energy += square(&[r * self.unit]) / set.alpha;
            }
        }
        quotient(energy, self.floor).square_root()
    }

    /// The larger of the error of contacts and the error of joint rows, from the velocities `u`. They are `W r + q` without `noise`,
    /// or `H v + w` with bounds `noise` on its rounding.
    pub(crate) fn larger_error<const D: usize, const C: usize, const R: usize>(
        &self,
        contacts: T,
        sets: &Sets<T, D, C, R>,
        (u, r): (&Stacked<T, D, C, R>, &Stacked<T, D, C, R>),
        noise: Option<&VelocityNoise<T, C, R>>,
    ) -> T {
        let (mut residual, mut noises) = (T::ZERO, T::ZERO);
        let mut is_violated = false;
        for (j, set, &u, &r) in zip4(0..R, sets.rows(), &u.rows, &r.rows) {
            let row = set.residual(r, u);
            if row.value != T::ZERO {
                is_violated = true;
                residual += square(&[row.value * self.unit]) / set.alpha;
            }
            let noise = noise.and_then(|noise| noise.rows.get(j));
            let noise = noise.copied().unwrap_or(T::ZERO);
            // A row stays at its bound if its velocity changes by less than `excess`.
            let stays = row.value == T::ZERO && row.excess * row.excess > noise;
            if !stays {
                noises += noise * (set.alpha * self.unit) * self.unit;
            }
        }
        if is_violated && self.floor == T::ZERO {
            // Nothing moves without impulses, so none is needed. Squares of those that remain may vanish.
            return contacts.max(T::ONE);
        }
        if residual + noises == T::ZERO {
            return contacts;
        }
        let relative_to = |size| root_sum(residual, noises, size);
        if relative_to(self.floor) <= contacts {
            return contacts;
        }
        let work = self.least_energy(sets, (u, r), noise);
        contacts.max(relative_to(work.max(self.floor)))
    }

    /// Lower bound on the work of all impulses: the computed work minus a bound on its rounding.
    fn least_energy<const D: usize, const C: usize, const R: usize>(
        &self,
        sets: &Sets<T, D, C, R>,
        (u, r): (&Stacked<T, D, C, R>, &Stacked<T, D, C, R>),
        noise: Option<&VelocityNoise<T, C, R>>,
    ) -> T {
        let (mut work, mut noises, mut size) = (T::ZERO, T::ZERO, T::ZERO);
        let mut add = |u: &[T], q: &[T], r: &[T], noise: T| {
            let mut squares = T::ZERO;
            for (&u, &q, &r) in zip3(u, q, r) {
                let product = (r * self.unit) * ((u - q) * self.unit);
                work += product;
                size += product.abs();
                squares += (r * self.unit) * (r * self.unit);
            }
            noises += (squares * (noise * self.unit * self.unit)).square_root();
        };
        for (i, set, u, r) in zip4(0..C, sets.contacts(), &u.contacts, &r.contacts) {
            let noise = noise.and_then(|noise| noise.contacts.get(i));
            add(u, set.q.as_slice(), r, noise.map_or(T::ZERO, |&[noise, _]| noise));
        }
        for (j, set, &u, &r) in zip4(0..R, sets.rows(), &u.rows, &r.rows) {
            if set.alpha > T::ZERO {
                let noise = noise.and_then(|noise| noise.rows.get(j));
                add(&[u], &[set.q], &[r], noise.copied().unwrap_or(T::ZERO));
            }
        }
        // An estimate: `q` is taken to be as inexact as `u`, hence twice the noise. A term takes part in `m + 4` operations.
        let counts = sets.counts();
        let rounding: T = rounding_bound(D * counts.contacts + counts.rows + 4);
        work - (noises + noises) - rounding * size
    }
}

#[cfg(test)]
mod tests;
