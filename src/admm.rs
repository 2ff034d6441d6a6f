//! One iteration of the alternating direction method of multipliers, and its three accelerations.
//!
//! Names follow the note: `u` is `ũ`, `zeta` is `ζ`, a `_hat` is the extrapolated value. What the
//! note misprints is put right (Goldstein, O'Donoghue, Setzer, Baraniuk 2014, Alg. 8): step 2
//! starts from `û` where it prints `ũ`, and steps 6-8 extrapolate from the new iterate,
//! `ûᵏ⁺¹ = ũᵏ⁺¹ + c (ũᵏ⁺¹ - ũᵏ)` where they print `ûᵏ + …`.

use crate::cone::{add_to_normal, norm, split};
use crate::contact_space::ContactVector;
use crate::problem::Problem;
use crate::resolvent::Resolvent;
use crate::{Real, SlipUpdate};
use nalgebra::SVector;

/// The iterate of one contact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Iterate<T, const D: usize> {
    pub(crate) u: SVector<T, D>,
    pub(crate) zeta: SVector<T, D>,
    /// `rho_i`
    penalty: T,
    u_hat: SVector<T, D>,
    zeta_hat: SVector<T, D>,
    /// `s`: the tangential speed in `b(s)`.
    pub(crate) slip: T,
}

impl<T: Real, const D: usize> Iterate<T, D> {
    /// An iterate without momentum, at a velocity `ũ` and an impulse `r = -rho ζ`.
    pub(crate) fn at(u: SVector<T, D>, r: SVector<T, D>, penalty: T) -> Self {
        let zeta = r / -penalty;
        let (_, tangent) = split(&u);
        Self {
            u,
            zeta,
            penalty,
            u_hat: u,
            zeta_hat: zeta,
            slip: norm(tangent),
        }
    }

    /// `r = -rho ζ`
    pub(crate) fn impulse(&self) -> SVector<T, D> {
        self.zeta * -self.penalty
    }

    /// `s = |ũ_T|`, for the outer loop.
    pub(crate) fn update_slip(&mut self) {
        let (_, tangent) = split(&self.u);
        self.slip = norm(tangent);
    }
}

/// How far one iteration moved.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change<T> {
    /// `rho |ζᵏ⁺¹ - ζ̂ᵏ|²`; with `dual` the `e_k` of the note.
    pub(crate) primal: T,
    /// `rho |ũᵏ⁺¹ - ûᵏ|²`
    pub(crate) dual: T,
    /// Square of an estimate of what is left of the natural map, N²s².
    pub(crate) error: T,
    /// `|rᵏ⁺¹|²`
    pub(crate) impulse: T,
}

/// How the next iterate is extrapolated: `û = ũ + c (ũ - ũ_previous)`, and `ζ` likewise.
pub(crate) trait Acceleration<T> {
    /// The state before the first iteration.
    const START: Self;

    /// The factor `c` after an iteration with the residual `e_k`.
    fn momentum(&mut self, residual: T) -> T;
}

/// ADMM without extrapolation.
pub(crate) struct Plain;

/// Algorithm 1: Nesterov's sequence, `tau` of step 5.
pub(crate) struct Fast<T> {
    tau: T,
}

/// Algorithm 2: the sequence starts again when the residual `e_k` has not decreased.
pub(crate) struct Restart<T> {
    fast: Fast<T>,
    /// `e_{k-1}`; none before the first iteration.
    residual: Option<T>,
}

impl<T: Real> Acceleration<T> for Plain {
    const START: Self = Self;

    #[inline]
    fn momentum(&mut self, _: T) -> T {
        T::ZERO
    }
}

impl<T: Real> Acceleration<T> for Fast<T> {
    const START: Self = Self { tau: T::ONE };

