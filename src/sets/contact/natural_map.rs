//! The first part of the error, by how much contacts violate Coulomb's law:
//! `|r - Π_K(r - alpha û)| / max(|r|, |r0|, |stop|)`.
//!
//! [`crate::guide::error`] defines its terms. [`crate::problem::judge`] computes the second part, the momentum, and bounds the
//! rounding of both. Sums are of squares, with one root at the end.

use crate::cone::{add_to_normal, split};
use crate::linalg::vector::{larger, norm, quotient, root_sum, square, unit, zeros};
use crate::linalg::zip::zip3;
use crate::real::Real;
use crate::sets::ContactSet;
use crate::solution::ContactMode;
use nalgebra::SVector;

/// Rounding of the natural map of a slipping contact, over its impulse and `eps`: 1/2 for each of the twenty operations counted in
/// [`crate::guide::error`].
const SLIP_ROUNDING: f64 = 10.0;

/// Residual of the natural map of one contact.
pub(crate) struct Residual<T, const D: usize> {
    /// `r - Π_K(z)` (N·s)
    pub(crate) value: SVector<T, D>,
    /// `None` if `z` lies in `K` or is projected onto 0.
    boundary: Option<Boundary<T>>,
}

/// Projection of the argument `z` of the natural map onto the boundary of `K`.
struct Boundary<T> {
    /// `|alpha u_T|`
    speed: T,
    /// `|z_T|`
    length: T,
    /// Normal component of the projection.
    normal: T,
}

impl<T: Real> Boundary<T> {
    /// A bound on the derivative of the natural map by `alpha u_T`. It is small in a fast slide: `d` of [`contact_residual`] hardly changes
    /// along the slide, and `z_T` turns little across it.
    fn sensitivity<const D: usize>(&self, set: &ContactSet<T, D>, r: &SVector<T, D>) -> T {
        let mu = set.cone.friction();
        let any = T::ONE + mu;
        if set.shift_factor != mu || self.speed == T::ZERO {
            return any;
        }
        let turn = norm(split(r).1) / self.speed + self.normal / self.length;
        any.min((mu + mu) * turn)
    }
}

/// Residual `r - Π_K(z)` of the natural map of one contact, with `z = r - alpha û` (N·s), from `r` and `alpha_u`.
///
/// On the boundary the normal impulse is `(z_N + mu |z_T|) / (1 + mu²)`. During a fast slide that is a small difference of two
/// large numbers. With `d = |z_T| - alpha |u_T| = r_T · (z_T - alpha u_T) / (|z_T| + alpha |u_T|)` it is
/// `(r_N - alpha u_N + mu d) / (1 + mu²)` by Coulomb's law, a sum of numbers of the size of impulses. (In the relaxation
/// `mu alpha |u_T|` is added to the numerator.)
pub(crate) fn contact_residual<T: Real, const D: usize>(
    set: &ContactSet<T, D>,
    alpha_u: &SVector<T, D>,
    r: &SVector<T, D>,
) -> Residual<T, D> {
    let (u_normal, u_tangent) = split(alpha_u);
    let (r_normal, r_tangent) = split(r);
    let (mu, speed) = (set.cone.friction(), norm(u_tangent));
    let mut augmented = *alpha_u;
    add_to_normal(&mut augmented, set.shift_factor * speed);
    let z = r - augmented;
    let off_boundary = |value| Residual { value, boundary: None };
    if set.cone.has(&z) {
        return off_boundary(augmented);
    }
    let tangent = split(&z).1;
    let length = norm(tangent);
    let entries = zip3(r_tangent, tangent, u_tangent);
    let product = entries.fold(T::ZERO, |sum, (&r, &z, &u)| sum + r * (z - u));
    let mut difference = T::ZERO;
    if product != T::ZERO {
        difference = product / (length + speed);
    }
    let excess = (mu - set.shift_factor) * speed;
    let normal = (r_normal - u_normal + excess + mu * difference) * set.cone.shrink();
    if normal <= T::ZERO {
        return off_boundary(*r);
    }
    let mut projection = zeros();
    if length > T::ZERO {
        projection = z * (mu * normal / length);
    }
    if let Some(first) = projection.as_mut_slice().first_mut() {
        *first = normal;
    }
    Residual { value: r - projection, boundary: Some(Boundary { speed, length, normal }) }
}

