//! Gauss-Seidel sweeps over the contacts: another place to start Newton's method from.
//!
//! Scenes with strong friction have points at which neither the residuals of ADMM nor the energy
//! of Newton's method decrease, though a solution lies elsewhere. A few sweeps lead elsewhere.

use crate::Real;
use crate::cholesky::dot;
use crate::contact_space::ContactVector;
use crate::problem::Problem;
use nalgebra::SVector;

/// Solves contact by contact for the impulse, with the others held: a few iterations of
/// `r_i = Π_K(r_i - alpha_i û_i / 2)` each.
pub(crate) fn sweep<T: Real, const N: usize, const D: usize, const C: usize>(
    problem: &Problem<'_, T, N, D, C>,
    impulse: &mut ContactVector<T, D, C>,
) {
    let contacts = problem.laws().iter().zip(problem.factor.delassus());
    for (i, (law, rows)) in contacts.enumerate() {
        let mut u = law.free;
        for (u, row) in u.iter_mut().zip(rows) {
            *u += dot(row.as_flattened(), impulse.as_flattened());
        }
        let Some(impulse) = impulse.get_mut(i) else {
            return;
        };
        for _ in 0..5 {
            let r = SVector::from(*impulse);
            let push = law.lifted(&u) * (law.step * T::literal(0.5));
            let next = law.cone.project(&(r - push));
            let change: [T; D] = (next - r).into();
            for (u, block) in u.iter_mut().zip(rows.iter().filter_map(|row| row.get(i))) {
                *u += dot(block, &change);
            }
            *impulse = next.into();
        }
    }
}
