//! The algebra of the Lorentz cone, `a_N >= |a_T|`.
//!
//! `∘` is the Jordan product, `a ∘ b = (a·b, a_N b_T + b_N a_T)`, and `det a = a_N² - |a_T|²`.

use crate::cone::split;
use crate::linalg::vector::{norm, square};
use crate::real::Real;
use nalgebra::SVector;

/// The vector with this normal component and the tangential part of `tangent`.
pub(in crate::sets) fn joined<T: Real, const D: usize>(normal: T, tangent: SVector<T, D>) -> SVector<T, D> {
    let mut joined = tangent;
    if let Some(first) = joined.as_mut_slice().first_mut() {
        *first = normal;
    }
    joined
}

/// `a_N`
pub(in crate::sets) fn first<T: Real, const D: usize>(a: &SVector<T, D>) -> T {
    split(a).0
}

/// `a_T · b_T`
pub(in crate::sets) fn tangential_product<T: Real, const D: usize>(
    a: &SVector<T, D>,
    b: &SVector<T, D>,
) -> T {
    let pairs = split(a).1.iter().zip(split(b).1);
    pairs.fold(T::ZERO, |sum, (&a, &b)| sum + a * b)
}

/// `a ∘ b`
pub(in crate::sets) fn jordan<T: Real, const D: usize>(
    a: &SVector<T, D>,
    b: &SVector<T, D>,
) -> SVector<T, D> {
    joined(a.dot(b), b * first(a) + a * first(b))
}

/// The `b` of `a ∘ b = c`.
pub(in crate::sets) fn divide<T: Real, const D: usize>(
    a: &SVector<T, D>,
    c: &SVector<T, D>,
) -> SVector<T, D> {
    let (normal, tangent) = split(a);
    let (c_normal, length) = (first(c), norm(tangent));
    let det = (normal - length) * (normal + length);
    let product = tangential_product(a, c);
    let share = (product / normal - c_normal) / det;
    joined((normal * c_normal - product) / det, a * share + c / normal)
}

/// `sqrt(det a)`, computed without a square that might vanish.
pub(in crate::sets) fn size<T: Real, const D: usize>(a: &SVector<T, D>) -> T {
    let (normal, tangent) = split(a);
    let length = norm(tangent);
    let (low, high) = (normal - length, normal + length);
    high * (low / high).square_root()
}

/// The greatest `t`, up to `limit`, with `a + t d` in the cone. `a` is inside the cone.
pub(in crate::sets) fn max_step<T: Real, const D: usize>(
    a: &SVector<T, D>,
    d: &SVector<T, D>,
    limit: T,
) -> T {
    // The cone is convex: if the end of the step is inside, so is the whole step. (This test fails if squares vanish or overflow.)
    let end = a + d * limit;
    let (normal, tangent) = split(&end);
    if normal > T::ZERO && normal * normal > square(tangent) {
        return limit;
    }
    // In units of `a_N`, so that no square overflows or vanishes.
    let unit = T::ONE / first(a);
    let (forward, tangent) = (first(d) * unit, d * unit);
    let length = norm(split(a).1) * unit;
    let det = (T::ONE - length) * (T::ONE + length);
    let slope = forward - tangential_product(&(a * unit), &tangent);
    let bend = forward * forward - tangential_product(&tangent, &tangent);
    let root = slope * slope - bend * det;
    let mut longest = limit;
    if root >= T::ZERO {
        let divisor = root.square_root() - slope;
        if divisor > T::ZERO {
            longest = longest.min(det / divisor);
        }
    }
    if forward < T::ZERO {
        longest = longest.min(-T::ONE / forward);
    }
    longest
}

/// Moves a vector back into the interior of the cone if rounding has led out of it.
pub(in crate::sets) fn keep_inside<T: Real, const D: usize>(a: &mut SVector<T, D>) {
    let (normal, tangent) = split(a);
    let bound = normal * (T::ONE - T::literal(4.0) * T::EPSILON);
    let length = norm(tangent);
    if length > bound {
        *a = joined(normal, *a * (bound / length));
    }
}
