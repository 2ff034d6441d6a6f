//! Gauss-Seidel over the contacts: another place to start Newton's method from.
//!
//! Scenes with strong friction have points at which neither the residuals of ADMM nor the energy
//! of Newton's method decrease, though a solution lies elsewhere. A few sweeps lead elsewhere.
//! And where a contact does something else than in the last solution, one or two find out what.
//!
//! A contact is solved exactly while the others are held. With `u` the velocity that they leave,
//! it is open if `u_N >= 0`; else `u_N` becomes 0, and `u_T = -λ r_T` with `λ = 0` if that keeps
//! the impulse in the cone, or the `λ > 0` that puts it on the boundary. So the impulse is
//! `r = -(W_ii + λ I_T)⁻¹ u`, and `mu r_N / |r_T| - 1`, of which `λ` is a root, is nearly linear.

use crate::Real;
use crate::cholesky::{dot, rolled};
use crate::cone::square;
use crate::contact_space::{ContactVector, product};
use crate::pivot::Pivot;
use crate::problem::Problem;

/// Solves contact by contact, each with the impulses of the others as they are by then.
#[inline(never)]
pub(crate) fn sweep<T: Real, const N: usize, const D: usize, const C: usize>(
    problem: &Problem<'_, T, N, D, C>,
    impulse: &mut ContactVector<T, D, C>,
) {
    let used = ..problem.laws().len();
    let contacts = problem.laws().iter().zip(problem.factor.delassus());
    for (i, (law, rows)) in contacts.enumerate() {
        if let Some(impulse) = impulse.get_mut(i) {
            *impulse = [T::ZERO; D];
        }
        let mut u: [T; D] = law.free.into();
        let mut own = [[T::ZERO; D]; D];
        for ((u, own), row) in u.iter_mut().zip(&mut own).zip(rows) {
            if let (Some(row), Some(impulse)) = (row.get(used), impulse.get(used)) {
                *u += dot(row.as_flattened(), impulse.as_flattened());
            }
            *own = row.get(i).copied().unwrap_or(*own);
        }
        if let Some(impulse) = impulse.get_mut(i) {
            let solved = solve(&own, &u, law.cone.friction());
            *impulse = solved.unwrap_or([T::ZERO; D]);
        }
    }
}

/// The impulse of one contact, from `W_ii` and the velocity that the others leave, if they do not
/// part; where it slips, as near to the boundary as eight steps for `λ` bring it, and then scaled
/// onto it.
#[inline]
fn solve<T: Real, const D: usize>(own: &[[T; D]; D], u: &[T; D], mu: T) -> Option<[T; D]> {
    let (&approach, &inertia) = (u.first()?, own.first()?.first()?);
    let closed = approach < T::ZERO && inertia > T::ZERO;
    if !closed {
        return None;
    }
    let mut last = with_normal([T::ZERO; D], -approach / inertia);
    if mu == T::ZERO || D == 1 {
        return Some(last);
    }
    let (mut lambda, mut low, mut high) = (T::ZERO, T::ZERO, None);
    for _ in 0..9 {
        rolled();
        let mut block = *own;
        for (k, row) in block.iter_mut().enumerate().skip(1) {
            let entry = row.get_mut(k)?;
            // What rounding or nature leaves of a row that nothing moves has a pivot, too.
            let size = if *entry > T::ZERO { *entry } else { inertia };
            *entry += lambda + T::EPSILON * T::literal(8.0) * size;
        }
        let pivot = Pivot::new(block)?;
        let r = pivot.solve(u.map(|u| -u));
        let normal = *r.first()?;
        let slip = with_normal(r, T::ZERO);
        let squares = square(&slip);
        let sticks = normal >= T::ZERO && squares <= mu * mu * normal * normal;
        if lambda == T::ZERO && sticks {
            return Some(r);
        }
        let length = squares.square_root();
        let ratio = mu * normal / length;
        if normal > T::ZERO && ratio.is_finite() {
            last = with_normal(slip.map(|slip| slip * ratio), normal);
        }
        let excess = ratio - T::ONE;
        if excess.abs() <= T::literal(1e-3) {
            break;
        }
        if excess < T::ZERO {
            low = lambda;
        } else {
            high = Some(lambda);
        }
        // - dr / dλ
        let bend = pivot.solve(slip);
        let turn = product(&slip, &bend) / squares;
        let slope = ratio * turn - mu * *bend.first()? / length;
        let newton = lambda - excess / slope;
        let inside = newton > low && high.is_none_or(|high| newton < high);
        lambda = match high {
            _ if inside => newton,
            Some(high) => (low + high) * T::literal(0.5),
            None => (lambda + inertia) * T::literal(2.0),
        };
    }
    Some(last)
}

/// Another normal component.
#[inline]
fn with_normal<T: Real, const D: usize>(mut x: [T; D], normal: T) -> [T; D] {
    if let Some(first) = x.first_mut() {
        *first = normal;
    }
    x
}
