//! The impulse of one contact by Coulomb's law while the others are held: one step of a Gauss-Seidel sweep.
//!
//! The free velocity `u` of a contact is its velocity without its impulse. The contact is open if `u_N >= 0`. Otherwise its normal
//! velocity becomes 0, and its tangential velocity `-λ r_T`. The slip multiplier `λ` is 0 if the impulse then lies in the cone: the
//! contact sticks. Otherwise it is the `λ > 0` that puts the impulse on the boundary. With the Schur complement `S` of the tangents
//! in the diagonal block `W_ii` of the Delassus operator and `b = W_TN u_N / W_NN - u_T`, the impulse is
//!
//! `r_T = (S + λI)⁻¹ b`, `r_N = -(u_N + W_NT r_T) / W_NN`.
//!
//! A contact of up to three rows whose last `λ` is 0 is first tried with less work: it sticks if `r - W_ii⁻¹ u` lies in the cone,
//! where `u` is its velocity with its present impulse `r`.
//!
//! [`super::relaxed_sweep`] is the same for the convex relaxation.
//!
//! Sweeps converge slowly if contacts have more rows than dofs. A cold solve then begins with a guess
//! (`src/solver/initial_guess.rs`), if sticking is likely.

use crate::linalg::blocks::product;
use crate::linalg::vector::{at_least, square};
use crate::real::Real;
use crate::sets::contact::ContactSet;
use crate::sets::contact::local::Local;
use crate::sets::contact::several_tangents;

/// The impulse of one contact while the others are held. `multiplier` is the `λ` of the last sweep, and becomes that of this one.
#[inline(always)]
#[allow(clippy::inline_always)] // a call would pass small arrays through memory, and wait for them
pub(in crate::sets) fn solve_local<T: Real, const D: usize>(
    local: &Local<'_, T, D>,
    multiplier: &mut T,
) -> [T; D] {
    // Not tried with one row, where `push` is as simple, nor after a slip: a contact that slipped in the last sweep mostly slips
    // again.
    let mu = local.set.cone.friction();
    if D > 1
        && *multiplier == T::ZERO
        && let Some(sticking) = stick(local, mu)
    {
        return sticking;
    }
    let mut free = local.u;
    for (free, row) in free.iter_mut().zip(&local.block) {
        *free -= product(row, &local.r);
    }
    push(&local.block, &free, mu, multiplier).unwrap_or([T::ZERO; D])
}

/// Square of the residual of Coulomb's law at one contact after a sweep (N²s²), an estimate of that of the natural map. (At a
/// contact that sticks it leaves out the term `2 mu u_N |u_T|`.)
///
/// `u`, `r` and `multiplier` are the velocity, impulse and `λ` after the sweep. A slipping contact had `u_N = 0` and `u_T = -λ r_T`
/// when it was solved; later contacts have changed its velocity since. A change of the slip velocity along `r_T` changes no impulse.
/// A change across `r_T` changes the impulse by `1 / (1 + alpha λ)` times as much as at a sticking contact.
#[inline]
pub(in crate::sets) fn residual_square<T: Real, const D: usize>(
    set: &ContactSet<T, D>,
    u: &[T; D],
    r: &[T; D],
    multiplier: T,
) -> T {
    let ([u_n, u_t @ ..], [r_n, r_t @ ..]) = (u.as_slice(), r.as_slice()) else {
        return T::ZERO;
    };
    let (u_n, r_n) = (*u_n, *r_n);
    let alpha = set.alpha;
    if r_n == T::ZERO {
        let closing = alpha * u_n.min(T::ZERO);
        return closing * closing;
    }
    let (mut slip, mut along, mut size) = (T::ZERO, T::ZERO, T::ZERO);
    for (&u, &r) in u_t.iter().zip(r_t) {
        let change = u + multiplier * r;
        slip += change * change;
        along += change * r;
        size += r * r;
    }
    let slides = multiplier > T::ZERO || along < T::ZERO && set.slips(r);
    if slides && size > T::ZERO {
        let mut across = T::ZERO;
        if D > 2 {
            let turn = T::ONE / (T::ONE + alpha * multiplier);
            across = (slip - along * along / size).max(T::ZERO) * (turn * turn);
        }
        return alpha * alpha * (set.cone.shrink() * u_n * u_n + across);
    }
    let mu = set.cone.friction();
    let held = if mu > T::ZERO { slip } else { T::ZERO };
    alpha * alpha * (u_n * u_n + (T::ONE + mu * mu) * held)
}

