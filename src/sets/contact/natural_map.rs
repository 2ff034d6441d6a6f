//! The error a solution is judged by; [`crate::problem::judge::rounding`] bounds what rounding may hide of it.
//!
//! `error = max(|r - Π_K(r - alpha û)| / max(|r|, |r0|, |stop|), |M v - M v_free - Hᵀ r| / max(|M v_free|, |M v|, |Hᵀ r|))`
//! with `û_i = u_i + mu_i |u_Ti| e_N`, `u = H v + w`, `q = H v_free + w`, `alpha_i = D / trace(W_ii)` and two impulses
//! (N·s): `r0_i = Π_K(-alpha_i q̂_i)`, that of contact `i` if it were alone, and
//! `stop_i = alpha_i (abs(H_i) abs(v_free) + abs(w_i)) / 100`, entry by entry, in which a positive `w_N` (gap) counts as 0.
//!
//! It is the natural-map residual of FCLIB and Siconos made independent of units and relative to impulses: a fast slide or
//! a far gap does not loosen it. If bodies that touch fall together, `q` is rounding alone, and the reference is 1 % of the
//! impulse that would stop them. 0/0 counts as 0. Sums are of squares, with one root at the end.

use crate::cone::{add_to_normal, split};
use crate::linalg::vector::{larger, norm, quotient, root_sum, square, unit, zeros};
use crate::real::Real;
use crate::sets::ContactSet;
use crate::solution::ContactMode;
use nalgebra::SVector;

/// Argument `r - alpha û` of the natural map of one contact.
#[inline]
fn argument<T: Real, const D: usize>(
    set: &ContactSet<T, D>,
    u: &SVector<T, D>,
    r: &SVector<T, D>,
) -> SVector<T, D> {
    r - set.augmented(u) * set.alpha
}

/// What rounding may add to the natural map of a contact that slips, over its impulse: half an `eps` for each of the twenty
/// operations on its way, counted in [`crate::guide::error`].
const SLIP_ROUNDING: f64 = 10.0;

/// Where the argument of the natural map is projected onto the boundary of `K`.
pub(crate) struct Boundary<T> {
    /// `|alpha u_T|` and `|z_T|`
    speed: T,
    length: T,
    /// The normal impulse there.
    normal: T,
}

impl<T: Real> Boundary<T> {
    /// A bound on how fast the natural map changes with `alpha u_T`: along a fast slide `d` hardly changes, and across it `z_T` turns
    /// little.
    fn change<const D: usize>(&self, set: &ContactSet<T, D>, r: &SVector<T, D>) -> T {
        let mu = set.cone.friction();
        let any = T::ONE + mu;
        if set.shift_factor != mu || self.speed == T::ZERO {
            return any;
        }
        let turn = norm(split(r).1) / self.speed + self.normal / self.length;
        any.min((mu + mu) * turn)
    }
}

/// Natural map of one contact, `r - Π_K(z)` with `z = r - alpha û` (N·s), from `r` and `alpha u`.
///
/// On the boundary the normal impulse is `(z_N + mu |z_T|) / (1 + mu²)`. During a fast slide that is a small difference of two
/// large numbers. With `d = |z_T| - alpha |u_T| = r_T · (z_T - alpha u_T) / (|z_T| + alpha |u_T|)` it is
/// `(r_N - alpha u_N + mu d) / (1 + mu²)`, which is rounded as impulses are.
pub(crate) fn natural_map<T: Real, const D: usize>(
    set: &ContactSet<T, D>,
    pushed: &SVector<T, D>,
    r: &SVector<T, D>,
) -> (SVector<T, D>, Option<Boundary<T>>) {
    let ((pushed_normal, pushed_tangent), (r_normal, r_tangent)) = (split(pushed), split(r));
    let (mu, speed) = (set.cone.friction(), norm(pushed_tangent));
    let mut push = *pushed;
    add_to_normal(&mut push, set.shift_factor * speed);
    let z = r - push;
    if set.cone.holds(&z) {
        return (push, None);
    }
    let tangent = split(&z).1;
    let length = norm(tangent);
    let pairs = r_tangent.iter().zip(tangent.iter().zip(pushed_tangent));
    let product = pairs.fold(T::ZERO, |sum, (&r, (&z, &u))| sum + r * (z - u));
    let mut difference = T::ZERO;
    if product != T::ZERO {
        difference = product / (length + speed);
    }
    let excess = (mu - set.shift_factor) * speed;
    let normal = (r_normal - pushed_normal + excess + mu * difference) * set.cone.shrink();
    if normal <= T::ZERO {
        return (*r, None);
    }
    let mut projection = zeros();
    if length > T::ZERO {
        projection = z * (mu * normal / length);
    }
    if let Some(first) = projection.as_mut_slice().first_mut() {
        *first = normal;
    }
    let boundary = Boundary {
        speed,
        length,
        normal,
    };
    (r - projection, Some(boundary))
}

