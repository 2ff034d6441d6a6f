//! What a solve asks of a contact: its cone, the De Saxcé shift, and in the files beside it the same of each method.

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

/// One contact in a solve, in rows that are scaled so that its cone is round.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactSet<T: Real, const D: usize> {
    /// Factor of the De Saxcé shift: `mu_i`, or 0 in the convex relaxation.
    pub(crate) shift_factor: T,
    /// The cone `K` the impulse lies in.
    pub(crate) cone: FrictionCone<T>,
    /// Step `alpha_i` (kg) of the natural map, see [`crate::Factor`]'s `natural_map_step`.
    pub(crate) alpha: T,
    /// `q_i = H_i v_free + w_i`.
    pub(crate) q: SVector<T, D>,
    /// The constant term of `u = W r + base`: `q`; or `w`, where the free motion is among what impulses do
    /// ([`crate::problem::Problem::velocities`]); with corrections of what rounding took away.
    pub(crate) base: SVector<T, D>,
}

impl<T: Real, const D: usize> ContactSet<T, D> {
    /// A place that is not used.
    pub(super) const fn none() -> Self {
        Self {
            shift_factor: T::ZERO,
            cone: FrictionCone::frictionless(),
            alpha: T::ZERO,
            q: zeros(),
            base: zeros(),
        }
    }

    /// That of a contact, with the step `alpha_i` and `q_i`.
    #[inline]
    pub(crate) fn new<const N: usize>(
        contact: &Contact<T, N, D>,
        model: Model,
        alpha: T,
        q: SVector<T, D>,
    ) -> Self {
        let mu = contact.mu;
        Self {
            shift_factor: match model {
                Model::Coulomb => mu,
                Model::ConvexRelaxation => T::ZERO,
            },
            cone: FrictionCone::new(mu).unwrap_or(FrictionCone::frictionless()),
            alpha,
            q,
            base: q,
        }
    }

    /// Rows along which it may push.
    pub(crate) fn pushing_rows(&self) -> usize {
        if self.cone.friction() > T::ZERO { D } else { 1 }
    }

    /// Does an impulse lie on the boundary of a cone with friction?
    pub(crate) fn slips(&self, r: &[T; D]) -> bool {
        let (normal, tangent) = (
            r.first().copied().unwrap_or(T::ZERO),
            r.get(1..).unwrap_or_default(),
        );
        let grip = self.cone.friction() * normal;
        grip > T::ZERO && square(tangent) > grip * grip * T::literal(0.999)
    }

    /// `alpha |q|²` over some rows.
    #[inline]
    pub(crate) fn energy(&self, rows: usize) -> T {
        let rows = self.q.iter().take(rows);
        self.alpha * rows.fold(T::ZERO, |sum, &q| sum + q * q)
    }

    /// `|r0_i|² / alpha_i`, with the impulse `r0_i = Π_K(-alpha_i q̂_i)` that it would take alone, with velocities in a unit.
    pub(crate) fn alone_energy(&self, unit: T) -> T {
        let argument = -self.augmented(&(self.q * unit));
        self.cone.projected_square(&argument) * self.alpha
    }

    /// Does nothing move it, although it asks for another velocity than this one?
    pub(crate) fn is_immovable_and_violated(&self, u: &SVector<T, D>) -> bool {
        self.alpha <= T::ZERO && self.is_violated(u)
    }

    /// Does it ask for another velocity than this one?
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

    /// The trace of `W_ii`; 0 if nothing moves it.
    pub(crate) fn inverse_mass(&self) -> T {
        if self.alpha > T::ZERO {
            T::count(D) / self.alpha
        } else {
            T::ZERO
        }
    }

    /// An upper bound on its part of `|stop|²`, up to a constant factor, with the free motion's `v·M v`.
    pub(crate) fn stopping_bound(&self, offset: &[T; D], energy: T) -> T {
        let moves = T::count(D) * energy + self.alpha * square(offset);
        self.alpha * moves
    }
}
