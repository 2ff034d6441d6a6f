//! One iteration of ADMM and its acceleration.
//!
//! Names follow [the note](crate::guide::note): `u` is `ũ`, `zeta` is `ζ`, and a `_hat` marks the extrapolated value. Two misprints of
//! the note are corrected after Goldstein, O'Donoghue, Setzer and Baraniuk (2014, Alg. 8). Step 2 starts from `û`; the note prints `ũ`.
//! Steps 6-8 extrapolate from the new iterate, `ûᵏ⁺¹ = ũᵏ⁺¹ + c (ũᵏ⁺¹ - ũᵏ)`; the note prints `ûᵏ + …`.

use crate::admm::{Acceleration, SlipUpdate};
use crate::cone::{add_to_normal, split};
use crate::factor::resolvent::Resolvent;
use crate::linalg::blocks::ContactVector;
use crate::linalg::vector::{norm, square, zeros};
use crate::linalg::zip::zip3;
use crate::real::Real;
use crate::sets::ContactSet;
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
    /// The iterate of an unused contact.
    pub(crate) const fn none() -> Self {
        Self { u: zeros(), zeta: zeros(), penalty: T::ZERO, u_hat: zeros(), zeta_hat: zeros(), slip: T::ZERO }
    }

    /// The iterate with the velocity `ũ` and the impulse `r = -rho ζ`, with extrapolated values equal to them.
    pub(crate) fn at(u: SVector<T, D>, r: SVector<T, D>, penalty: T) -> Self {
        let zeta = r / -penalty;
        let (_, tangent) = split(&u);
        Self { u, zeta, penalty, u_hat: u, zeta_hat: zeta, slip: norm(tangent) }
    }

    /// `r = -rho ζ`
    pub(crate) fn impulse(&self) -> SVector<T, D> {
        self.zeta * -self.penalty
    }

    /// Sets `s = |ũ_T|`, for [`SlipUpdate::OuterLoop`].
    pub(crate) fn update_slip(&mut self) {
        let (_, tangent) = split(&self.u);
        self.slip = norm(tangent);
    }
}

/// Norms of the change in one iteration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change<T> {
    /// `rho |ζᵏ⁺¹ - ζ̂ᵏ|²`; with `dual` the `e_k` of the note.
    pub(crate) primal: T,
    /// `rho |ũᵏ⁺¹ - ûᵏ|²`
    pub(crate) dual: T,
    /// Estimate of the square of the natural map's residual (N²s²).
    pub(crate) error: T,
    /// `|rᵏ⁺¹|²`
    pub(crate) impulse: T,
}

/// The sequence of extrapolation factors `c`.
#[derive(Clone, Debug)]
pub(crate) struct Extrapolation<T> {
    acceleration: Acceleration,
    /// `tau` of step 5.
    tau: T,
    /// `e_{k-1}`; `None` before the first iteration.
    residual: Option<T>,
}

impl<T: Real> Extrapolation<T> {
    /// The sequence of a solver that has solved nothing yet.
    pub(crate) const fn none(acceleration: Acceleration) -> Self {
        Self { acceleration, tau: T::ZERO, residual: None }
    }

    /// Starts the sequence, or starts it again.
    pub(crate) fn start(&mut self) {
        self.tau = T::ONE;
        self.residual = None;
    }

    /// The factor `c` after an iteration with the residual `e_k`.
    #[inline]
    fn factor(&mut self, residual: T) -> T {
        let eta = T::literal(0.999);
        let last = self.residual.replace(residual);
        let restarts = match self.acceleration {
            Acceleration::Plain => return T::ZERO,
            Acceleration::Nesterov => false,
            // Steps 10-13, except that the sequence starts again at the current iterate, with its `e_k`. The note takes the previous
            // iterate, and `e_k = e_{k-1} / eta`.
            Acceleration::Restart => last.is_some_and(|last| residual >= eta * last),
        };
        if restarts {
            self.tau = T::ONE;
            return T::ZERO;
        }
        let two = T::ONE + T::ONE;
        let next = (T::ONE + (T::ONE + two * two * self.tau * self.tau).square_root()) / two;
        let factor = (self.tau - T::ONE) / next;
        self.tau = next;
        factor
    }
}

