//! What a contact does at a point, and how it answers to first order.

use crate::Real;
use crate::cone::{add_to_normal, norm, split};
use crate::contact_space::product;
use crate::problem::Law;
use nalgebra::SVector;

/// What a contact does at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// `DP = I`
    Open,
    /// `DP = 0`
    Stick,
    Slip,
    /// Pushes without friction: `K*` is a half-space.
    Smooth,
}

impl Kind {
    pub(crate) fn of<T: Real, const D: usize>(
        law: &Law<T, D>,
        velocity: &SVector<T, D>,
        r: &[T; D],
    ) -> Self {
        if *r == [T::ZERO; D] {
            Self::Open
        } else if law.cone.friction() == T::ZERO {
            Self::Smooth
        } else if velocity.iter().all(|&u| u == T::ZERO) {
            Self::Stick
        } else {
            Self::Slip
        }
    }
}

/// How a contact answers to first order.
///
/// Its step is `d = a p + b k + Σ c_j τ_j` with the boundary ray `p = (mu, e)` of `K*`, the ray
/// `k = (-1, mu e)` of `-K`, and the tangents `τ_j` across the sliding direction `e`. `DP` keeps
/// `p`, drops `k` and shrinks the `τ_j` to `turn = |P_T| / |z_T|`. So `a` moves no impulse but by
/// `λ`, which is neglected, and follows from the equation along `e`, in which `DS` has no part,
/// `(1 + λ) a + λ mu b + e·W x = e·E`. The normal one has `(mu - mu_i) a + λ (mu a - b)` with the
/// `mu_i` of `DS`, which is 0 in the convex relaxation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame<T, const D: usize> {
    pub(crate) kind: Kind,
    /// `e`, without a normal component; zero where nothing slides.
    direction: [T; D],
    pub(crate) turn: T,
    /// What of the equation along `e` is taken from the normal one, so that `a` leaves it.
    pub(crate) skew: T,
    /// `λ mu`
    pub(crate) tilt: T,
    /// What each unknown adds to `rho (I - DP + λI) d`.
    pub(crate) pushes: [[T; D]; D],
    /// Which combination of its rows each equation is.
    pub(crate) tests: [[T; D]; D],
}

impl<T: Real, const D: usize> Frame<T, D> {
    /// What stands in a place that is not used.
    pub(crate) const fn none() -> Self {
        Self {
            kind: Kind::Open,
            direction: [T::ZERO; D],
            turn: T::ZERO,
            skew: T::ZERO,
            tilt: T::ZERO,
            pushes: [[T::ZERO; D]; D],
            tests: [[T::ZERO; D]; D],
        }
    }

    /// Number of unknowns.
    pub(crate) fn count(&self) -> usize {
        match self.kind {
            Kind::Open => 0,
            Kind::Smooth => 1,
            Kind::Slip => D - 1,
            Kind::Stick => D,
        }
    }

    #[inline(never)]
    pub(crate) fn set(
        &mut self,
        law: &Law<T, D>,
        kind: Kind,
        z: &SVector<T, D>,
        rho: T,
        regularisation: T,
    ) {
        *self = Self::none();
        self.kind = kind;
        let (normal, tangent) = split(z);
        let along = rho * (T::ONE + regularisation);
        if matches!(kind, Kind::Open | Kind::Slip) {
            let length = norm(tangent);
            if length > T::ZERO {
                self.direction = (*z * (T::ONE / length)).into();
            }
            if let Some(first) = self.direction.first_mut() {
                *first = T::ZERO;
            }
            if kind == Kind::Slip {
                self.turn = law.cone.dual().along(normal, length) / length;
                let mu = law.cone.friction();
                self.skew = (mu - law.lift + regularisation * mu) / (T::ONE + regularisation);
                self.tilt = regularisation * mu;
                self.set_slip(law, along, rho * (T::ONE - self.turn + regularisation));
            }
        } else {
            for (k, (push, test)) in self.pushes.iter_mut().zip(&mut self.tests).enumerate() {
                if let (Some(push), Some(test)) = (push.get_mut(k), test.get_mut(k)) {
                    (*push, *test) = (along, T::ONE);
                }
            }
        }
    }

    /// Unknowns along `k` and the `τ_j`: the columns, but for the first, of the reflection that
    /// takes the first tangent to `±e`.
    fn set_slip(&mut self, law: &Law<T, D>, along: T, across: T) {
        let mu = law.cone.friction();
        let e = self.direction;
        let first = e.get(1).copied().unwrap_or(T::ZERO);
        let sign = if first < T::ZERO { -T::ONE } else { T::ONE };
        let factor = T::ONE / (T::ONE + first.abs());
        for (j, (push, test)) in self.pushes.iter_mut().zip(&mut self.tests).enumerate() {
            let Some(&other) = e.get(j + 1) else { break };
            for (k, ((push, test), &e)) in push.iter_mut().zip(test).zip(&e).enumerate() {
                (*push, *test) = match (j, k) {
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

    /// `source` times what the unknowns push.
    #[inline]
    pub(crate) fn columns(&self, source: &[T; D]) -> [T; D] {
        let mut entries = *source;
        if self.kind == Kind::Slip {
            for (entry, push) in entries.iter_mut().zip(&self.pushes) {
                *entry = product(source, push);
            }
        } else {
            for (k, (entry, push)) in entries.iter_mut().zip(&self.pushes).enumerate() {
                let used = k < self.count();
                let push = push.get(k).copied().unwrap_or(T::ZERO);
                *entry = if used { *entry * push } else { T::ZERO };
            }
        }
        entries
    }

    /// The step of this contact, from its unknowns and what they leave of its equations.
    pub(crate) fn step(
        &self,
        law: &Law<T, D>,
        unknowns: &[T],
        left: SVector<T, D>,
        damping: T,
    ) -> SVector<T, D> {
        let direction = SVector::from(self.direction);
        let mut step = left * damping;
        match self.kind {
            Kind::Stick | Kind::Smooth => {
                for (step, &unknown) in step.iter_mut().zip(unknowns) {
                    *step = unknown;
                }
            }
            Kind::Open => {
                let slip = law.lift * direction.dot(&step);
                add_to_normal(&mut step, slip * damping);
            }
            Kind::Slip => {
                let mu = law.cone.friction();
                let mut unknowns = unknowns.iter();
                let along = unknowns.next().copied().unwrap_or(T::ZERO);
                let ahead = direction.dot(&step) - self.tilt * along * damping;
                step = direction * (ahead + mu * along);
                add_to_normal(&mut step, mu * ahead - along);
                for (&across, test) in unknowns.zip(self.tests.iter().skip(1)) {
                    step += SVector::from(*test) * across;
                }
            }
        }
        step
    }
}
