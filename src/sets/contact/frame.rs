//! The mode of a contact at a point of Newton's method, and its linearised equations.

use crate::cone::{add_to_normal, split};
use crate::linalg::blocks::{product, row_times};
use crate::linalg::vector::norm;
use crate::linalg::zip::{zip3, zip4};
use crate::real::Real;
use crate::sets::ContactSet;
use crate::sets::assembly::Linear;
use nalgebra::SVector;

/// The mode of a contact at a point, with the derivative `DP` of the projection `P = Π_{K*}(z)` there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// No impulse: `DP = I`.
    Open,
    /// `DP = 0`
    Stick,
    /// `z` is projected onto the boundary of `K*`.
    Slip,
    /// Pushes without friction: `K*` is a half-space.
    Frictionless,
}

impl Kind {
    /// The mode of a contact with this projection `P` and impulse `r`.
    pub(crate) fn of<T: Real, const D: usize>(
        set: &ContactSet<T, D>,
        velocity: &SVector<T, D>,
        r: &[T; D],
    ) -> Self {
        if *r == [T::ZERO; D] {
            Self::Open
        } else if set.cone.friction() == T::ZERO {
            Self::Frictionless
        } else if velocity.iter().all(|&u| u == T::ZERO) {
            Self::Stick
        } else {
            Self::Slip
        }
    }
}

/// Linearised equations of a contact, in a frame in which most of them decouple.
///
/// The step `d` of a slipping contact is
///
/// `d = a p + b k + Σ_j c_j τ_j`
///
/// with the friction coefficient `mu`, the boundary ray `p = (mu, e)` of `K*`, the ray `k = (-1, mu e)` of `-K`, and the tangents
/// `τ_j` across the sliding direction `e`. The derivative of the projection acts on them as
///
/// - `DP p = p`: `a` changes no impulse, except by the damping `δ`, which is neglected;
/// - `DP k = 0`: `b` is an unknown;
/// - `DP τ_j = turn τ_j` with `turn = |P_T| / |z_T|`: each `c_j` is an unknown.
///
/// The unknowns of all contacts cause the impulses `x`. Then two scalar equations remain, one along `e` and one along the normal:
///
/// - `(1 + δ) a + δ mu b + e·W x = e·E`, which gives `a`;
/// - `(mu - mu_i) a + δ (mu a - b) + (W x)_N = E_N`, with the factor `mu_i` of the De Saxcé shift, 0 in the convex relaxation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame<T: Real, const D: usize> {
    pub(crate) kind: Kind,
    /// `e` of a contact that slips or is open, with normal component 0; zero if its tangential velocity is zero.
    direction: [T; D],
    /// `|P_T| / |z_T|` of a slipping contact.
    pub(crate) turn: T,
    /// Multiple of the tangential equation (along `e`) of a slipping contact, subtracted from the normal one to eliminate `a`.
    pub(crate) skew: T,
    /// `δ mu` of a slipping contact.
    pub(crate) tilt: T,
    /// `δ` of the tangential rows of a sticking contact.
    pub(crate) tangential_damping: T,
    /// `1 / (alpha (1 + δ))` of a contact that sticks or has no friction. Its unknowns are impulses, and `d = step_per_impulse × unknown`.
    pub(crate) step_per_impulse: T,
    /// Impulses of a slipping contact by unknown: entry 0 is `alpha (I - DP + δI) k`, entry `j` is `alpha (I - DP + δI) τ_j`.
    pushes: [[T; D]; D],
    /// Equations of a slipping contact: entry `k` has the factors with which equation `k` sums the rows of the contact.
    equations: [[T; D]; D],
}

impl<T: Real, const D: usize> Frame<T, D> {
    /// The frame of an unused contact.
    pub(crate) const fn none() -> Self {
        Self {
            kind: Kind::Open,
            direction: [T::ZERO; D],
            turn: T::ZERO,
            skew: T::ZERO,
            tangential_damping: T::ZERO,
            tilt: T::ZERO,
            step_per_impulse: T::ZERO,
            pushes: [[T::ZERO; D]; D],
            equations: [[T::ZERO; D]; D],
        }
    }

    /// Number of unknowns.
    pub(crate) fn count(&self) -> usize {
        match self.kind {
            Kind::Open => 0,
            Kind::Frictionless => 1,
            Kind::Slip => D - 1,
            Kind::Stick => D,
        }
    }

    /// Linearises a contact at `z`, with the damping `δ` of Levenberg and Marquardt.
    pub(crate) fn set(&mut self, set: &ContactSet<T, D>, kind: Kind, z: &SVector<T, D>, damping: T) {
        self.kind = kind;
        let alpha = set.alpha;
        let along = alpha * (T::ONE + damping);
        if matches!(kind, Kind::Stick | Kind::Frictionless) {
            self.step_per_impulse = T::ONE / along;
            return;
        }
        let (normal, tangent) = split(z);
        let length = norm(tangent);
        self.direction = [T::ZERO; D];
        if length > T::ZERO {
            self.direction = (*z * (T::ONE / length)).into();
        }
        if let Some(first) = self.direction.first_mut() {
            *first = T::ZERO;
        }
        if kind == Kind::Slip {
            self.turn = set.cone.dual().along(normal, length) / length;
            let mu = set.cone.friction();
            self.skew = (mu - set.shift_factor + damping * mu) / (T::ONE + damping);
            self.tilt = damping * mu;
            let across = alpha * (T::ONE - self.turn + damping);
            self.set_slip(set, along, across);
        }
    }

