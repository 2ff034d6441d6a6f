//! The penalty `rho` of the augmented Lagrangian, and which dofs contacts move.

use crate::laws::Laws;
use crate::linalg::hints::{opaque_mut, rolled};
use crate::linalg::sparsity::GROUP;
use crate::{Real, Scene};

/// Is it a penalty that can be used?
#[inline]
pub(crate) fn is_usable<T: Real>(rho: T) -> bool {
    rho > T::ZERO && rho.is_finite()
}

/// The default `rho`, a power of two near 6 times the geometric mean of `M_jj / (HᵀH)_jj`.
///
/// The quotient is the mass felt by a contact that moves dof `j` alone, so `rho` has the unit of a
/// mass; the units of the dofs, and dofs that no contact moves, do not matter. The geometric mean
/// serves stacks of unlike bodies, where the trace of `W` sees only the lightest; taken over binary
/// exponents it needs no logarithm, and changing units by powers of two changes it exactly.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn default_penalty<T: Real, const N: usize, const D: usize, const C: usize, L: Laws>(
    scene: &Scene<T, N, D, C, L>,
) -> T {
    let reach = reach(scene);
    let moved = reach.iter().filter(|&&reach| reach > T::ZERO);
    let exponents = moved.clone().map(|reach| reach.exponent()).sum::<i32>();
    let count = i32::try_from(moved.count()).unwrap_or(0);
    let mean = exponents.checked_div_euclid(count);
    mean.map_or(T::ONE, |mean| T::power_of_two(2 - mean))
}

/// Number of dofs that contacts move.
pub(crate) fn moved_dofs<T: Real, const N: usize, const D: usize, const C: usize, L: Laws>(
    scene: &Scene<T, N, D, C, L>,
) -> usize {
    let reach = reach(scene);
    reach.iter().filter(|&&reach| reach > T::ZERO).count()
}

/// `(HᵀH)_jj / M_jj`; 0 if that is rounding relative to the largest.
#[cfg_attr(target_os = "none", inline(never))]
fn reach<T: Real, const N: usize, const D: usize, const C: usize, L: Laws>(
    scene: &Scene<T, N, D, C, L>,
) -> [T; N] {
    let mut reach = [T::ZERO; N];
    let (groups, last) = reach.as_chunks_mut::<GROUP>();
    for (contact, support) in scene.supported() {
        let (columns, rest) = contact.jacobian.data.0.as_chunks::<GROUP>();
        for group in support.groups::<N>() {
            rolled();
            if let (Some(columns), Some(reach)) = (columns.get(group), groups.get_mut(group)) {
                add_squares(columns, reach);
            }
        }
        add_squares(rest, last);
    }
    let mut largest = T::ZERO;
    let masses = scene.mass().data.0.iter();
    for (j, (reach, masses)) in opaque_mut(&mut reach).iter_mut().zip(masses).enumerate() {
        rolled();
        *reach /= masses.get(j).copied().unwrap_or(T::ONE);
        if *reach > largest {
            largest = *reach;
        }
    }
    for reach in opaque_mut(&mut reach) {
        rolled();
        if *reach <= largest * T::literal(1e-9) {
            *reach = T::ZERO;
        }
    }
    reach
}

/// `sums_j += |column_j|²`
#[inline]
fn add_squares<T: Real, const D: usize>(columns: &[[T; D]], sums: &mut [T]) {
    for (sum, column) in sums.iter_mut().zip(columns) {
        *sum = column.iter().fold(*sum, |sum, &entry| sum + entry * entry);
    }
}
