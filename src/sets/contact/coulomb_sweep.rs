//! The impulse of one contact by Coulomb's law while the others are held, the step of a Gauss-Seidel sweep.
//!
//! A contact is solved exactly while the others are held. With `u` the velocity that they leave,
//! it is open if `u_N >= 0`; else `u_N` becomes 0, and `u_T = -λ r_T` with `λ = 0` if that keeps
//! the impulse in the cone, or the `λ > 0` that puts it on the boundary. With `r_N` eliminated, `S` the
//! Schur complement of `W_ii` and `b = W_TN u_N / W_NN - u_T`,
//!
//! `r_T = (S + λI)⁻¹ b`, `r_N = -(u_N + W_NT r_T) / W_NN`.
//!
//! A contact of up to three rows without a `λ` from an earlier sweep is first tried with less work: it sticks if
//! `r - W_ii⁻¹ u`, where `u` is the velocity that it has now, lies in the cone.
//!
//! The convex relaxation has a law of its own, [`super::relaxed_sweep`].
//!
//! Sweeps converge slowly if contacts have more rows than dofs. A cold solve then guesses first
//! ([`crate::solver::initial_guess`]), if sticking is likely.

use crate::linalg::blocks::product;
use crate::linalg::vector::{at_least, square};
use crate::real::Real;
use crate::sets::contact::ContactSet;
use crate::sets::contact::local::Local;
use crate::sets::contact::several_tangents;

/// The impulse of one contact while the others are held, with the `λ` of the last sweep.
#[inline(always)]
#[allow(clippy::inline_always)] // its small arrays would go through memory, and be waited for
pub(in crate::sets) fn solve_local<T: Real, const D: usize>(
    local: &Local<'_, T, D>,
    multiplier: &mut T,
) -> [T; D] {
    // One row alone is as simple to push, and what slips goes on slipping.
    let mu = local.set.cone.friction();
    if D > 1
        && *multiplier == T::ZERO
        && let Some(sticking) = stick(local, mu)
    {
        return sticking;
    }
    let mut left = local.u;
    for (left, own) in left.iter_mut().zip(&local.own) {
        *left -= product(own, &local.r);
    }
    push(&local.own, &left, mu, multiplier).unwrap_or([T::ZERO; D])
}