    #[inline]
    fn momentum(&mut self, _: T) -> T {
        let two = T::ONE + T::ONE;
        let next = (T::ONE + (T::ONE + two * two * self.tau * self.tau).square_root()) / two;
        let momentum = (self.tau - T::ONE) / next;
        self.tau = next;
        momentum
    }
}

impl<T: Real> Acceleration<T> for Restart<T> {
    const START: Self = Self {
        fast: Fast { tau: T::ONE },
        residual: None,
    };

    #[inline]
    fn momentum(&mut self, residual: T) -> T {
        let eta = T::literal(0.999);
        let momentum = match self.residual {
            Some(previous) if residual >= eta * previous => {
                // Steps 10-13, but from the current iterate and with its own e_k: the note goes
                // back to the previous iterate and sets e_k = e_{k-1} / eta.
                self.fast.tau = T::ONE;
                T::ZERO
            }
            _ => self.fast.momentum(residual),
        };
        self.residual = Some(residual);
        momentum
    }
}

/// Steps 2-4 and the extrapolation, for all contacts.
#[inline]
pub(crate) fn iterate<T: Real, A, const N: usize, const D: usize, const C: usize>(
    problem: &Problem<'_, T, N, D, C>,
    resolvent: &Resolvent<T, D, C>,
    iterates: &mut [Iterate<T, D>; C],
    acceleration: &mut A,
) -> Change<T>
where
    A: Acceleration<T>,
{
    let laws = problem.laws();
    let mut rhs: ContactVector<T, D, C> = [[T::ZERO; D]; C];
    let mut product: ContactVector<T, D, C> = [[T::ZERO; D]; C];

    // q + S + ζ̂ - û
    let pairs = laws.iter().zip(iterates.iter());
    for (rhs, (law, iterate)) in rhs.iter_mut().zip(pairs) {
        let mut velocity = law.free + iterate.zeta_hat - iterate.u_hat;
        add_to_normal(&mut velocity, law.lift * iterate.slip);
        *rhs = velocity.into();
    }
    let contacts = ..laws.len();
    let targets = product.get_mut(contacts).unwrap_or_default();
    resolvent.times(rhs.get(contacts).unwrap_or_default(), targets);

    let mut change = Change {
        primal: T::ZERO,
        dual: T::ZERO,
        error: T::ZERO,
        impulse: T::ZERO,
    };
    let pairs = laws.iter().zip(iterates.iter_mut());
    for (product, (law, iterate)) in product.iter().zip(pairs) {
        // H v + b + ζ̂ = û + B (q + S + ζ̂ - û)
        let z = iterate.u_hat + SVector::from(*product);
        let (u, speed) = law.cone.dual().project_with_length(&z);
        let zeta = z - u;

        let mut primal = zeta - iterate.zeta_hat;
        let dual = u - iterate.u_hat;
        let dual2 = dual.norm_squared();
        let rho = iterate.penalty;
        change.primal += rho * primal.norm_squared();
        change.dual += rho * dual2;
        if problem.slip == SlipUpdate::EveryIteration {
            add_to_normal(&mut primal, law.lift * (speed - iterate.slip));
        }
        change.error += law.step * law.step * primal.norm_squared() + rho * rho * dual2;
        change.impulse += rho * rho * zeta.norm_squared();

        if problem.slip == SlipUpdate::EveryIteration {
            iterate.slip = speed;
        }
        // The old values move to the `_hat`s, to be extrapolated once `c` is known.
        iterate.u_hat = iterate.u;
        iterate.zeta_hat = iterate.zeta;
        iterate.u = u;
        iterate.zeta = zeta;
    }

    let c = acceleration.momentum(change.primal + change.dual);
    for iterate in iterates.iter_mut().take(laws.len()) {
        iterate.u_hat = iterate.u + (iterate.u - iterate.u_hat) * c;
        iterate.zeta_hat = iterate.zeta + (iterate.zeta - iterate.zeta_hat) * c;
    }
    change
}

#[cfg(test)]
mod tests;
