//! The law of a contact in contact space.

use crate::cone::{add_to_normal, norm, split, square};
use crate::laws::{Coulomb, Laws, Room};
use crate::problem::row_laws::RowLaws;
use crate::solution::zeros;
use crate::{Contact, FrictionCone, Model, Real};
use nalgebra::SVector;

/// The data of one contact in a solve, besides the factor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactLaw<T: Real, const D: usize, L: Laws = Coulomb> {
    /// Factor of the De Saxcé shift: `mu_i`, or 0 in the convex relaxation.
    pub(crate) shift_factor: T,
    /// The cone `K` the impulse lies in.
    pub(crate) cone: FrictionCone<T>,
    /// Step `alpha_i` (kg) of the natural map, see [`crate::Factor`]'s `natural_map_step`.
    pub(crate) alpha: T,
    /// `q_i = H_i v_free + w_i`.
    pub(crate) q: SVector<T, D>,
    /// What is added to velocities of impulses: `q`, or `w` where the free motion is among them
    /// ([`crate::problem::Problem::velocities`]); with corrections of what rounding took away.
    pub(crate) base: SVector<T, D>,
    /// Of a slot of joint rows: their laws, in place of the cone.
    pub(crate) rows: L::Room<RowLaws<T, D>>,
}

impl<T: Real, const D: usize, L: Laws> ContactLaw<T, D, L> {
    /// A place that is not used.
    pub(super) const fn none() -> Self {
        Self {
            shift_factor: T::ZERO,
            cone: FrictionCone::frictionless(),
            alpha: T::ZERO,
            q: zeros(),
            base: zeros(),
            rows: L::Room::EMPTY,
        }
    }

    /// The law of a contact, with the step `alpha_i` and the velocity `H_i v_free`.
    #[inline]
    pub(super) fn new<const N: usize>(
        contact: &Contact<T, N, D>,
        model: Model,
        alpha: T,
        moved: SVector<T, D>,
    ) -> Self {
        let (mu, q) = (contact.mu, contact.offset + moved);
        Self {
            shift_factor: match model {
                Model::Coulomb => mu,
                Model::ConvexRelaxation => T::ZERO,
            },
            cone: FrictionCone::new(mu).unwrap_or(FrictionCone::frictionless()),
            alpha,
            q,
            base: q,
            rows: L::Room::EMPTY,
        }
    }

    /// Rows along which it may push.
    pub(crate) fn rows(&self) -> usize {
        if let Some(rows) = self.rows.get() {
            return rows.count();
        }
        if self.cone.friction() > T::ZERO { D } else { 1 }
    }

    /// Its impulses that do work.
    #[inline]
    pub(crate) fn working(&self, r: [T; D]) -> [T; D] {
        match self.rows.get() {
            Some(rows) => rows.working(r),
            None => r,
        }
    }

    /// The nearest impulse that the law allows.
    #[inline]
    pub(crate) fn project(&self, r: &SVector<T, D>) -> SVector<T, D> {
        match self.rows.get() {
            Some(rows) => rows.project(r),
            None => self.cone.nearest(r),
        }
    }

    /// `alpha |q|²` over some rows; of joint rows `|Π(-alpha q)|² / alpha`, in which open stops do not count.
    #[inline]
    pub(crate) fn energy(&self, rows: usize) -> T {
        if let Some(rows) = self.rows.get() {
            let push = rows.project(&(-self.q * self.alpha));
            return square(push.as_slice()) / self.alpha;
        }
        let rows = self.q.iter().take(rows);
        self.alpha * rows.fold(T::ZERO, |sum, &q| sum + q * q)
    }

    /// Does nothing move it, although it asks for another velocity than this one?
    pub(crate) fn is_hopeless_at(&self, u: &SVector<T, D>) -> bool {
        if self.alpha > T::ZERO {
            return false;
        }
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
}
