//! The error a solution is judged by, and what rounding may add to it.
//!
//! `error = max(|r - Π_K(r - alpha û)| / max(|r|, |alpha q|), |M v + f - Hᵀ r| / max(|f|, |M v|, |Hᵀ r|))`
//! with `û_i = u_i + mu_i |u_Ti| e_N`, `u = H v + w`, `q = H v_free + w` and
//! `alpha_i = D / trace(W_ii)`. It is the natural-map residual of FCLIB and Siconos made
//! independent of units; 0/0 counts as 0.

use crate::cone::{add_to_normal, norm};
use crate::contact_space::ContactVector;
use crate::problem::Law;
use crate::{ContactMode, Real, Scene};
use nalgebra::SVector;

/// A quotient of norms in which 0/0 is 0; never NaN.
pub(crate) fn quotient<T: Real>(numerator: T, denominator: T) -> T {
    if numerator == T::ZERO {
        T::ZERO
    } else {
        numerator / denominator
    }
}

/// Argument `r - alpha û` of the natural map of one contact.
fn argument<T: Real, const D: usize>(
    law: &Law<T, D>,
    u: &SVector<T, D>,
    r: &SVector<T, D>,
) -> SVector<T, D> {
    let mut velocity = *u;
    add_to_normal(&mut velocity, law.lift(u));
    r - velocity * law.step
}

/// What a contact does, read off the argument of the natural map.
pub(crate) fn mode<T: Real, const D: usize>(
    law: &Law<T, D>,
    u: &SVector<T, D>,
    r: &SVector<T, D>,
) -> ContactMode {
    if r.iter().all(|&r| r == T::ZERO) {
        ContactMode::Open
    } else if law.cone.is_interior(&argument(law, u, r)) {
        ContactMode::Stick
    } else {
        ContactMode::Slip
    }
}

/// First part of the error, from `u = W r + q` or `u = H v + w`.
///
/// `noise` bounds what rounding did to each `u_i`, m/s; it is counted as part of the error.
pub(crate) fn natural_map<'a, T: Real, const D: usize>(
    contacts: impl Iterator<Item = (&'a Law<T, D>, &'a [T; D], &'a [T; D], T)>,
) -> T {
    let [mut residual, mut impulse, mut free] = [T::ZERO; 3];
    for (law, u, r, noise) in contacts {
        let (u, r) = (SVector::from(*u), SVector::from(*r));
        let x = argument(law, &u, &r);
        let gap = (r - law.cone.project(&x)).norm_squared();
        let noise = law.step * (T::ONE + law.lift) * noise;
        residual += gap + noise * noise;
        impulse += r.norm_squared();
        free += (law.free * law.step).norm_squared();
    }
    quotient(residual.square_root(), impulse.max(free).square_root())
}

/// The whole error of a solution, plus what rounding in this function may hide of it.
///
/// A sum of products is trusted to `eps` times the sum of their magnitudes, which also covers a
/// scene that was rounded to this number type. Fills `u = H v + w`.
pub(crate) fn error<T: Real, const N: usize, const D: usize, const C: usize>(
    scene: &Scene<T, N, D, C>,
    laws: &[Law<T, D>],
    f: &SVector<T, N>,
    v: &SVector<T, N>,
    r: &ContactVector<T, D, C>,
    u: &mut ContactVector<T, D, C>,
) -> T {
    let mut noise = [T::ZERO; C];
    // M v, Hᵀ r and the magnitudes of their terms, dof by dof.
    let mut inertia = [T::ZERO; N];
    let mut contact_force = [T::ZERO; N];
    let mut terms = [T::ZERO; N];
    for (&v, column) in v.iter().zip(scene.mass().as_slice().chunks_exact(N)) {
        for ((sum, terms), &mass) in inertia.iter_mut().zip(&mut terms).zip(column) {
            let term = mass * v;
            *sum += term;
            *terms += term.abs();
        }
    }
    for (((contact, r), u), noise) in scene.contacts().iter().zip(r).zip(&mut *u).zip(&mut noise) {
        let mut magnitude = [T::ZERO; D];
        for ((u, magnitude), &w) in u.iter_mut().zip(&mut magnitude).zip(contact.offset.iter()) {
            *u = w;
            *magnitude = w.abs();
        }
        let columns = contact.jacobian.as_slice().chunks_exact(D);
        let dofs = contact_force.iter_mut().zip(&mut terms);
        for ((&v, column), (force, terms)) in v.iter().zip(columns).zip(dofs) {
            for (((u, magnitude), &h), &r) in u.iter_mut().zip(&mut magnitude).zip(column).zip(r) {
                let term = h * v;
                *u += term;
                *magnitude += term.abs();
                let term = h * r;
                *force += term;
                *terms += term.abs();
            }
        }
        *noise = T::EPSILON * norm(&magnitude);
    }

    let contacts = laws.iter().zip(&*u).zip(r).zip(noise);
    let natural_map = natural_map(contacts.map(|(((law, u), r), noise)| (law, u, r, noise)));

    let [mut residual, mut free, mut moved, mut pushed] = [T::ZERO; 4];
    let dofs = f.iter().zip(&inertia).zip(&contact_force).zip(&terms);
    for (((&f, &inertia), &contact), &terms) in dofs {
        let gap = inertia + f - contact;
        let noise = T::EPSILON * (terms + f.abs());
        residual += gap * gap + noise * noise;
        free += f * f;
        moved += inertia * inertia;
        pushed += contact * contact;
    }
    let size = free.max(moved).max(pushed);
    natural_map.max(quotient(residual.square_root(), size.square_root()))
}
