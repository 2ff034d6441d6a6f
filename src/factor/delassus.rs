//! The factor of the mass matrix and the Delassus operator.

use super::{Factor, scales};
use crate::laws::{Laws, Room};
use crate::linalg::blocks::{ContactMatrix, block, inverse};
use crate::linalg::cholesky::factorise;
use crate::linalg::hints::{opaque, rolled};
use crate::linalg::sparsity::Support;
use crate::linalg::substitution::{Scaled, solve_upper_block};
use crate::problem::residual::larger;
use crate::{Contact, Error, Real, Scene};
use heapless::Vec;

impl<T: Real, const N: usize, const D: usize, const C: usize, L: Laws> Factor<T, N, D, C, L> {
    /// Computes the Cholesky factor, `W` and the effective masses.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn compute_delassus(&mut self, scene: &Scene<T, N, D, C, L>) -> Result<(), Error> {
        (self.contacts, self.fingerprint) = (0, 0);
        let mass = &scene.mass().data.0; // symmetric: columns are rows
        let floor = T::literal(32.0) * T::EPSILON;
        let mut reach = [usize::MAX; N]; // zeros would call memset
        factorise(mass, floor, &mut self.mass, &mut reach)
            .map_err(|dof| Error::MassNotPositiveDefinite { dof })?;
        self.measure_uncertainty(mass, scene.delassus_gap());
        self.take_in(scene, 0, &reach);
        Ok(())
    }

    /// Computes what belongs to the slots of a scene from `first` on, with the last row of `U` that has an entry in each
    /// column.
    #[inline]
    pub(super) fn take_in(
        &mut self,
        scene: &Scene<T, N, D, C, L>,
        first: usize,
        reach: &[usize; N],
    ) {
        (self.contacts, self.fingerprint) = (scene.contacts().len(), scene.fingerprint());
        let mut scaled = Vec::new();
        for (i, contact) in opaque(scene.contacts()).iter().enumerate().skip(first) {
            rolled();
            let Some(whitened) = self.whitened.get_mut(i) else {
                break;
            };
            let transpose = &contact.jacobian.data.0; // D rows in N columns
            scaled.clear();
            solve_upper_block(&self.mass, reach, transpose, whitened, &mut scaled);
            if L::MIXED {
                let scales = scene.slot(i).map(|slot| {
                    let own = products(&scaled, whitened);
                    let scales = scales::of(slot, &own, scene.reference_mass(), &reaches(contact));
                    scales::apply(&scales, whitened, &mut scaled);
                    scales
                });
                if let Some(place) = self.scales.get_mut(i) {
                    *place = scales.map_or(L::Room::EMPTY, L::Room::with);
                }
            }
            for (j, y) in self.whitened.iter().enumerate().take(i + 1) {
                rolled();
                let block = products(&scaled, y);
                for (a, entries) in block.into_iter().enumerate() {
                    set(&mut self.delassus, [i, j], a, entries);
                }
            }
            if L::MIXED
                && let (Some(slot), Some(scales)) = (scene.slot(i), self.scales(i).copied())
            {
                scales::comply(&mut self.delassus, i, slot, &scales, scene.reference_mass());
            }
            if let Some(support) = self.supports.get_mut(i) {
                *support = Support::of::<N>(scaled.iter().map(|row| row.place));
            }
            let own = block(&self.delassus, i, i);
            if let (Some(mass), Some(own)) = (self.effective_mass.get_mut(i), own) {
                *mass = inverse(&own);
            }
        }
    }

    /// Bounds the rounding of `W`: it grows with the largest `M_kk` over its pivot. A factor of 64 is enough for 500,000
    /// random scenes in single precision.
    fn measure_uncertainty(&mut self, mass: &[[T; N]; N], delassus_gap: T) {
        let mut growth = T::ONE;
        for (k, (mass, factor)) in opaque(mass).iter().zip(&self.mass).enumerate() {
            rolled();
            if let (Some(&diagonal), Some(&reciprocal)) = (mass.get(k), factor.get(k)) {
                growth = larger(growth, &[diagonal], reciprocal);
            }
        }
        self.uncertainty = T::literal(64.0) * T::EPSILON * growth + delassus_gap;
    }
}

/// Which rows of a slot have an entry that is not zero?
pub(super) fn reaches<T: Real, const N: usize, const D: usize>(
    slot: &Contact<T, N, D>,
) -> [bool; D] {
    let mut reaches = [false; D];
    for column in &slot.jacobian.data.0 {
        rolled();
        for (reaches, &entry) in reaches.iter_mut().zip(column) {
            *reaches |= entry != T::ZERO;
        }
    }
    reaches
}

/// Writes row `a` of the block of two contacts, and its mirror image: `W` stays symmetric to the bit, a
/// contact's own block too. (Where it was not, a tumbling box gained energy in single precision.)
fn set<T: Real, const D: usize, const C: usize>(
    matrix: &mut ContactMatrix<T, D, C>,
    [i, j]: [usize; 2],
    a: usize,
    entries: [T; D],
) {
    for (row, entry) in matrix.get_mut(j).into_iter().flatten().zip(entries) {
        if let Some(mirrored) = row.get_mut(i).and_then(|block| block.get_mut(a)) {
            *mirrored = entry;
        }
    }
    if let Some(row) = matrix.get_mut(i).and_then(|rows| rows.get_mut(a))
        && let Some(block) = row.get_mut(j)
    {
        *block = entries;
    }
}

/// `Σ_k x_k y_kᵀ`
#[inline]
fn products<T: Real, const N: usize, const D: usize>(
    x: &[Scaled<'_, T, N, D>],
    y: &[[T; D]; N],
) -> [[T; D]; D] {
    let mut sums = [[T::ZERO; D]; D];
    for Scaled { place, entry, .. } in x.iter().rev() {
        rolled();
        let Some(y) = y.get(*place) else { break };
        for (sums, &x) in sums.iter_mut().zip(entry) {
            for (sum, &y) in sums.iter_mut().zip(y) {
                *sum += x * y;
            }
        }
    }
    sums
}
