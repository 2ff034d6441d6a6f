//! How near a solution is to a change of mode.

use crate::linalg::vector::{norm, square};
use crate::real::Real;
use crate::sets::{ContactSet, RowSet};
use crate::solution::{ContactMode, RowMode};

/// The least impulse that would change a mode, and the largest that there is. In the square, over the effective mass: an energy
/// (J), whatever a row is of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Margin<T> {
    least: T,
    impulse: T,
    motion: T,
}

impl<T: Real> Margin<T> {
    /// That of nothing.
    pub(super) const fn none() -> Self {
        Self {
            least: T::INFINITY,
            impulse: T::ZERO,
            motion: T::ZERO,
        }
    }

    /// Notes that so much impulse is left.
    fn note(&mut self, left: T, alpha: T) {
        let left = left.max(T::ZERO);
        self.least = self.least.min(left * left / alpha);
    }

    /// Counts a contact.
    pub(super) fn add_contact<const D: usize>(
        &mut self,
        set: &ContactSet<T, D>,
        mode: ContactMode,
        (u, r): (&[T; D], &[T; D]),
    ) {
        let ([u_normal, u_tangent @ ..], [load, r_tangent @ ..]) = (u.as_slice(), r.as_slice())
        else {
            return;
        };
        let (alpha, mu) = (set.alpha, set.cone.friction());
        if alpha <= T::ZERO {
            return;
        }
        self.impulse = self.impulse.max(square(r) / alpha);
        self.motion = self.motion.max(square(u) * alpha);
        if mode == ContactMode::Open {
            let apart = *u_normal + (set.shift_factor - mu) * norm(u_tangent);
            return self.note(apart * alpha, alpha);
        }
        self.note(*load, alpha);
        if mu > T::ZERO && D > 1 {
            self.note(
                match mode {
                    ContactMode::Stick => mu * *load - norm(r_tangent),
                    _ => norm(u_tangent) * alpha,
                },
                alpha,
            );
        }
    }

    /// Counts a joint row.
    pub(super) fn add_row(&mut self, set: &RowSet<T>, mode: RowMode, u: T, r: T) {
        let (alpha, [lower, upper]) = (set.alpha, set.bounds);
        if alpha <= T::ZERO || lower == upper {
            return;
        }
        self.impulse = self.impulse.max(r * r / alpha);
        self.motion = self.motion.max(u * u * alpha);
        self.note(
            match mode {
                RowMode::Open | RowMode::AtLower => u * alpha,
                RowMode::AtUpper => -u * alpha,
                RowMode::AtLimit | RowMode::Holding => (r - lower).min(upper - r),
            },
            alpha,
        );
    }

    /// The root of the least over the largest; infinite if there is nothing that could change.
    pub(super) fn value(&self) -> T {
        let size = if self.impulse > T::ZERO {
            self.impulse
        } else {
            self.motion
        };
        if size > T::ZERO {
            (self.least / size).square_root()
        } else {
            T::INFINITY
        }
    }
}