/// Largest trusted impulse over the frictionless one. A contact that wedges itself would push without bound.
const WEDGED: f64 = 1e3;

/// The impulse with which a contact sticks. `None` if it is not inside the cone, if the contact is wedged, or if `W_ii` is nearly
/// singular.
#[inline(always)]
#[allow(clippy::inline_always)] // as above
fn stick<T: Real, const D: usize>(local: &Local<'_, T, D>, mu: T) -> Option<[T; D]> {
    let mut impulse = local.r;
    for (impulse, mass) in impulse.iter_mut().zip(local.mass) {
        *impulse -= product(mass, &local.u);
    }
    let (&normal, tangents) = impulse.split_first()?;
    let row = local.block.first()?;
    let (bound, approach) = (mu * normal, *local.u.first()? - product(row, &local.r));
    let sticks = normal > T::ZERO
        && square(tangents) < bound * bound // not where both vanish or overflow
        && normal * *row.first()? < -approach * T::literal(WEDGED)
        && *local.mass.first()?.first()? > T::ZERO;
    sticks.then_some(impulse)
}

/// Impulse of one contact from `W_ii` and its free velocity `u`; `None` if the contact separates. If friction wedges the contact, so
/// that no impulse obeys the law, it is the impulse without friction.
#[inline(always)]
#[allow(clippy::inline_always)] // as above
fn push<T: Real, const D: usize>(
    block: &[[T; D]; D],
    u: &[T; D],
    mu: T,
    multiplier: &mut T,
) -> Option<[T; D]> {
    let (approach, inverse_mass) = (*u.first()?, *block.first()?.first()?);
    let closed = approach < T::ZERO && inverse_mass > T::ZERO;
    if !closed {
        return None;
    }
    let mass = T::ONE / inverse_mass;
    let frictionless = -approach * mass;
    if D > 3 && mu > T::ZERO {
        let bounded = |impulse: &[T; D]| {
            let normal = impulse.first().copied().unwrap_or(T::ZERO);
            normal > T::ZERO && normal < frictionless * T::literal(WEDGED)
        };
        let rubbing = several_tangents::push(block, u, mu, multiplier).filter(bounded);
        return rubbing.or_else(|| {
            let mut impulse = [T::ZERO; D];
            *impulse.first_mut()? = frictionless;
            Some(impulse)
        });
    }
    let rubbing = match D {
        2 if mu > T::ZERO => one_tangent(block, u, mu),
        3 if mu > T::ZERO => {
            SlipEquation::new(block, u, mu, mass).and_then(|equation| equation.solve(multiplier))
        }
        _ => None,
    };
    let bounded = |&(normal, _): &(T, _)| normal > T::ZERO && normal < frictionless * T::literal(WEDGED);
    let (normal, tangents) = rubbing.filter(bounded).unwrap_or((frictionless, [T::ZERO; 2]));
    let mut impulse = [T::ZERO; D];
    *impulse.first_mut()? = normal;
    for (impulse, tangent) in impulse.iter_mut().skip(1).zip(tangents) {
        *impulse = tangent;
    }
    Some(impulse)
}

/// Smallest trusted difference, relative to its terms.
fn floor<T: Real>() -> T {
    T::EPSILON * T::literal(64.0)
}

