//! The impulse of one contact by the convex relaxation while the others are held: a convex problem in its cone.
//!
//! With the free velocity `u` (without the impulse of this contact), the impulse is `argmin ½ r·W_ii r + u·r` over `K`. It is 0 if `u`
//! lies in `K*`, and `-W_ii⁻¹ u` if that lies in `K`. Otherwise it lies on the boundary of `K`, where
//! `u + W_ii r = λ (mu² r_N, -r_T)` with a `λ > 0`. One step of Newton's method along the boundary leads near it from the last
//! impulse. More steps save 4 % of the work and no time, since the other contacts move as well.

use crate::linalg::blocks::product;
use crate::linalg::vector::{norm, square};
use crate::linalg::zip::zip3;
use crate::real::Real;
use crate::sets::contact::local::Local;

/// The impulse of one contact while the others are held.
#[inline(never)]
pub(in crate::sets) fn solve_local<T: Real, const D: usize>(local: &Local<'_, T, D>) -> [T; D] {
    let Local { block, mass, u, r, set } = local;
    let sticking = minus(r, &times(mass, u));
    let regular = mass.first().and_then(|row| row.first()) != Some(&T::ZERO);
    if regular && set.cone.is_interior(&sticking.into()) {
        return sticking;
    }
    let free = minus(u, &times(block, r));
    if set.cone.dual().has(&free.into()) {
        return [T::ZERO; D];
    }
    let boundary = Boundary { block, free: &free, mu: set.cone.friction() };
    let next = boundary.step(r, u).or_else(|| {
        let start = boundary.towards(&free.map(|u| -u))?;
        let change = times(block, &start.map(|r| -r));
        boundary.step(&start, &minus(&free, &change)).or(Some(start))
    });
    next.unwrap_or([T::ZERO; D])
}

/// `A x`
#[cfg_attr(target_os = "none", inline(never))]
fn times<T: Real, const D: usize>(matrix: &[[T; D]; D], x: &[T; D]) -> [T; D] {
    matrix.map(|row| product(&row, x))
}

/// `x - y`
fn minus<T: Real, const D: usize>(x: &[T; D], y: &[T; D]) -> [T; D] {
    let mut difference = *x;
    for (x, &y) in difference.iter_mut().zip(y) {
        *x -= y;
    }
    difference
}

/// The problem of a slipping contact on the boundary of its cone.
struct Boundary<'a, T, const D: usize> {
    /// `W_ii`
    block: &'a [[T; D]; D],
    /// Velocity without the impulse of the contact.
    free: &'a [T; D],
    mu: T,
}

impl<T: Real, const D: usize> Boundary<'_, T, D> {
    /// The impulse of least energy on the ray `(1, mu d)`, with the direction `d` of the tangential part of `tangents`; `None` if the
    /// contact opens along that ray.
    #[cfg_attr(target_os = "none", inline(never))]
    fn towards(&self, tangents: &[T; D]) -> Option<[T; D]> {
        let length = norm(tangents.get(1..)?);
        let slides = length > T::ZERO;
        let stretch = if slides { self.mu / length } else { T::ZERO };
        let mut ray = tangents.map(|tangent| tangent * stretch);
        *ray.first_mut()? = T::ONE;
        let moved = times(self.block, &ray);
        let size = -product(self.free, &ray) / product(&moved, &ray);
        let usable = size > T::ZERO && size.is_finite();
        usable.then_some(ray.map(|ray| ray * size))
    }

    /// The impulse after one step of Newton's method from `impulse`, at which the contact has the velocity `u`. The step has two
    /// directions: the ray of `impulse`, and the part of `u_T` that is perpendicular to `r_T`. Across the ray the curvature `λ`
    /// of the cone is added. With one or two tangents there are no other directions.
    ///
    /// `None` without a tangential impulse, or if the contact opens.
    fn step(&self, impulse: &[T; D], u: &[T; D]) -> Option<[T; D]> {
        let length = norm(impulse.get(1..)?);
        if length <= T::ZERO {
            return None;
        }
        let scale = T::ONE / length;
        let mut ray = impulse.map(|r| r * scale);
        *ray.first_mut()? = T::ZERO;
        let slip = product(u, &ray);
        if D == 2 && slip > T::ZERO {
            return self.towards(&u.map(|u| -u)); // friction acted along the slip: turn it round
        }
        let mut across = minus(u, &ray.map(|ray| slip * ray));
        *across.first_mut()? = T::ZERO;
        ray = ray.map(|ray| ray * self.mu);
        *ray.first_mut()? = T::ONE;
        // The gradient and the second derivatives of the energy: `[a b; b c]`.
        let (along, turning) = (product(&ray, u), square(&across));
        let moved = times(self.block, &ray);
        let turned = times(self.block, &across);
        let curvature = (-slip * scale).max(T::ZERO);
        let (a, b) = (product(&moved, &ray), product(&moved, &across));
        let c = product(&turned, &across) + curvature * turning;
        let det = a * c - b * b;
        let (x, y) = if det > T::ZERO {
            let divided = T::ONE / det;
            ((b * turning - c * along) * divided, (b * along - a * turning) * divided)
        } else {
            (-along / a, T::ZERO)
        };
        let mut next = *impulse;
        for (next, &ray, &across) in zip3(&mut next, &ray, &across) {
            *next += x * ray + y * across;
        }
        self.towards(&next)
    }
}

#[cfg(test)]
mod tests;