/// The square of what normal and tangent leave apart, `r_N - max(0, r_N - alpha u_N)` and `r_T - Π(r_T - alpha u_T)` with the
/// projection onto the disc of `mu r_N` (Alart, Curnier 1991): Coulomb's law as well, in which no velocity is multiplied by `mu`.
#[cfg_attr(target_os = "none", inline(never))]
fn alart_curnier<T: Real, const D: usize>(
    set: &ContactSet<T, D>,
    u: &[T; D],
    r: &[T; D],
    unit: T,
) -> T {
    let r = SVector::from(*r) * unit;
    let pushed = SVector::from(*u) * (set.alpha * unit);
    let ((pushed_normal, pushed_tangent), (r_normal, r_tangent)) = (split(&pushed), split(&r));
    let normal = pushed_normal.min(r_normal);
    let grip = set.cone.friction() * r_normal;
    let (mut size, mut left) = (T::ZERO, T::ZERO);
    for (&r, &u) in r_tangent.iter().zip(pushed_tangent) {
        size += (r - u) * (r - u);
    }
    let length = size.square_root();
    let share = if length > grip { grip / length } else { T::ONE };
    for (&r, &u) in r_tangent.iter().zip(pushed_tangent) {
        let off = if length > grip {
            r - (r - u) * share
        } else {
            u
        };
        left += off * off;
    }
    normal * normal + left
}

/// What a contact does, read off the argument of the natural map.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn mode<T: Real, const D: usize>(
    set: &ContactSet<T, D>,
    u: &SVector<T, D>,
    r: &SVector<T, D>,
) -> ContactMode {
    if r.iter().all(|&r| r == T::ZERO) {
        ContactMode::Open
    } else if set.cone.is_interior(&argument(set, u, r)) {
        ContactMode::Stick
    } else {
        ContactMode::Slip
    }
}

/// A violation of more than this share of the expected impulses is an error, however large the impulses are.
const LARGEST_SHARE: f64 = 0.5;

/// Friction above which a violation is also measured with normal and tangent apart.
const LARGE_FRICTION: f64 = 10.0;

/// `|r0|`
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn r0_norm<T: Real, const D: usize>(sets: &[ContactSet<T, D>]) -> T {
    let mut largest = T::ZERO;
    for set in sets {
        largest = larger(largest, set.q.as_slice(), set.alpha);
    }
    let unit = unit(largest);
    let mut squares = T::ZERO;
    for set in sets {
        if separates(set, &set.q.into(), None) {
            continue; // without a root
        }
        let argument = -set.augmented(&(set.q * (set.alpha * unit)));
        squares += set.cone.projected_square(&argument);
    }
    squares.square_root() / unit
}