/// Square of the residual of Alart and Curnier (1991): `r_N - max(0, r_N - alpha u_N)` and `r_T - Π(r_T - alpha u_T)`, with the
/// projection onto the disc of radius `mu r_N`. It vanishes under Coulomb's law, too, and multiplies no velocity by `mu`.
#[cfg_attr(target_os = "none", inline(never))]
fn alart_curnier_square<T: Real, const D: usize>(
    set: &ContactSet<T, D>,
    u: &[T; D],
    r: &[T; D],
    unit: T,
) -> T {
    let r = SVector::from(*r) * unit;
    let alpha_u = SVector::from(*u) * (set.alpha * unit);
    let (u_normal, u_tangent) = split(&alpha_u);
    let (r_normal, r_tangent) = split(&r);
    let normal = u_normal.min(r_normal);
    let grip = set.cone.friction() * r_normal;
    let (mut argument, mut tangential) = (T::ZERO, T::ZERO);
    for (&r, &u) in r_tangent.iter().zip(u_tangent) {
        argument += (r - u) * (r - u);
    }
    let length = argument.square_root();
    let share = if length > grip { grip / length } else { T::ONE };
    for (&r, &u) in r_tangent.iter().zip(u_tangent) {
        let residual = if length > grip { r - (r - u) * share } else { u };
        tangential += residual * residual;
    }
    normal * normal + tangential
}

/// The mode of a contact. It slips if it moves along its tangents faster than `still`, and if more than the impulse `noise` would stop it.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn mode<T: Real, const D: usize>(
    set: &ContactSet<T, D>,
    (u, r): (&[T; D], &[T; D]),
    (noise, still): (T, T),
) -> ContactMode {
    if *r == [T::ZERO; D] {
        return ContactMode::Open;
    }
    let speed = norm(u.get(1..).unwrap_or_default());
    let slips = speed > still && set.alpha * speed > noise;
    if slips { ContactMode::Slip } else { ContactMode::Stick }
}

/// Residual as a share of the expected impulses, above which it is an error however large the impulses are.
const LARGEST_SHARE: f64 = 0.5;

/// Friction coefficient above which the residual of Alart and Curnier is computed, too.
const LARGE_FRICTION: f64 = 10.0;

/// `|r0|` (N·s), the norm of the impulses of contacts, each as if it were alone.
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
            continue; // saves a root
        }
        let argument = -set.augmented(&(set.q * (set.alpha * unit)));
        squares += set.cone.projected_square(&argument);
    }
    squares.square_root() / unit
}

/// First part of the error, from `u = W r + q` or `u = H v + w`.
///
/// - `size`: the larger of `|r0|` and `|stop|` (N·s).
/// - `noise[i]`: squares of bounds on the rounding of `u_i` and of `u_Ni`, added to the residual unless the contact is open and
///   separates faster. If there are any, the rounding of the natural map is added as well.
/// - `carried`: computes the result of [`carried_impulse`](crate::Scene::carried_impulse) (N·s).
pub(crate) fn error<T: Real, const D: usize>(
    sets: &[ContactSet<T, D>],
    size: T,
    u: &[[T; D]],
    r: &[[T; D]],
    noise: &[[T; 2]],
    carried: &dyn Fn() -> T,
) -> T {
    let mut largest = size;
    // If the size is not zero, it is the unit: squares of small impulses may vanish, and an overflow is an infinite error.
    if size == T::ZERO {
        for r in r.iter().take(sets.len()) {
            largest = larger(largest, r, T::ONE);
        }
    }
    let unit = unit(largest);
    let size = size * unit;
    let mut sums = Sums::zero(unit);
    let is_final = !noise.is_empty();
    let mut noise = noise.iter();
    for (set, u, r) in zip3(sets, u, r) {
        let noise = noise.next();
        if *r == [T::ZERO; D] && separates(set, u, noise) {
            continue; // saves a root
        }
        sums.add(set, u, r, noise);
    }
    let Sums { residual, impulse, slipping, noises, .. } = sums;
    let expected = size * size;
    let size = impulse.max(expected);
    if residual == T::ZERO && noises == T::ZERO {
        return T::ZERO; // also for 0/0
    }
    let mut error = root_sum(residual, noises, size);
    if impulse > expected {
        let mut hidden = noises;
        if is_final {
            // The rounding of the natural map, with `(a + b + c + d)² <= 4 (a² + b² + c² + d²)`.
            let slips = T::literal(SLIP_ROUNDING * SLIP_ROUNDING) * slipping;
            let rounding = (slips + T::literal(16.0) * impulse) * T::EPSILON * T::EPSILON;
            hidden = (noises + rounding) * T::literal(4.0);
        }
        // `(√residual + √hidden)² <= 2 (residual + hidden)`: mostly far below the share, whose square is 1/4 of `expected`.
        if (residual + hidden) * T::literal(8.0) > expected {
            error = at_least_excess(error, [residual, hidden], expected, &|| carried() * unit);
        }
    }
    if is_final && slipping > T::ZERO {
        let rounding = T::EPSILON * T::literal(SLIP_ROUNDING);
        return error + rounding * quotient(slipping, size).square_root();
    }
    error
}