/// `S_kk = W_kk - W_kN² / W_NN`, at least a trusted share of `W_kk`. So a row that nothing moves has a pivot, too.
#[inline]
fn pivot<T: Real>(entry: T, through_normal: T, inverse_mass: T) -> T {
    let size = if entry > T::ZERO { entry } else { inverse_mass };
    at_least(entry - through_normal, floor::<T>() * size)
}

/// `r_N` and `r_T` of a planar contact. A slipping contact has `r_T = ±mu r_N`.
#[inline]
fn one_tangent<T: Real, const D: usize>(block: &[[T; D]; D], u: &[T; D], mu: T) -> Option<(T, [T; 2])> {
    let w = |i: usize, j: usize| block.get(i)?.get(j).copied();
    let (approach, inverse_mass, coupling) = (*u.first()?, w(0, 0)?, w(1, 0)?);
    let share = coupling / inverse_mass;
    let b = share * approach - *u.get(1)?;
    let tangent = b / pivot(w(1, 1)?, share * coupling, inverse_mass);
    let normal = -(approach + coupling * tangent) / inverse_mass;
    if tangent.abs() <= mu * normal {
        return Some((normal, [tangent, T::ZERO]));
    }
    let slope = if b < T::ZERO { -mu } else { mu };
    let normal = -approach / (inverse_mass + slope * coupling);
    Some((normal, [slope * normal, T::ZERO]))
}

/// Accuracies of the equation for `λ`: the gap between `(mu r_N)²` and `|r_T|²`, relative to `|r_T|²`, after at least one step of
/// Newton's method. The first holds from a fresh guess. The second holds from the `λ` of the last sweep: the other contacts still
/// move by more than that.
const NEAR: [f64; 2] = [2e-5, 2e-3];

/// Gap, relative to `|r_T|²`, below which a step of Newton's method needs no root.
const CLOSE: f64 = 0.5;

/// The equation `mu r_N = |r_T|` for the slip multiplier `λ` of a spatial contact.
///
/// With `Δ = det(S + λI)` and `c = adj(S) b` the impulse is `Δ r_T = c + λ b` and `Δ mu r_N = constant + λ (linear + λ square)`.
/// The ratio of `mu r_N` to `|r_T|` is nearly linear in `λ`, so few steps of Newton's method find the `λ` at which it is 1.
struct SlipEquation<T> {
    mu: T,
    /// `trace(S)` and `det(S)`
    trace: T,
    det: T,
    b: [T; 2],
    c: [T; 2],
    constant: T,
    linear: T,
    square: T,
    /// `|c|²`, `b · c` and `|b|²`
    cc: T,
    bc: T,
    bb: T,
}

impl<T: Real> SlipEquation<T> {
    #[inline(always)]
    #[allow(clippy::inline_always)] // as above
    fn new<const D: usize>(block: &[[T; D]; D], u: &[T; D], mu: T, mass: T) -> Option<Self> {
        let w = |i: usize, j: usize| block.get(i)?.get(j).copied();
        let (approach, inverse_mass) = (*u.first()?, w(0, 0)?);
        let coupling = [w(1, 0)?, w(2, 0)?];
        let share = coupling.map(|w| w * mass);
        let ([x, y], [share_x, share_y]) = (coupling, share);
        let b = [share_x * approach - *u.get(1)?, share_y * approach - *u.get(2)?];
        let first = pivot(w(1, 1)?, share_x * x, inverse_mass);
        let second = pivot(w(2, 2)?, share_y * y, inverse_mass);
        let mixed = w(1, 2)? - share_x * y;
        let (trace, straight) = (first + second, first * second);
        let det = at_least(straight - mixed * mixed, floor::<T>() * straight);
        let c = [second * b[0] - mixed * b[1], first * b[1] - mixed * b[0]];
        let scale = -mu * mass;
        Some(Self {
            mu,
            trace,
            det,
            b,
            c,
            constant: scale * (approach * det + product(&coupling, &c)),
            linear: scale * (approach * trace + product(&coupling, &b)),
            square: scale * approach,
            cc: product(&c, &c),
            bc: product(&b, &c),
            bb: product(&b, &b),
        })
    }