/// First part of the error, from `u = W r + q` or `u = H v + w`.
///
/// `size` is the larger of `|r0|` and `|stop|` (N·s), `carried` what [`carried_impulse`](super::expected::carried_impulse) gives. `noise[i]`: squares of bounds on the rounding of `u_i` and of `u_Ni`; added
/// unless the contact is open and separates faster. With bounds what rounding adds on the way is added as well.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn error<T: Real, const D: usize>(
    sets: &[ContactSet<T, D>],
    size: T,
    u: &[[T; D]],
    r: &[[T; D]],
    noise: &[[T; 2]],
    carried: &dyn Fn() -> T,
) -> T {
    let mut largest = size;
    // Beside a size that is not zero small impulses do not count, and the squares of such large
    // ones as overflow are an infinite error.
    if size == T::ZERO {
        for r in r.iter().take(sets.len()) {
            largest = larger(largest, r, T::ONE);
        }
    }
    let unit = unit(largest);
    let size = size * unit;
    let [mut residual, mut impulse, mut slipping, mut noises] = [T::ZERO; 4];
    let is_final = !noise.is_empty();
    let mut noise = noise.iter();
    for ((set, u), r) in sets.iter().zip(u).zip(r) {
        let noise = noise.next();
        if *r == [T::ZERO; D] && separates(set, u, noise) {
            continue; // without a root
        }
        let source = r;
        let r = SVector::from(*r) * unit;
        let pushed = SVector::from(*u) * (set.alpha * unit);
        let (left, mut slips) = natural_map(set, &pushed, &r);
        let mut left = square(left.as_slice());
        let own = square(r.as_slice());
        impulse += own;
        if slips.is_some() {
            slipping += own;
        }
        let mut reach = T::ONE + set.shift_factor;
        if D > 1 && set.shift_factor > T::literal(LARGE_FRICTION) {
            let apart = alart_curnier(set, u, source, unit);
            if apart < left {
                (left, reach, slips) = (apart, T::ONE, None);
            }
        }
        residual += left;
        if let Some(&[noise, normal]) = noise {
            let mut moved = reach * reach * noise;
            if let Some(boundary) = slips {
                let change = boundary.change(set, &r);
                // Of a sum of two the square is at most twice the sum of their squares.
                moved = moved.min((normal + change * change * noise) * T::literal(2.0));
            }
            let scale = set.alpha * unit;
            noises += scale * scale * moved;
        }
    }
    let expected = size * size;
    let size = impulse.max(expected);
    if residual == T::ZERO && noises == T::ZERO {
        return T::ZERO; // also if nothing moves and nothing pushes
    }
    let mut error = root_sum(residual, noises, size);
    if impulse > expected {
        let mut hidden = noises;
        if is_final {
            // What rounding hides counts as well. Of a sum of four the square is at most four times the sum of their squares.
            let slips = T::literal(SLIP_ROUNDING * SLIP_ROUNDING) * slipping;
            let rounding = (slips + T::literal(16.0) * impulse) * T::EPSILON * T::EPSILON;
            hidden = (noises + rounding) * T::literal(4.0);
        }
        // Of a sum of two it is at most twice that: few violations come near the share.
        if (residual + hidden) * T::literal(8.0) > expected {
            error = with_share(error, [residual, hidden], expected, &|| carried() * unit);
        }
    }
    if is_final && slipping > T::ZERO {
        let rounding = T::EPSILON * T::literal(SLIP_ROUNDING);
        return error + rounding * quotient(slipping, size).square_root();
    }
    error
}

/// An error, or by how much its violation exceeds [`LARGEST_SHARE`] of the expected impulses, up to 1, if that is more: impulses that
/// diverge would make any violation small.
#[cfg_attr(target_os = "none", inline(never))]
fn with_share<T: Real>(
    error: T,
    [residual, noises]: [T; 2],
    expected: T,
    carried: &dyn Fn() -> T,
) -> T {
    let mut left = residual;
    if noises > T::ZERO {
        left = (residual + noises) * T::literal(2.0); // at least the square of the sum of their roots
    }
    let reach = (T::ONE + error) * T::literal(LARGEST_SHARE);
    if error >= T::ONE || expected == T::ZERO || left <= reach * reach * expected {
        return error;
    }
    let carried = carried();
    let size = expected.max(carried * carried);
    let share = root_sum(residual, noises, size) / T::literal(LARGEST_SHARE);
    error.max((share - T::ONE).min(T::ONE))
}

/// Does a contact without impulse obey the law, with every velocity within the rounding bound, of which `noise` has the squares (m/s)²?
#[inline]
fn separates<T: Real, const D: usize>(
    set: &ContactSet<T, D>,
    u: &[T; D],
    noise: Option<&[T; 2]>,
) -> bool {
    let mu = set.cone.friction();
    let [normal, tangent @ ..] = u.as_slice() else {
        return false;
    };
    let mut margin = *normal;
    if set.shift_factor != mu {
        margin += (set.shift_factor - mu) * norm(tangent);
    }
    let reach = T::ONE + mu;
    margin >= T::ZERO
        && noise
            .is_none_or(|&[noise, _]| margin > T::ZERO && margin * margin > reach * reach * noise)
}

#[cfg(test)]
mod tests;
