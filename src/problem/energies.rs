//! The error of joint rows, relative to an energy.
//!
//! `sqrt(Σ W_jj (λ_j - Π_j(λ_j - s_j / W_jj))²) / S` where `S²` is the largest of the work of all impulses,
//! `|Hᵀ r + Jᵀ λ|²` in the norm of `M⁻¹` with what compliance stores, of what each contact and each row would take if it
//! were alone, and of the ten-thousandth part of the free motion's `v·M v`.
//!
//! Energies stand here over the reference mass to which rows are scaled, as squares of speeds: whatever changes with a unit is
//! a power of two then, and no root is taken of it.
//!
//! A stop that is far from being reached, or a redundant loop that holds against itself, loosens nothing.

use crate::Real;
use crate::cone::square;
use crate::laws::{Laws, Room};
use crate::linalg::hints::rolled;
use crate::problem::ContactLaw;
use crate::problem::residual::{larger, quotient, root_sum, unit};
use crate::problem::row_laws::clamped;
use crate::scene::slot::SlotRows;

/// The share of the free motion's energy that impulses are not compared with less than.
const SHARE: f64 = 1e-4;

/// What the error of joint rows is relative to, before there are impulses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Energies<T> {
    /// The reference mass of the scene, the step `alpha` of joint rows.
    mass: T,
    /// Brings speeds near 1.
    unit: T,
    /// The energy that impulses are compared with at least, over the mass and in this unit.
    least: T,
}

/// Joint rows as they were given, where impulses and velocities are not scaled: their laws and scales.
pub(super) type Given<'a, T, const D: usize> = (&'a SlotRows<T, D>, &'a [T; D]);

impl<T: Real> Energies<T> {
    /// Of slots, with the free motion's `v·M v`.
    pub(super) fn new<const D: usize, L: Laws>(
        laws: &[ContactLaw<T, D, L>],
        free: T,
        mass: T,
    ) -> Self {
        // The speed of the reference mass that has as much energy: for the unit alone.
        let mut largest = (free / mass).square_root() * T::literal(1e-2);
        let mut lightest = T::ONE;
        for law in laws {
            rolled();
            if let Some(rows) = law.rows.get() {
                let alone = rows.working(rows.project(&(-law.q * mass)).into());
                largest = larger(largest, &alone, T::ONE / mass);
            } else {
                lightest = larger(lightest, &[law.alpha], T::ONE / mass);
                largest = larger(largest, law.q.as_slice(), T::ONE);
            }
        }
        // No product of three of them overflows.
        let unit = unit(largest) * unit_root(lightest);
        let mut alone = T::ZERO;
        for law in laws {
            rolled();
            if let Some(rows) = law.rows.get() {
                let pushes = rows.working(rows.project(&(-law.q * mass)).into());
                alone += square(&pushes.map(|push| push / mass * unit));
            } else {
                let push = -law.augmented(&(law.q * unit));
                alone += law.cone.projected_square(&push) * (law.alpha / mass);
            }
        }
        let free = T::literal(SHARE) * (free / mass * unit) * unit;
        Self {
            mass,
            unit,
            least: alone.max(free),
        }
    }

    /// The speed of the reference mass that has the energy that impulses are compared with at least.
    fn speed(&self) -> T {
        self.least.square_root() / self.unit
    }

    /// The impulse to expect along rows of a mass `alpha`.
    pub(super) fn expected(&self, alpha: T) -> T {
        self.speed() * (alpha / self.mass).square_root() * self.mass
    }

    /// What momenta are compared with at least, in the norm `Σ e_k² m / M_kk`, and a mass `M_kk` times in that of momenta: where
    /// stiction holds against a spring nothing moves, and what is left of impulses that cancel each other is rounding.
    pub(super) fn momentum(&self, mass: T) -> T {
        self.speed() * (mass / self.mass).square_root() * self.mass * T::literal(1e-2)
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
                let speeds = law.working(impulse).map(|r| r / law.alpha * self.unit);
                squares += square(&speeds) * (law.alpha / self.mass);
            }
        }
        quotient(squares, self.least).square_root()
    }

    /// The larger of the error of contacts and that of joint rows, from velocities `u` (`W r + q`, or `H v + w` and the squares
    /// of bounds on its rounding, one a slot) and what of them is not of impulses. Joint rows that are `given` have neither
    /// impulses nor velocities scaled: an impulse at its bound then is there to the last bit.
    pub(super) fn larger<'a, const D: usize, L: Laws>(
        &self,
        contacts: T,
        laws: &[ContactLaw<T, D, L>],
        (u, r): (&[[T; D]], &[[T; D]]),
        noise: &[[T; 2]],
        given: impl Fn(usize) -> Option<Given<'a, T, D>>,
    ) -> T {
        let (mut residual, mut noises) = (T::ZERO, T::ZERO);
        for (i, ((law, u), r)) in laws.iter().zip(u).zip(r).enumerate() {
            rolled();
            let Some(rows) = law.rows.get() else { continue };
            let (bounds, scales) = match given(i) {
                Some((given, scales)) => (rows.of_moving(&given.bounds), *scales),
                None => (rows.bounds, [T::ONE; D]),
            };
            // Of a velocity, scaled.
            let noise = noise.get(i).map_or(T::ZERO, |&[noise, _]| noise);
            let sources = u.iter().zip(r).zip(&bounds).zip(scales);
            for (((&u, &r), bounds), scale) in sources {
                // In units of the row, of which `1 / W_jj` is the square of its scale times the mass.
                let answer = u * scale * scale * self.mass;
                let push = r - answer;
                let other = clamped(push, bounds);
                // Not `r - push`: a large impulse would round it.
                let off = if other == push { answer } else { r - other };
                let off = off / scale / self.mass * self.unit;
                residual += off * off;
                // At a bound it stays there whatever of this size was added to its velocity?
                let beyond = (push - other) / scale / self.mass;
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
        contacts.max(of(self.work(laws, (u, r), noise, given).max(self.least)))
    }

    /// The work of all impulses, less what rounding may have added to it.
    fn work<'a, const D: usize, L: Laws>(
        &self,
        laws: &[ContactLaw<T, D, L>],
        (u, r): (&[[T; D]], &[[T; D]]),
        noise: &[[T; 2]],
        given: impl Fn(usize) -> Option<Given<'a, T, D>>,
    ) -> T {
        let [mut work, mut squares, mut noises] = [T::ZERO; 3];
        for (i, ((law, u), r)) in laws.iter().zip(u).zip(r).enumerate() {
            rolled();
            if *r == [T::ZERO; D] {
                continue;
            }
            let scales = given(i).map_or([T::ONE; D], |(_, scales)| *scales);
            let speeds = u.iter().zip(law.q.iter()).zip(scales);
            for (((&u, &q), scale), r) in speeds.zip(law.working(*r)) {
                let r = r / scale / self.mass * self.unit;
                work += r * ((u * scale - q) * self.unit);
                squares += r * r;
            }
            noises += noise.get(i).map_or(T::ZERO, |&[noise, _]| noise);
        }
        // `u` and `q` are off by as much.
        let noise = (squares * (noises * self.unit * self.unit)).square_root();
        work - (noise + noise)
    }
}

/// A power of two whose square brings a number of 1 at least near 1.
fn unit_root<T: Real>(number: T) -> T {
    T::power_of_two(-(number.exponent() >> 1))
}