    /// `r_N` and `r_T` at a `λ`, from `normal = Δ mu r_N` and with `r_T` stretched; `None` if they are not finite.
    #[inline(always)]
    #[allow(clippy::inline_always)] // as above
    fn impulse(&self, lambda: T, normal: T, stretch: T) -> Option<(T, [T; 2])> {
        let (b, c) = (self.b, self.c);
        let volume = self.det + lambda * (self.trace + lambda);
        let divided = T::ONE / (self.mu * volume);
        let (normal, fit) = (normal * divided, stretch * self.mu * divided);
        let tangents = [(c[0] + lambda * b[0]) * fit, (c[1] + lambda * b[1]) * fit];
        let finite = (tangents[0] + tangents[1]).is_finite();
        finite.then_some((normal, tangents))
    }

    /// At most the `λ` of an isotropic `S` without coupling: Newton's method converges from below.
    #[inline(always)]
    #[allow(clippy::inline_always)] // as above
    fn guess(&self) -> T {
        let guess = self.bb.square_root() / self.square - self.trace;
        let usable = guess > T::ZERO && guess.is_finite();
        if usable { guess } else { T::ZERO }
    }

    /// `r_N` and `r_T` of a contact that sticks, or else slips. Newton's method for `λ` starts at `multiplier`, or at a fresh guess if
    /// that is 0, and writes the next guess there. Far from the solution `λ` is kept between bounds. At the end the impulse is put onto
    /// the cone.
    #[inline(always)]
    #[allow(clippy::inline_always)] // as above
    fn solve(&self, multiplier: &mut T) -> Option<(T, [T; 2])> {
        let Self { trace, constant, linear, square, cc, bc, bb, .. } = *self;
        if constant >= T::ZERO && cc <= constant * constant {
            *multiplier = T::ZERO;
            return self.impulse(T::ZERO, constant, T::ONE);
        }
        let [near, mut enough] = NEAR.map(T::literal);
        if *multiplier == T::ZERO || !multiplier.is_finite() {
            enough = near;
            *multiplier = self.guess();
        }
        let mut last = None;
        let (mut low, mut high) = (T::ZERO, None);
        for step in 0..8 {
            let lambda = *multiplier;
            let normal = constant + lambda * (linear + lambda * square);
            let squares = cc + lambda * (bc + bc + lambda * bb);
            let bound = normal * normal;
            let gap = bound - squares;
            let is_within = |share: T| normal > T::ZERO && gap.abs() <= share * squares;
            if step > 0 && is_within(enough) {
                // `normal / √squares` up to a relative error of `(gap / squares)³ / 32`, without a root.
                let three = T::literal(3.0);
                let stretch = (three * bound + squares) / (bound + three * squares);
                return self.impulse(lambda, normal, stretch);
            }
            let turn = (linear + (lambda + lambda) * square) * squares - normal * (bc + lambda * bb);
            // `(normal - √squares) squares / turn`
            let change = if is_within(T::literal(CLOSE)) {
                let twice = normal + normal;
                gap / (twice * twice - gap) * twice * (squares / turn) // no product that may vanish
            } else {
                (normal - squares.square_root()) * (squares / turn)
            };
            let newton = lambda - change;
            let too_high = normal > T::ZERO && gap >= T::ZERO;
            if too_high {
                high = Some(lambda);
            } else {
                low = lambda;
            }
            let inside = newton > low && high.is_none_or(|high| newton < high);
            *multiplier = match high {
                // Near the solution rounding may put a step out of bounds.
                _ if inside || is_within(near) && newton > T::ZERO => newton,
                Some(high) => (low + high) * T::literal(0.5),
                None => (lambda + trace) * T::literal(2.0),
            };
            if normal > T::ZERO {
                last = Some((lambda, normal, squares));
            }
        }
        let (lambda, normal, squares) = last?;
        self.impulse(lambda, normal, normal / squares.square_root())
    }
}

#[cfg(test)]
mod tests;