/// Square of what a sweep leaves of a contact's law (N·s), to first order the natural map, from its velocity and impulse after the
/// sweep and its `λ`.
///
/// A contact that slips had `u_N = 0` and `u_T = -λ r_T` when it was solved. Along its impulse another slip velocity asks for no
/// other impulse; across it asks for `1 / (1 + alpha λ)` as much as where it sticks.
#[inline]
pub(in crate::sets) fn residual<T: Real, const D: usize>(
    set: &ContactSet<T, D>,
    u: &[T; D],
    r: &[T; D],
    multiplier: T,
) -> T {
    let (Some((&u_n, u_t)), Some((&r_n, r_t))) = (u.split_first(), r.split_first()) else {
        return T::ZERO;
    };
    let alpha = set.alpha;
    if r_n == T::ZERO {
        let closing = alpha * u_n.min(T::ZERO);
        return closing * closing;
    }
    let (mut slip, mut along, mut size) = (T::ZERO, T::ZERO, T::ZERO);
    for (&u, &r) in u_t.iter().zip(r_t) {
        let left = u + multiplier * r;
        slip += left * left;
        along += left * r;
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
    let holds = if mu > T::ZERO { slip } else { T::ZERO };
    alpha * alpha * (u_n * u_n + (T::ONE + mu * mu) * holds)
}

/// A contact that wedges itself would push without bound. An impulse above this many times the frictionless one is
/// rejected.
const WEDGED: f64 = 1e3;

/// The impulse with which a contact sticks; `None` if that is not inside the cone, or wedged, or `W_ii` has no inverse to be
/// trusted.
#[inline(always)]
#[allow(clippy::inline_always)] // as above
fn stick<T: Real, const D: usize>(local: &Local<'_, T, D>, mu: T) -> Option<[T; D]> {
    let mut impulse = local.r;
    for (impulse, mass) in impulse.iter_mut().zip(local.mass) {
        *impulse -= product(mass, &local.u);
    }
    let (&normal, tangents) = impulse.split_first()?;
    let row = local.own.first()?;
    let (bound, approach) = (mu * normal, *local.u.first()? - product(row, &local.r));
    let holds = normal > T::ZERO
        && square(tangents) < bound * bound // not where both vanish or overflow
        && normal * *row.first()? < -approach * T::literal(WEDGED)
        && *local.mass.first()?.first()? > T::ZERO;
    holds.then_some(impulse)
}

/// Impulse of one contact, from `W_ii` and the velocity `u` that the others leave; `None` if it separates. If friction
/// wedges the contact, so that no impulse obeys the law, the impulse is that without friction.
#[inline(always)]
#[allow(clippy::inline_always)] // its small arrays would go through memory, and be waited for
fn push<T: Real, const D: usize>(
    own: &[[T; D]; D],
    u: &[T; D],
    mu: T,
    multiplier: &mut T,
) -> Option<[T; D]> {
    let (approach, inertia) = (*u.first()?, *own.first()?.first()?);
    let closed = approach < T::ZERO && inertia > T::ZERO;
    if !closed {
        return None;
    }
    let compliance = T::ONE / inertia;
    let smooth = -approach * compliance;
    if D > 3 && mu > T::ZERO {
        let bounded = |impulse: &[T; D]| {
            let normal = impulse.first().copied().unwrap_or(T::ZERO);
            normal > T::ZERO && normal < smooth * T::literal(WEDGED)
        };
        let rubbing = several_tangents::push(own, u, mu, multiplier).filter(bounded);
        return rubbing.or_else(|| {
            let mut impulse = [T::ZERO; D];
            *impulse.first_mut()? = smooth;
            Some(impulse)
        });
    }
    let rubbing = match D {
        2 if mu > T::ZERO => one_tangent(own, u, mu),
        3 if mu > T::ZERO => two_tangents(own, u, mu, compliance, multiplier),
        _ => None,
    };
    let bounded = |&(normal, _): &(T, _)| normal > T::ZERO && normal < smooth * T::literal(WEDGED);
    let (normal, tangents) = rubbing.filter(bounded).unwrap_or((smooth, [T::ZERO; 2]));
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

/// `S_kk`, at least a trusted share of `W_kk`, so that a row that nothing moves has a pivot, too.
#[inline]
fn pivot<T: Real>(own: T, through: T, inertia: T) -> T {
    let size = if own > T::ZERO { own } else { inertia };
    at_least(own - through, floor::<T>() * size)
}

/// `r_N` and `r_T`; a contact slips one way or the other, `r_T = ±mu r_N`.
#[inline]
fn one_tangent<T: Real, const D: usize>(
    own: &[[T; D]; D],
    u: &[T; D],
    mu: T,
) -> Option<(T, [T; 2])> {
    let w = |i: usize, j: usize| own.get(i)?.get(j).copied();
    let (approach, inertia, coupling) = (*u.first()?, w(0, 0)?, w(1, 0)?);
    let share = coupling / inertia;
    let b = share * approach - *u.get(1)?;
    let tangent = b / pivot(w(1, 1)?, share * coupling, inertia);
    let normal = -(approach + coupling * tangent) / inertia;
    if tangent.abs() <= mu * normal {
        return Some((normal, [tangent, T::ZERO]));
    }
    let slope = if b < T::ZERO { -mu } else { mu };
    let normal = -approach / (inertia + slope * coupling);
    Some((normal, [slope * normal, T::ZERO]))
}

/// Accuracies of the equation for `λ`: the gap between `(mu r_N)²` and `|r_T|²`, relative to `|r_T|²`, after a step of Newton's
/// method at least. 2e-5 from a fresh guess, and 2e-3 from the last sweep's `λ`, since the other contacts are then farther from their
/// end.
const NEAR: [f64; 2] = [2e-5, 2e-3];

/// A gap, relative to `|r_T|²`, below which a step of Newton's method needs no root.
const CLOSE: f64 = 0.5;

/// `r_N` and `r_T`. If the contact slips, they follow from its `λ`, which starts at the last guess, or at a fresh one if
/// there is none, and is replaced by the next guess.
///
/// With `δ = det(S + λI)` and `c = adj(S) b` it is `δ r_T = c + λ b`, and `δ mu r_N` a quadratic function
/// of `λ`. The ratio of `mu r_N` to `|r_T|` is nearly linear in `λ`: few steps of Newton's method find
/// where it is 1. Until it is near it is kept between
/// bounds, and at the last the impulse is put onto the cone.
#[inline(always)]
#[allow(clippy::inline_always)] // as above
fn two_tangents<T: Real, const D: usize>(
    own: &[[T; D]; D],
    u: &[T; D],
    mu: T,
    compliance: T,
    multiplier: &mut T,
) -> Option<(T, [T; 2])> {
    let w = |i: usize, j: usize| own.get(i)?.get(j).copied();
    let (approach, inertia) = (*u.first()?, w(0, 0)?);
    let coupling = [w(1, 0)?, w(2, 0)?];
    let share = coupling.map(|w| w * compliance);
    let ([x, y], [share_x, share_y]) = (coupling, share);
    let b = [
        share_x * approach - *u.get(1)?,
        share_y * approach - *u.get(2)?,
    ];
    let first = pivot(w(1, 1)?, share_x * x, inertia);
    let second = pivot(w(2, 2)?, share_y * y, inertia);
    let mixed = w(1, 2)? - share_x * y;
    let (trace, straight) = (first + second, first * second);
    let det = at_least(straight - mixed * mixed, floor::<T>() * straight);
    let c = [second * b[0] - mixed * b[1], first * b[1] - mixed * b[0]];
    // δ mu r_N = constant + λ (linear + λ square)
    let scale = -mu * compliance;
    let constant = scale * (approach * det + product(&coupling, &c));
    let linear = scale * (approach * trace + product(&coupling, &b));
    let square = scale * approach;
    let (cc, bc, bb) = (product(&c, &c), product(&b, &c), product(&b, &b));
    // The tangential part `c + λ b` is made so many times as long.
    let at = |lambda: T, normal: T, stretch: T| {
        let volume = det + lambda * (trace + lambda);
        let divided = T::ONE / (mu * volume);
        let (normal, fit) = (normal * divided, stretch * mu * divided);
        let tangents = [(c[0] + lambda * b[0]) * fit, (c[1] + lambda * b[1]) * fit];
        let finite = (tangents[0] + tangents[1]).is_finite();
        finite.then_some((normal, tangents))
    };
    if constant >= T::ZERO && cc <= constant * constant {
        *multiplier = T::ZERO;
        return at(T::ZERO, constant, T::ONE);
    }
    let [near, mut enough] = NEAR.map(T::literal);
    if *multiplier == T::ZERO || !multiplier.is_finite() {
        enough = near;
        // Somewhat less than what it would be if `S` were isotropic and no tangential impulse changed
        // the normal one: from below Newton's method gets there.
        let guess = bb.square_root() / square - trace;
        let usable = guess > T::ZERO && guess.is_finite();
        *multiplier = if usable { guess } else { T::ZERO };
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
            // `normal / √squares` to a part of `(gap / squares)³ / 32`. For a root a desktop would wait, and a
            // microcontroller would compute it.
            let three = T::literal(3.0);
            let stretch = (three * bound + squares) / (bound + three * squares);
            return at(lambda, normal, stretch);
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
            // A step may be out of bounds by what rounding left of it.
            _ if inside || is_within(near) && newton > T::ZERO => newton,
            Some(high) => (low + high) * T::literal(0.5),
            None => (lambda + trace) * T::literal(2.0),
        };
        if normal > T::ZERO {
            last = Some((lambda, normal, squares));
        }
    }
    last.and_then(|(lambda, normal, squares)| at(lambda, normal, normal / squares.square_root()))
}

#[cfg(test)]
mod tests;