/// One iteration over all contacts: steps 2-4 and the extrapolation.
#[inline(never)]
pub(crate) fn iterate<T: Real, const D: usize, const C: usize>(
    sets: &[ContactSet<T, D>],
    resolvent: &Resolvent<T, D, C>,
    iterates: &mut [Iterate<T, D>; C],
    extrapolation: &mut Extrapolation<T>,
    slip_update: SlipUpdate,
) -> Change<T> {
    // Ones, since zeros would call memset; all entries in use are overwritten.
    let mut rhs: ContactVector<T, D, C> = [[T::ONE; D]; C];
    let mut product: ContactVector<T, D, C> = [[T::ONE; D]; C];
    let contacts = ..sets.len();
    let iterates = iterates.get_mut(contacts).unwrap_or_default();
    let rhs = rhs.get_mut(contacts).unwrap_or_default();
    let product = product.get_mut(contacts).unwrap_or_default();

    right_hand_side(sets, iterates, rhs);
    resolvent.times(rhs, product);
    let change = project(sets, slip_update, iterates, product);
    let residual = change.primal + change.dual;
    extrapolate(iterates, extrapolation.factor(residual));
    change
}

/// Fills `rhs` with `q + S + ζ̂ - û`, the argument of the resolvent `B` in step 2.
#[inline]
fn right_hand_side<T: Real, const D: usize>(
    sets: &[ContactSet<T, D>],
    iterates: &[Iterate<T, D>],
    rhs: &mut [[T; D]],
) {
    for (rhs, set, iterate) in zip3(rhs, sets, iterates) {
        let mut velocity = set.base + iterate.zeta_hat - iterate.u_hat;
        add_to_normal(&mut velocity, set.shift_factor * iterate.slip);
        *rhs = velocity.into();
    }
}

/// Steps 3 and 4: the next `ũ` and `ζ` from `product = B (q + S + ζ̂ - û)`. The last ones move to `u_hat` and `zeta_hat`, for
/// [`extrapolate`].
#[inline]
fn project<T: Real, const D: usize>(
    sets: &[ContactSet<T, D>],
    slip_update: SlipUpdate,
    iterates: &mut [Iterate<T, D>],
    product: &[[T; D]],
) -> Change<T> {
    let mut change = Change { primal: T::ZERO, dual: T::ZERO, error: T::ZERO, impulse: T::ZERO };
    for (product, set, iterate) in zip3(product, sets, iterates) {
        // H v + b + ζ̂ = û + B (q + S + ζ̂ - û)
        let z = iterate.u_hat + SVector::from(*product);
        let (u, speed) = set.cone.dual().project_with_length(&z);
        let zeta = z - u;

        let mut primal = zeta - iterate.zeta_hat;
        let dual = square((u - iterate.u_hat).as_slice());
        let rho = iterate.penalty;
        change.primal += rho * square(primal.as_slice());
        change.dual += rho * dual;
        if slip_update == SlipUpdate::EveryIteration {
            add_to_normal(&mut primal, set.shift_factor * (speed - iterate.slip));
            iterate.slip = speed;
        }
        let rho2 = rho * rho;
        change.error += set.alpha * set.alpha * square(primal.as_slice()) + rho2 * dual;
        change.impulse += rho2 * square(zeta.as_slice());

        iterate.u_hat = iterate.u;
        iterate.zeta_hat = iterate.zeta;
        iterate.u = u;
        iterate.zeta = zeta;
    }
    change
}

/// `û = ũ + c (ũ - ũ_previous)`, and `ζ` likewise.
#[inline]
fn extrapolate<T: Real, const D: usize>(iterates: &mut [Iterate<T, D>], c: T) {
    for iterate in iterates {
        iterate.u_hat = iterate.u + (iterate.u - iterate.u_hat) * c;
        iterate.zeta_hat = iterate.zeta + (iterate.zeta - iterate.zeta_hat) * c;
    }
}

#[cfg(test)]
mod tests;
