//! The error a solution is judged by; [`crate::problem::rounding`] bounds what rounding may hide of it.
//!
//! `error = max(|r - Π_K(r - alpha û)| / max(|r|, |r0|, |stop|), |M v - M v_free - Hᵀ r| / max(|M v_free|, |M v|, |Hᵀ r|))`
//! with `û_i = u_i + mu_i |u_Ti| e_N`, `u = H v + w`, `q = H v_free + w`, `alpha_i = D / trace(W_ii)` and two impulses
//! (N·s): `r0_i = Π_K(-alpha_i q̂_i)`, that of contact `i` if it were alone, and
//! `stop_i = alpha_i (abs(H_i) abs(v_free) + abs(w_i)) / 100`, entry by entry, in which a positive `w_N` (gap) counts as 0.
//!
//! It is the natural-map residual of FCLIB and Siconos made independent of units and relative to impulses: a fast slide or
//! a far gap does not loosen it. If bodies that touch fall together, `q` is rounding alone, and the reference is 1 % of the
//! impulse that would stop them. 0/0 counts as 0. Sums are of squares, with one root at the end.

use crate::cone::{norm, split, square};
use crate::laws::{Laws, Room};
use crate::linalg::hints::{opaque, rolled};
use crate::linalg::sparsity::GROUP;
use crate::problem::ContactLaw;
use crate::solution::zeros;
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

/// `(sqrt(residual) + sqrt(noise)) / sqrt(size)`, of squares: what rounding may hide of an error adds to it.
#[inline]
pub(crate) fn root_sum<T: Real>(residual: T, noise: T, size: T) -> T {
    let error = quotient(residual, size).square_root();
    if noise == T::ZERO {
        return error;
    }
    error + quotient(noise, size).square_root()
}

/// A power of two that brings the largest of some numbers near 1, so that their squares neither
/// overflow nor vanish.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn unit<T: Real>(largest: T) -> T {
    if largest > T::ZERO && largest.is_finite() {
        T::power_of_two(-largest.exponent())
    } else {
        T::ONE
    }
}

/// The largest of a number and of some sizes; sizes that are not numbers do not count.
#[inline]
pub(crate) fn larger<T: Real>(mut largest: T, values: &[T], scale: T) -> T {
    for &value in values {
        let size = (value * scale).abs();
        if size > largest {
            largest = size;
        }
    }
    largest
}

/// Argument `r - alpha û` of the natural map of one contact.
#[inline]
fn argument<T: Real, const D: usize, L: Laws>(
    law: &ContactLaw<T, D, L>,
    u: &SVector<T, D>,
    r: &SVector<T, D>,
) -> SVector<T, D> {
    r - law.augmented(u) * law.alpha
}

/// Natural map of one contact, `r - Π_K(r - alpha û)` (N·s).
pub(crate) fn natural_map_of<T: Real, const D: usize, L: Laws>(
    law: &ContactLaw<T, D, L>,
    u: &SVector<T, D>,
    r: &SVector<T, D>,
) -> SVector<T, D> {
    r - law.project(&argument(law, u, r))
}

/// What a contact does, read off the argument of the natural map.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn mode<T: Real, const D: usize, L: Laws>(
    law: &ContactLaw<T, D, L>,
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

/// Impulses are never compared with less than this share of the impulse that would stop the motion.
pub(crate) const SHARE: f64 = 1e-2;

/// `|r0|`
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn alone<T: Real, const D: usize, L: Laws>(laws: &[ContactLaw<T, D, L>]) -> T {
    let laws = opaque(laws);
    let mut largest = T::ZERO;
    for law in laws {
        rolled();
        if law.rows.get().is_none() {
            largest = larger(largest, law.q.as_slice(), law.alpha);
        }
    }
    let unit = unit(largest);
    let mut squares = T::ZERO;
    for law in laws {
        rolled();
        if law.rows.get().is_some() {
            continue;
        }
        let push = -law.augmented(&(law.q * (law.alpha * unit)));
        squares += law.cone.projected_square(&push);
    }
    squares.square_root() / unit
}

