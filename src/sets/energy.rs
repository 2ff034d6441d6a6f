//! The error of joint rows, relative to an energy.
//!
//! `sqrt(Σ W_jj (λ_j - Π_j(λ_j - s_j / W_jj))²) / S` where `S²` is the largest of the work of all impulses,
//! `|Hᵀ r + Jᵀ λ|²` in the norm of `M⁻¹` with what compliance stores, of what each contact and each row would take if it
//! were alone, and of the ten-thousandth part of the free motion's `v·M v`.
//!
//! Energies are computed in a unit, a power of two, so that they neither overflow nor vanish; no root is taken of one that
//! changes by an odd power of two with a unit of the scene.
//!
//! A stop that is far from being reached, or a redundant loop that holds against itself, loosens nothing.

use crate::linalg::stacked::Stacked;
use crate::linalg::vector::{larger, precision, quotient, root_sum, square};
use crate::real::Real;
use crate::sets::Sets;

/// The share of the free motion's energy that impulses are not compared with less than.
const SHARE: f64 = 1e-4;

/// What the error of joint rows is relative to, before there are impulses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EnergyScale<T> {
    /// Root of the unit: speeds and impulses are multiplied by it before they are squared.
    unit: T,
    /// The energy that impulses are compared with at least, in the unit.
    floor: T,
}

/// Squares of bounds on the rounding of velocities: of each contact that of all rows and that of the normal one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VelocityNoise<T, const C: usize, const R: usize> {
    pub(crate) contacts: [[T; 2]; C],
    pub(crate) rows: [T; R],
}

impl<T: Real> EnergyScale<T> {
    /// Of no scene.
    pub(crate) const fn none() -> Self {
        Self {
            unit: T::ONE,
            floor: T::ZERO,
        }
    }

    /// Of sets, with the free motion's `v·M v`.
    pub(crate) fn new<const D: usize, const C: usize, const R: usize>(
        sets: &Sets<T, D, C, R>,
        free: T,
    ) -> Self {
        // Twice the exponent of the unit: a bound on that of each energy.
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
        let alone = contacts
            .chain(rows)
            .fold(T::ZERO, |sum, energy| sum + energy);
        let free = T::literal(SHARE) * (free * unit) * unit;
        Self {
            unit,
            floor: alone.max(free),
        }
    }

    /// The impulse to expect along rows of a mass `alpha`.
    pub(crate) fn expected(&self, alpha: T) -> T {
        (self.floor * alpha).square_root() / self.unit
    }

    /// What squares of momenta over a mass are compared with at least, in units of this root: where stiction holds against a
    /// spring nothing moves, and what is left of impulses that cancel each other is rounding.
    pub(crate) fn momentum_floor(&self, unit: T) -> T {
        let ratio = unit / self.unit;
        self.floor * T::literal(SHARE) * (ratio * ratio)
    }

    /// The size of impulses, in units of what the velocities to be changed explain.
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

    /// The larger of the error of contacts and that of joint rows, from velocities `u` (`W r + q`, or `H v + w` with bounds on
    /// its rounding).
    pub(crate) fn larger_error<const D: usize, const C: usize, const R: usize>(
        &self,
        contacts: T,
        sets: &Sets<T, D, C, R>,
        (u, r): (&Stacked<T, D, C, R>, &Stacked<T, D, C, R>),
        noise: Option<&VelocityNoise<T, C, R>>,
    ) -> T {
        let (mut residual, mut noises) = (T::ZERO, T::ZERO);
        let rows = sets.rows().iter().zip(u.rows.iter().zip(&r.rows));
        for (j, (set, (&u, &r))) in rows.enumerate() {
            let (off, beyond) = set.natural_map(r, u);
            if off != T::ZERO {
                residual += square(&[off * self.unit]) / set.alpha;
            }
            let noise = noise.and_then(|noise| noise.rows.get(j));
            let noise = noise.copied().unwrap_or(T::ZERO);
            // At a bound it stays there whatever of this size was added to its velocity?
            let stays = off == T::ZERO && beyond * beyond > noise;
            if !stays {
                noises += noise * (set.alpha * self.unit) * self.unit;
            }
        }
        if residual + noises == T::ZERO {
            return contacts;
        }
        let of = |size| root_sum(residual, noises, size);
        if of(self.floor) <= contacts {
            return contacts;
        }
        contacts.max(of(self.power(sets, (u, r), noise).max(self.floor)))
    }

    /// The work of all impulses, less what rounding may have added to it.
    fn power<const D: usize, const C: usize, const R: usize>(
        &self,
        sets: &Sets<T, D, C, R>,
        (u, r): (&Stacked<T, D, C, R>, &Stacked<T, D, C, R>),
        noise: Option<&VelocityNoise<T, C, R>>,
    ) -> T {
        let (mut work, mut noises, mut size) = (T::ZERO, T::ZERO, T::ZERO);
        let mut add = |u: &[T], q: &[T], r: &[T], noise: T| {
            let mut squares = T::ZERO;
            for ((&u, &q), &r) in u.iter().zip(q).zip(r) {
                let product = (r * self.unit) * ((u - q) * self.unit);
                work += product;
                size += product.abs();
                squares += (r * self.unit) * (r * self.unit);
            }
            noises += (squares * (noise * self.unit * self.unit)).square_root();
        };
        let contacts = sets
            .contacts()
            .iter()
            .zip(u.contacts.iter().zip(&r.contacts));
        for (i, (set, (u, r))) in contacts.enumerate() {
            let noise = noise.and_then(|noise| noise.contacts.get(i));
            add(
                u,
                set.q.as_slice(),
                r,
                noise.map_or(T::ZERO, |&[noise, _]| noise),
            );
        }
        let rows = sets.rows().iter().zip(u.rows.iter().zip(&r.rows));
        for (j, (set, (&u, &r))) in rows.enumerate().filter(|(_, (set, _))| set.alpha > T::ZERO) {
            let noise = noise.and_then(|noise| noise.rows.get(j));
            add(&[u], &[set.q], &[r], noise.copied().unwrap_or(T::ZERO));
        }
        // `u` and `q` are off by as much, and a term takes part in so many operations.
        let counts = sets.counts();
        let rounding: T = precision(D * counts.contacts + counts.rows + 4);
        work - (noises + noises) - rounding * size
    }
}
