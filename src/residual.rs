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

/// A quotient of norms in which 0/0 is 0, and whatever is not a number is infinite.
pub(crate) fn quotient<T: Real>(numerator: T, denominator: T) -> T {
    if numerator == T::ZERO && denominator.is_finite() {
        T::ZERO
    } else if numerator.is_finite() && denominator.is_finite() {
        numerator / denominator
    } else {
        T::ONE / T::ZERO
    }
}

/// A power of two that brings the largest of some numbers near 1, so that their squares neither
/// overflow nor vanish.
fn unit<T: Real>(numbers: impl Iterator<Item = T>) -> T {
    let largest = numbers.fold(T::ZERO, |largest, x| largest.max(x.abs()));
    if largest > T::ZERO && largest.is_finite() {
        T::power_of_two(-largest.exponent())
    } else {
        T::ONE
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
    contacts: impl Iterator<Item = (&'a Law<T, D>, &'a [T; D], &'a [T; D], T)> + Clone,
) -> T {
    let sizes = contacts.clone().flat_map(|(law, _, r, _)| {
        let free = law.free.iter().map(|&q| law.step * q);
        r.iter().copied().chain(free)
    });
    let unit = unit(sizes);
    let [mut residual, mut impulse, mut free, mut noises] = [T::ZERO; 4];
    for (law, u, r, noise) in contacts {
        let (u, r) = (SVector::from(*u), SVector::from(*r));
        let x = argument(law, &u, &r);
        residual += ((r - law.cone.project(&x)) * unit).norm_squared();
        impulse += (r * unit).norm_squared();
        free += (law.free * (law.step * unit)).norm_squared();
        let noise = law.step * unit * (T::ONE + law.lift) * noise;
        noises += noise * noise;
    }
    let size = impulse.max(free);
    if residual == T::ZERO && size == T::ZERO {
        // Nothing moves and nothing pushes: what noise there is has cancelled.
        return T::ZERO;
    }
    quotient((residual + noises).square_root(), size.square_root())
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

    let sizes = f.iter().chain(&inertia).chain(&contact_force).copied();
    let unit = unit(sizes);
    let [mut residual, mut free, mut moved, mut pushed] = [T::ZERO; 4];
    let dofs = f.iter().zip(&inertia).zip(&contact_force).zip(&terms);
    for (((&f, &inertia), &contact), &terms) in dofs {
        let gap = unit * (inertia + f - contact);
        let noise = T::EPSILON * unit * (terms + f.abs());
        residual += gap * gap + noise * noise;
        free += (unit * f) * (unit * f);
        moved += (unit * inertia) * (unit * inertia);
        pushed += (unit * contact) * (unit * contact);
    }
    let size = free.max(moved).max(pushed);
    natural_map.max(quotient(residual.square_root(), size.square_root()))
}
