//! Gauss-Seidel over the contacts: another place to start Newton's method from.
//!
//! Scenes with strong friction have points at which neither the residuals of ADMM nor the energy
//! of Newton's method decrease, though a solution lies elsewhere. A few sweeps lead elsewhere.
//!
//! A contact is solved exactly while the others are held. With `u` the velocity that they leave,
//! it is open if `u_N >= 0`; else `u_N` becomes 0, and `u_T = -λ r_T` with `λ = 0` if that keeps
//! the impulse in the cone, or the `λ > 0` that puts it on the boundary. With the Schur complement
//! `S` of `W_NN` in `W_ii` the impulse is `r_T = (S + λ I)⁻¹ b`, and `mu r_N / |r_T| - 1`, of which
//! `λ` is a root, is nearly linear.

use crate::Real;
use crate::cholesky::{dot, factorise, solve};
use crate::cone::square;
use crate::contact_space::{ContactVector, product};
use crate::problem::Problem;

/// Solves contact by contact, each with the impulses of the others as they are by then.
#[inline(never)]
pub(crate) fn sweep<T: Real, const N: usize, const D: usize, const C: usize>(
    problem: &Problem<'_, T, N, D, C>,
    impulse: &mut ContactVector<T, D, C>,
) {
    let contacts = problem.laws().iter().zip(problem.factor.delassus());
    for (i, (law, rows)) in contacts.enumerate() {
        if let Some(impulse) = impulse.get_mut(i) {
            *impulse = [T::ZERO; D];
        }
        let mut u: [T; D] = law.free.into();
        let mut own = [[T::ZERO; D]; D];
        for ((u, own), row) in u.iter_mut().zip(&mut own).zip(rows) {
            *u += dot(row.as_flattened(), impulse.as_flattened());
            *own = row.get(i).copied().unwrap_or(*own);
        }
        if let Some(impulse) = impulse.get_mut(i) {
            let local = Local::new(&own, &u);
            let solved = local.and_then(|local| local.solve(law.cone.friction()));
            *impulse = solved.unwrap_or([T::ZERO; D]);
        }
    }
}

/// One contact with the others held: `r_N = press + tilt·r_T` and `(S + λ I) r_T = b`, the tangents
/// from the first place on.
struct Local<T, const D: usize> {
    press: T,
    tilt: [T; D],
    schur: [[T; D]; D],
    b: [T; D],
}

impl<T: Real, const D: usize> Local<T, D> {
    /// From `W_ii` and the velocity that the others leave; `None` if they part.
    fn new(own: &[[T; D]; D], u: &[T; D]) -> Option<Self> {
        let (normal, tangents) = own.split_first()?;
        let (&inertia, coupling) = normal.split_first()?;
        let (&approach, slip) = u.split_first()?;
        let closed = approach < T::ZERO && inertia > T::ZERO;
        if !closed {
            return None;
        }
        let mut local = Self {
            press: -approach / inertia,
            tilt: [T::ZERO; D],
            schur: [[T::ZERO; D]; D],
            b: [T::ZERO; D],
        };
        for (tilt, &coupling) in local.tilt.iter_mut().zip(coupling) {
            *tilt = -coupling / inertia;
        }
        let rows = local.schur.iter_mut().zip(&mut local.b);
        for (k, ((row, b), (own, &slip))) in rows.zip(tangents.iter().zip(slip)).enumerate() {
            let (&coupling, own) = own.split_first()?;
            *b = -(slip + coupling * local.press);
            for ((entry, &own), &tilt) in row.iter_mut().zip(own).zip(&local.tilt) {
                *entry = own + coupling * tilt;
            }
            *row.get_mut(k)? += T::EPSILON * T::literal(8.0) * *own.get(k)?;
        }
        Some(local)
    }

    /// `(S + λ I)⁻¹ b`, and `(S + λ I)⁻¹` times that.
    fn tangents(&self, lambda: T) -> Option<[[T; D]; 2]> {
        let mut shifted = self.schur;
        for (k, row) in shifted.iter_mut().enumerate() {
            *row.get_mut(k)? += lambda;
        }
        let mut factor = [[T::ZERO; D]; D];
        let factor = factor.as_flattened_mut();
        factorise(shifted.as_flattened(), D, D - 1, T::ZERO, factor).ok()?;
        let mut x = self.b;
        solve(factor, D, x.get_mut(..D - 1)?);
        let mut bend = x;
        solve(factor, D, bend.get_mut(..D - 1)?);
        Some([x, bend])
    }

    /// The impulse; where it slips, as near to the boundary as eight steps for `λ` bring it, and
    /// then scaled onto it.
    fn solve(&self, mu: T) -> Option<[T; D]> {
        if mu == T::ZERO || D == 1 {
            return Some(impulse(self.press, &[T::ZERO; D]));
        }
        let [x, _] = self.tangents(T::ZERO)?;
        let normal = self.press + product(&self.tilt, &x);
        if normal >= T::ZERO && square(&x) <= mu * mu * normal * normal {
            return Some(impulse(normal, &x));
        }
        let (mut lambda, mut low, mut high) = (T::ZERO, T::ZERO, None);
        let mut last = impulse(self.press, &[T::ZERO; D]);
        for _ in 0..8 {
            let [x, bend] = self.tangents(lambda)?;
            let normal = self.press + product(&self.tilt, &x);
            let length = square(&x).square_root();
            let ratio = mu * normal / length;
            if normal > T::ZERO {
                last = impulse(normal, &x.map(|x| x * ratio));
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
            let turn = product(&x, &bend) / (length * length);
            let slope = ratio * turn - mu * product(&self.tilt, &bend) / length;
            let newton = lambda - excess / slope;
            let inside = newton > low && high.is_none_or(|high| newton < high);
            lambda = match high {
                _ if inside => newton,
                Some(high) => (low + high) * T::literal(0.5),
                None => (lambda + *self.schur.first()?.first()?) * T::literal(2.0),
            };
        }
        Some(last)
    }
}

/// From normal and tangential parts.
fn impulse<T: Real, const D: usize>(normal: T, tangents: &[T; D]) -> [T; D] {
    let mut impulse = [normal; D];
    for (impulse, &tangent) in impulse.iter_mut().skip(1).zip(tangents) {
        *impulse = tangent;
    }
    impulse
}