/// Sums of squares over contacts, in a unit.
struct Sums<T> {
    unit: T,
    /// Residuals of the natural map, or of Alart and Curnier.
    residual: T,
    /// Impulses.
    impulse: T,
    /// Impulses of slipping contacts.
    slipping: T,
    /// Bounds on the change of the residuals by the rounding of velocities.
    noises: T,
}

impl<T: Real> Sums<T> {
    fn zero(unit: T) -> Self {
        let [residual, impulse, slipping, noises] = [T::ZERO; 4];
        Self { unit, residual, impulse, slipping, noises }
    }

    /// Adds a contact with the velocity `u` and the impulse `r`.
    #[inline]
    fn add<const D: usize>(
        &mut self,
        set: &ContactSet<T, D>,
        u: &[T; D],
        r: &[T; D],
        noise: Option<&[T; 2]>,
    ) {
        let unit = self.unit;
        let scaled = SVector::from(*r) * unit;
        let alpha_u = SVector::from(*u) * (set.alpha * unit);
        let Residual { value, mut boundary } = contact_residual(set, &alpha_u, &scaled);
        let mut residual = square(value.as_slice());
        let impulse = square(scaled.as_slice());
        self.impulse += impulse;
        if boundary.is_some() {
            self.slipping += impulse;
        }
        let mut reach = T::ONE + set.shift_factor;
        if D > 1 && set.shift_factor > T::literal(LARGE_FRICTION) {
            let other = alart_curnier_square(set, u, r, unit);
            if other < residual {
                (residual, reach, boundary) = (other, T::ONE, None);
            }
        }
        self.residual += residual;
        if let Some(&[noise, normal]) = noise {
            let mut change = reach * reach * noise;
            if is_free(set, r) && u.first().is_some_and(|&normal| normal >= T::ZERO) {
                change = normal; // `|Π_K(-alpha û)|` is at most `alpha max(0, -u_N)`
            } else if let Some(boundary) = boundary {
                let slope = boundary.sensitivity(set, &scaled);
                // `(a + b)² <= 2 (a² + b²)`
                change = change.min((normal + slope * slope * noise) * T::literal(2.0));
            }
            let scale = set.alpha * unit;
            self.noises += scale * scale * change;
        }
    }
}

/// The larger of `error` and the share by which the residual exceeds [`LARGEST_SHARE`] of the expected impulses, at most 1.
/// Without this rule impulses that diverge would make any violation small. `residual`, `noises` and `expected` are squares.
fn at_least_excess<T: Real>(error: T, [residual, noises]: [T; 2], expected: T, carried: &dyn Fn() -> T) -> T {
    let mut bound = residual;
    if noises > T::ZERO {
        bound = (residual + noises) * T::literal(2.0); // at least `(√residual + √noises)²`
    }
    let reach = (T::ONE + error) * T::literal(LARGEST_SHARE);
    if error >= T::ONE || expected == T::ZERO || bound <= reach * reach * expected {
        return error;
    }
    let carried = carried();
    let size = expected.max(carried * carried);
    let share = root_sum(residual, noises, size) / T::literal(LARGEST_SHARE);
    error.max((share - T::ONE).min(T::ONE))
}

/// Does a contact without impulse obey the law for every velocity within the rounding bounds, whose squares are `noise` (m²/s²)?
#[inline]
fn separates<T: Real, const D: usize>(set: &ContactSet<T, D>, u: &[T; D], noise: Option<&[T; 2]>) -> bool {
    let mu = set.cone.friction();
    let [normal, tangent @ ..] = u.as_slice() else {
        return false;
    };
    if set.shift_factor == mu {
        return *normal >= T::ZERO && noise.is_none_or(|&[_, noise]| *normal * *normal > noise);
    }
    let margin = *normal + (set.shift_factor - mu) * norm(tangent);
    let reach = T::ONE + mu;
    margin >= T::ZERO && noise.is_none_or(|&[noise, _]| margin * margin > reach * reach * noise)
}

/// Is Coulomb's law solved, and the impulse zero? Then the law asks for `u_N >= 0` alone.
#[inline]
fn is_free<T: Real, const D: usize>(set: &ContactSet<T, D>, r: &[T; D]) -> bool {
    *r == [T::ZERO; D] && set.shift_factor == set.cone.friction()
}

#[cfg(test)]
mod tests;