/// `|stop|` (N·s)
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn stopping<T: Real, const N: usize, const D: usize, const C: usize, L: Laws>(
    scene: &Scene<T, N, D, C, L>,
    laws: &[ContactLaw<T, D, L>],
    free: &[T; N],
) -> T {
    let (groups, last) = free.as_chunks::<GROUP>();
    let mut speeds = [[T::ZERO; D]; C];
    let mut largest = T::ZERO;
    let contacts = scene.supported().zip(laws).zip(&mut speeds);
    for (i, (((contact, support), law), speeds)) in contacts.enumerate() {
        rolled();
        if law.rows.get().is_some() {
            continue;
        }
        *speeds = without_gap(&contact.offset).abs().into();
        let (columns, rest) = contact.jacobian.data.0.as_chunks::<GROUP>();
        for group in support.groups::<N>() {
            rolled();
            if let (Some(columns), Some(free)) = (columns.get(group), groups.get(group)) {
                add_sizes(columns, free, speeds);
            }
        }
        add_sizes(rest, last, speeds);
        if let Some(slot) = scene.slot(i) {
            for (speed, &scale) in speeds.iter_mut().zip(&slot.scales) {
                *speed *= scale;
            }
        }
        *speeds = speeds.map(|speed| speed * law.alpha);
        largest = larger(largest, speeds, T::ONE);
    }
    let unit = unit(largest);
    let mut squares = T::ZERO;
    for speeds in opaque(&speeds).iter().take(laws.len()) {
        rolled();
        squares += square(&speeds.map(|speed| speed * unit));
    }
    squares.square_root() * (T::literal(SHARE) / unit)
}

/// An offset with a positive normal entry (a gap) replaced by 0.
pub(crate) fn without_gap<T: Real, const D: usize>(offset: &SVector<T, D>) -> SVector<T, D> {
    let mut offset = *offset;
    if let Some(normal) = offset.as_mut_slice().first_mut() {
        *normal = normal.min(T::ZERO);
    }
    offset
}

/// `sums += Σ_j |v_j| |column_j|`
#[inline]
fn add_sizes<T: Real, const D: usize>(columns: &[[T; D]], v: &[T], sums: &mut [T; D]) {
    for (column, &v) in columns.iter().zip(v) {
        for (sum, &entry) in sums.iter_mut().zip(column) {
            *sum += (entry * v).abs();
        }
    }
}

/// First part of the error, from `u = W r + q` or `u = H v + w`.
///
/// `size` is the larger of `|r0|` and `|stop|` (N·s). `noise[i]`: bound on the squared rounding error of `u_i`, (m/s)²; added
/// unless the contact is open and separates faster.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn natural_map<T: Real, const D: usize, L: Laws>(
    laws: &[ContactLaw<T, D, L>],
    size: T,
    u: &[[T; D]],
    r: &[[T; D]],
    noise: &[T],
) -> T {
    let (laws, u, r) = (opaque(laws), opaque(u), opaque(r));
    let mut largest = size;
    // Beside a size that is not zero small impulses do not count, and the squares of such large
    // ones as overflow are an infinite error.
    if size == T::ZERO {
        for (r, law) in r.iter().zip(laws) {
            rolled();
            if law.rows.get().is_none() {
                largest = larger(largest, r, T::ONE);
            }
        }
    }
    let unit = unit(largest);
    let size = size * unit;
    let [mut residual, mut impulse, mut noises] = [T::ZERO; 3];
    let mut noise = noise.iter();
    for ((law, u), r) in laws.iter().zip(u).zip(r) {
        rolled();
        if law.rows.get().is_some() {
            let _ = noise.next();
            continue;
        }
        let r = SVector::from(*r) * unit;
        let push = law.augmented(&(SVector::from(*u) * (law.alpha * unit)));
        residual += square((r - law.cone.project(&(r - push))).as_slice());
        impulse += square(r.as_slice());
        if let Some(&noise) = noise.next()
            && !(r == zeros::<T, D>() && parts(law, u, noise))
        {
            let scale = law.alpha * unit * (T::ONE + law.shift_factor);
            noises += scale * scale * noise;
        }
    }
    let size = impulse.max(size * size);
    if residual == T::ZERO && noises == T::ZERO {
        return T::ZERO; // also if nothing moves and nothing pushes
    }
    root_sum(residual, noises, size)
}

/// Is the contact open for every velocity within the rounding bound `noise`, (m/s)²?
fn parts<T: Real, const D: usize, L: Laws>(
    law: &ContactLaw<T, D, L>,
    u: &[T; D],
    noise: T,
) -> bool {
    let u = SVector::from(*u);
    let (normal, tangent) = split(&u);
    let mu = law.cone.friction();
    let margin = normal + (law.shift_factor - mu) * norm(tangent);
    let reach = T::ONE + mu;
    margin > T::ZERO && margin * margin > reach * reach * noise
}

#[cfg(test)]
mod tests;
