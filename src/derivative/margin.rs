//! The distance of a solution to the next change of a mode.

use crate::linalg::vector::{norm, square};
use crate::real::Real;
use crate::sets::{ContactSet, RowSet};
use crate::solution::{ContactMode, RowMode};

/// The least impulse that would change a mode, and the largest impulses, to which it is relative. All are squares over the effective mass:
/// energies (J), also of rotations.
#[derive(Clone, Copy, Debug)]
pub(super) struct Margin<T> {
    /// Least impulse that would change a mode.
    least: T,
    /// Largest impulse of a contact or a joint row.
    impulse: T,
    /// Largest impulse that would stop a contact or a joint row.
    motion: T,
}

impl<T: Real> Margin<T> {
    /// The margin without contacts and joint rows.
    pub(super) const fn none() -> Self {
        Self { least: T::INFINITY, impulse: T::ZERO, motion: T::ZERO }
    }

    /// Takes in an impulse that would change a mode.
    fn note(&mut self, impulse: T, alpha: T) {
        let impulse = impulse.max(T::ZERO) / alpha.square_root();
        self.least = self.least.min(impulse * impulse);
    }

    /// Takes in a contact.
    pub(super) fn add_contact<const D: usize>(
        &mut self,
        set: &ContactSet<T, D>,
        mode: ContactMode,
        (u, r): (&[T; D], &[T; D]),
    ) {
        let ([u_normal, u_tangent @ ..], [load, r_tangent @ ..]) = (u.as_slice(), r.as_slice()) else {
            return;
        };
        let (alpha, mu) = (set.alpha, set.cone.friction());
        if alpha <= T::ZERO {
            return;
        }
        // Roots first: squares of impulses and velocities may overflow.
        let root = alpha.square_root();
        self.impulse = self.impulse.max(square(&r.map(|x| x / root)));
        self.motion = self.motion.max(square(&u.map(|x| x * root)));
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

    /// Takes in a joint row.
    pub(super) fn add_row(&mut self, set: &RowSet<T>, mode: RowMode, u: T, r: T) {
        let (alpha, [lower, upper]) = (set.alpha, set.bounds);
        if alpha <= T::ZERO || lower == upper {
            return;
        }
        let root = alpha.square_root();
        self.impulse = self.impulse.max(square(&[r / root]));
        self.motion = self.motion.max(square(&[u * root]));
        self.note(
            match mode {
                RowMode::Open | RowMode::AtLower => u * alpha,
                RowMode::AtUpper => -u * alpha,
                RowMode::AtLimit | RowMode::Holding => (r - lower).min(upper - r),
            },
            alpha,
        );
    }

    /// The least impulse over the largest one (dimensionless); infinite if there is no mode that could change.
    pub(super) fn value(&self) -> T {
        let size = if self.impulse > T::ZERO { self.impulse } else { self.motion };
        if size > T::ZERO { (self.least / size).square_root() } else { T::INFINITY }
    }
}