    /// Sets the columns of the unknowns along `k` and the `τ_j`. The `τ_j` are the columns, but for the first, of the Householder
    /// reflection that takes the first tangent to `±e`.
    fn set_slip(&mut self, set: &ContactSet<T, D>, along: T, across: T) {
        let mu = set.cone.friction();
        let e = self.direction;
        let first = e.get(1).copied().unwrap_or(T::ZERO);
        let sign = if first < T::ZERO { -T::ONE } else { T::ONE };
        let factor = T::ONE / (T::ONE + first.abs());
        for (j, push, equation) in zip3(0..D, &mut self.pushes, &mut self.equations) {
            let Some(&other) = e.get(j + 1) else { break };
            for (k, push, equation, &e) in zip4(0..D, push, equation, &e) {
                (*push, *equation) = match (j, k) {
                    (0, 0) => (-along, T::ONE),
                    (0, _) => (along * mu * e, -self.skew * e),
                    (_, 0) => (T::ZERO, T::ZERO),
                    _ => {
                        let reflected = if k == 1 { e + sign } else { e };
                        let unit = if k == j + 1 { T::ONE } else { T::ZERO };
                        let across_e = unit - factor * other * reflected;
                        (across_e * across, across_e)
                    }
                };
            }
        }
    }

    /// The right-hand sides of the contact's equations.
    pub(crate) fn right_sides(&self, residual: &[T; D]) -> [T; D] {
        if self.kind == Kind::Slip {
            self.equations.each_ref().map(|equation| product(equation, residual))
        } else {
            *residual
        }
    }

    /// The impulse that belongs to the unknowns.
    pub(crate) fn impulse(&self, unknowns: &[T]) -> [T; D] {
        let mut push = [T::ZERO; D];
        if self.kind == Kind::Slip {
            for (&unknown, column) in unknowns.iter().zip(&self.pushes) {
                for (push, &column) in push.iter_mut().zip(column) {
                    *push += unknown * column;
                }
            }
        } else {
            for (push, &unknown) in push.iter_mut().zip(unknowns) {
                *push = unknown;
            }
        }
        push
    }

    /// The step `d` of this contact, from its unknowns and the residual `E - W x` of its equations. `undamped` is `1 / (1 + δ)`.
    pub(crate) fn step(
        &self,
        set: &ContactSet<T, D>,
        unknowns: &[T],
        residual: SVector<T, D>,
        undamped: T,
    ) -> SVector<T, D> {
        let direction = SVector::from(self.direction);
        let mut step = residual * undamped;
        match self.kind {
            Kind::Stick | Kind::Frictionless => {
                for (step, &unknown) in step.iter_mut().zip(unknowns) {
                    *step = unknown * self.step_per_impulse;
                }
            }
            Kind::Open => {
                let slip = set.shift_factor * direction.dot(&step);
                add_to_normal(&mut step, slip * undamped);
            }
            Kind::Slip => {
                let mu = set.cone.friction();
                let mut unknowns = unknowns.iter();
                let along = unknowns.next().copied().unwrap_or(T::ZERO);
                let ahead = direction.dot(&step) - self.tilt * along * undamped;
                step = direction * (ahead + mu * along);
                add_to_normal(&mut step, mu * ahead - along);
                for (&across, equation) in unknowns.zip(self.equations.iter().skip(1)) {
                    step += SVector::from(*equation) * across;
                }
            }
        }
        step
    }
}

/// A frame with the damping `δ` of its equations.
pub(crate) struct Damped<'a, T: Real, const D: usize> {
    pub(crate) frame: &'a Frame<T, D>,
    pub(crate) damping: T,
}

impl<T: Real, const D: usize> Linear<T, D> for Damped<'_, T, D> {
    fn count(&self) -> usize {
        self.frame.count()
    }

    #[inline]
    fn tested(&self, velocities: &[T; D]) -> [T; D] {
        let frame = self.frame;
        if frame.kind == Kind::Slip {
            return frame.equations.each_ref().map(|equation| product(velocities, equation));
        }
        let mut entries = *velocities;
        if frame.kind == Kind::Frictionless {
            for entry in entries.iter_mut().skip(1) {
                *entry = T::ZERO;
            }
        }
        entries
    }

    #[inline]
    fn pushed<const L: usize>(&self, k: usize, velocities: &[[T; L]; D]) -> [T; L] {
        match self.frame.pushes.get(k) {
            Some(push) if self.frame.kind == Kind::Slip => row_times(push, velocities),
            _ => velocities.get(k).copied().unwrap_or([T::ZERO; L]),
        }
    }

    /// Adds damping and the derivatives of the projection.
    #[inline]
    fn add_own(&self, k: usize, entries: &mut [T; D]) {
        let (frame, damping) = (self.frame, self.damping);
        let own = match (frame.kind, k) {
            (Kind::Slip, 0) => -damping - frame.skew * frame.tilt,
            (Kind::Slip, _) => frame.turn + damping,
            (Kind::Stick, 1..) => frame.tangential_damping * frame.step_per_impulse,
            _ => damping * frame.step_per_impulse,
        };
        if let Some(entry) = entries.get_mut(k) {
            *entry += own;
        }
    }
}
