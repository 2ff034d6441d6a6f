//! The set of one contact: its cone and the De Saxcé shift ([`crate::guide::error`]). Each file of this folder has the equations of
//! one method for one contact.

use crate::cone::{FrictionCone, add_to_normal, split};
use crate::linalg::vector::{norm, square, zeros};
use crate::real::Real;
use crate::scene::Contact;
use crate::solution::Model;
use nalgebra::SVector;

pub(super) mod coulomb_sweep;
pub(crate) mod expected;
pub(super) mod frame;
pub(super) mod local;
pub(super) mod lorentz;
pub(crate) mod natural_map;
pub(super) mod pair;
pub(super) mod relaxed_sweep;
mod several_tangents;

/// The cone of one contact, with its effective mass and its velocity without impulses. Its rows are scaled so that the cone is round.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactSet<T: Real, const D: usize> {
    /// Factor of the De Saxcé shift: `mu_i`, or 0 in the convex relaxation.
    pub(crate) shift_factor: T,
    /// The cone `K` the impulse lies in.
    pub(crate) cone: FrictionCone<T>,
    /// Mean effective mass `alpha_i` (kg), the step of the natural map; 0 if nothing moves the contact.
    pub(crate) alpha: T,
    /// `q_i = H_i v_free + w_i`, the velocity without impulses.
    pub(crate) q: SVector<T, D>,
    /// The constant term of the velocities of [`crate::problem::Problem::velocities`]: `q`, or `w` if these include the free motion.
    /// Iterative refinement adds to it.
    pub(crate) base: SVector<T, D>,
}

impl<T: Real, const D: usize> ContactSet<T, D> {
    /// The set of an unused contact.
    pub(super) const fn none() -> Self {
        Self {
            shift_factor: T::ZERO,
            cone: FrictionCone::frictionless(),
            alpha: T::ZERO,
            q: zeros(),
            base: zeros(),
        }
    }

    /// The set of a contact with the effective mass `alpha_i` and the velocity `q_i` without impulses.
    #[inline]
    pub(crate) fn new<const N: usize>(
        contact: &Contact<T, N, D>,
        law: Model,
        alpha: T,
        q: SVector<T, D>,
    ) -> Self {
        let cone = FrictionCone::new(contact.mu).unwrap_or(FrictionCone::frictionless());
        let mut set = Self { shift_factor: T::ZERO, cone, alpha, q, base: q };
        set.set_law(law);
        set
    }

    /// Includes the De Saxcé shift (Coulomb's law), or leaves it out (the relaxation).
    #[inline]
    pub(crate) fn set_law(&mut self, law: Model) {
        self.shift_factor = match law {
            Model::Coulomb => self.cone.friction(),
            Model::ConvexRelaxation => T::ZERO,
        };
    }

    /// Number of rows along which impulses may act.
    pub(crate) fn pushing_rows(&self) -> usize {
        if self.cone.friction() > T::ZERO { D } else { 1 }
    }

    /// Does an impulse lie on the boundary of a cone with friction?
    pub(crate) fn slips(&self, r: &[T; D]) -> bool {
        let (normal, tangent) = (r.first().copied().unwrap_or(T::ZERO), r.get(1..).unwrap_or_default());
        let grip = self.cone.friction() * normal;
        grip > T::ZERO && square(tangent) > grip * grip * T::literal(0.999)
    }

    /// `alpha |q|²` over some rows.
    #[inline]
    pub(crate) fn energy(&self, rows: usize) -> T {
        let rows = self.q.iter().take(rows);
        self.alpha * rows.fold(T::ZERO, |sum, &q| sum + q * q)
    }

    /// `|r0_i|² / alpha_i`, twice the energy of the impulse `r0_i = Π_K(-alpha_i q̂_i)` of the contact if it were alone.
    /// Velocities are multiplied by `unit`.
    pub(crate) fn alone_energy(&self, unit: T) -> T {
        let argument = -self.augmented(&(self.q * unit));
        self.cone.projected_square(&argument) * self.alpha
    }

    /// Does nothing move the contact, although the velocity `u` without an impulse violates its law?
    pub(crate) fn is_immovable_and_violated(&self, u: &SVector<T, D>) -> bool {
        self.alpha <= T::ZERO && self.is_violated(u)
    }

    /// Does the velocity `u` without an impulse violate the law?
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn is_violated(&self, u: &SVector<T, D>) -> bool {
        let (normal, tangent) = split(u);
        normal + (self.shift_factor - self.cone.friction()) * norm(tangent) < T::ZERO
    }

    /// De Saxcé shift `mu_i |u_Ti|` (m/s), which `û` adds to the normal velocity.
    pub(crate) fn shift(&self, u: &SVector<T, D>) -> T {
        let (_, tangent) = split(u);
        self.shift_factor * norm(tangent)
    }

    /// Augmented velocity `û_i = u_i + mu_i |u_Ti| e_N`.
    #[inline]
    pub(crate) fn augmented(&self, u: &SVector<T, D>) -> SVector<T, D> {
        let mut augmented = *u;
        add_to_normal(&mut augmented, self.shift(u));
        augmented
    }

    /// `trace(W_ii)`; 0 if nothing moves the contact.
    pub(crate) fn inverse_mass(&self) -> T {
        if self.alpha > T::ZERO { T::count(D) / self.alpha } else { T::ZERO }
    }

    /// Estimate of `|stop_i|²` from above, up to a constant factor. `energy` is `v·M v` of the free motion. (It is a bound with
    /// `|H_i v|` in place of `abs(H_i) abs(v)`, which may be larger.)
    pub(crate) fn stopping_bound(&self, offset: &[T; D], energy: T) -> T {
        let moves = T::count(D) * energy + self.alpha * square(offset);
        self.alpha * moves
    }
}
