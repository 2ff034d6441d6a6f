//! The Delassus operator `W = H M⁻¹ Hᵀ` of contacts and joint rows, plus their compliance, and its computation.

use super::Factor;
use crate::error::Error;
use crate::linalg::blocks::{ContactMatrix, block, diagonal_of, inverse, multiply_transposed};
use crate::linalg::cholesky::{axpy, dot, factorise};
use crate::linalg::sparsity::Support;
use crate::linalg::stacked::{Counts, Stacked};
use crate::linalg::substitution::{Scaled, solve_upper_block};
use crate::linalg::vector::at_least;
use crate::linalg::zip::zip3;
use crate::real::Real;
use crate::scene::{Contact, Scene};
use core::array::from_fn;
use heapless::Vec;

/// Relative rounding of `W`, over `eps` and the largest `M_kk (M⁻¹)_kk`. It was enough for millions of random scenes in single precision.
pub(super) const GROWTH: f64 = 64.0;

/// Relative rounding of `W` up to which the estimate by the pivots of `M` is trusted. Above it the diagonal of `M⁻¹` decides.
const SMALL: f64 = 1e-3;

/// The Delassus operator with compliance, `W = H M⁻¹ Hᵀ + R`, a symmetric matrix. `H` includes the joint rows, and the diagonal
/// matrix `R` has the compliances.
#[derive(Clone, Debug)]
pub(crate) struct Delassus<T, const D: usize, const C: usize, const R: usize> {
    /// Blocks `W_ij` of two contacts.
    pub(crate) contacts: ContactMatrix<T, D, C>,
    /// The rows of joint rows: blocks with contacts, and entries with joint rows.
    pub(crate) rows: [Stacked<T, D, C, R>; R],
}

impl<T: Real, const D: usize, const C: usize, const R: usize> Delassus<T, D, C, R> {
    pub(crate) const fn zero() -> Self {
        Self { contacts: [[[[T::ZERO; D]; C]; D]; C], rows: [Stacked::zero(); R] }
    }

    /// `y = W x`, over the contacts and joint rows in use.
    #[inline]
    pub(crate) fn times(&self, x: &Stacked<T, D, C, R>, y: &mut Stacked<T, D, C, R>, counts: Counts) {
        let used = x.contacts.get(..counts.contacts).unwrap_or_default();
        let contacts = y.contacts.get_mut(..counts.contacts).unwrap_or_default();
        multiply_transposed(&self.contacts, used, contacts);
        for (row, &x_j, y_j) in zip3(&self.rows, &x.rows, &mut y.rows).take(counts.rows) {
            *y_j = dot(row.contacts.as_flattened(), used.as_flattened())
                + dot(row.rows.get(..counts.rows).unwrap_or_default(), &x.rows);
            if x_j != T::ZERO {
                axpy(x_j, row.contacts.as_flattened(), contacts.as_flattened_mut());
            }
        }
    }

    /// Inverse mass that row `k` of a contact feels: entry `k` of the diagonal of `W_ii`.
    pub(crate) fn inverse_mass(&self, contact: usize, k: usize) -> T {
        let row = self.contacts.get(contact).and_then(|rows| rows.get(k));
        let block = row.and_then(|row| row.get(contact));
        let entry = block.and_then(|block| block.get(k));
        entry.copied().unwrap_or(T::ZERO)
    }

    /// `trace(W_ii)`
    pub(crate) fn trace(&self, contact: usize) -> T {
        (0..D).fold(T::ZERO, |trace, k| trace + self.inverse_mass(contact, k))
    }

    /// Sets the rows of a contact to zero whose inverse mass is mere rounding ([`rounding_share`]). Is there such a row?
    #[inline]
    fn drop_rounding<const N: usize>(&mut self, contact: usize, whitened: &mut [[[T; D]; N]; C]) -> bool {
        let limit = self.trace(contact) * rounding_share();
        let drops = (0..D).any(|k| self.inverse_mass(contact, k) < limit);
        if drops {
            self.drop_rows(contact, whitened);
        }
        drops
    }

    /// The rare case of [`Self::drop_rounding`], in which one inverse mass is small.
    #[cold]
    #[inline(never)]
    fn drop_rows<const N: usize>(&mut self, contact: usize, whitened: &mut [[[T; D]; N]; C]) {
        let inverse_masses = from_fn::<T, D, _>(|k| self.inverse_mass(contact, k));
        let largest = inverse_masses.iter().fold(T::ZERO, |x, &y| at_least(y, x));
        for (k, &inverse_mass) in inverse_masses.iter().enumerate() {
            if inverse_mass >= largest * rounding_share() {
                continue;
            }
            for row in whitened.get_mut(contact).into_iter().flatten() {
                if let Some(entry) = row.get_mut(k) {
                    *entry = T::ZERO;
                }
            }
            for row in self.contacts.as_flattened_mut() {
                if let Some(entry) = row.get_mut(contact).and_then(|block| block.get_mut(k)) {
                    *entry = T::ZERO;
                }
            }
            let row = self.contacts.get_mut(contact);
            if let Some(row) = row.and_then(|rows| rows.get_mut(k)) {
                *row = [[T::ZERO; D]; C];
            }
        }
    }

    /// Do the normals of two contacts differ by less than a hundredth, in rows of unit effective mass?
    pub(crate) fn are_nearly_one(&self, i: usize, j: usize) -> bool {
        let row = self.contacts.get(i).and_then(|rows| rows.first());
        let coupling = row.and_then(|row| row.get(j)?.first()).copied().unwrap_or(T::ZERO);
        let product = self.inverse_mass(i, 0) * self.inverse_mass(j, 0);
        coupling > T::ZERO && coupling * coupling > product * T::literal(1.0 - 1e-4)
    }

    /// Inverse mass `W_jj` that a joint row feels.
    pub(crate) fn row_inverse_mass(&self, row: usize) -> T {
        let entry = self.rows.get(row).and_then(|entries| entries.rows.get(row));
        entry.copied().unwrap_or(T::ZERO)
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize> Factor<T, N, D, C, R> {
    /// Computes the Cholesky factor of `M`, `W` and the effective mass matrices.
    pub(super) fn compute_delassus<const S: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, R, S>,
    ) -> Result<(), Error> {
        (self.counts.contacts, self.fingerprint) = (0, 0);
        self.has_dropped_rows = false;
        if self.unused != scene.unused() {
            self.set_unused(scene.unused());
        }
        let mass = &scene.mass().data.0; // symmetric: columns are rows
        let floor = T::literal(32.0) * T::EPSILON;
        let mut envelope = [usize::MAX; N]; // not zeros, which would call `memset`
        factorise((mass, self.velocities()), floor, &mut self.mass, &mut envelope)
            .map_err(|dof| Error::MassNotPositiveDefinite { dof })?;
        self.measure_uncertainty(mass);
        self.counts = scene.counts();
        self.fingerprint = scene.fingerprint();
        self.append_contacts(scene, &envelope);
        self.append_rows(scene, 0, &envelope);
        Ok(())
    }

    /// Computes the whitened contacts, their blocks of `W` and their effective mass matrices. `envelope` has the row of the last
    /// nonzero entry of each column of `L`.
    #[inline]
    fn append_contacts<const S: usize>(&mut self, scene: &Scene<T, N, D, C, R, S>, envelope: &[usize; N]) {
        let n = self.velocities();
        for (i, contact) in scene.contacts().iter().enumerate() {
            let Some(whitened) = self.whitened.get_mut(i) else {
                break;
            };
            let transpose = &contact.jacobian.data.0; // D rows in N columns
            let mut scaled = Vec::new();
            solve_upper_block(&self.mass, (envelope, n), transpose, whitened, &mut scaled);
            let scaling = scene.scaling(i);
            if let Some(scaling) = scaling {
                // The rows of `H` scale as velocities do.
                for row in &mut scaled {
                    row.entry = scaling.multiply(row.entry);
                }
                for row in whitened {
                    *row = scaling.multiply(*row);
                }
            }
            for (j, y) in self.whitened.iter().enumerate().take(i + 1) {
                let block = products(&scaled, y);
                for (a, entries) in block.into_iter().enumerate() {
                    set(&mut self.delassus.contacts, [i, j], a, entries);
                }
            }
            if let Some(support) = self.supports.get_mut(i) {
                *support = Support::of::<N>(scaled.iter().map(|row| row.index));
            }
            self.has_dropped_rows |= self.delassus.drop_rounding(i, &mut self.whitened);
            if let (Some(scaling), Some(rows)) = (scaling, self.delassus.contacts.get_mut(i)) {
                for (k, row, &compliance) in zip3(0..D, rows, &scaling.compliance) {
                    if let Some(entry) = row.get_mut(i).and_then(|block| block.get_mut(k)) {
                        *entry += compliance;
                    }
                }
            }
            let diagonal = block(&self.delassus.contacts, i, i);
            if let (Some(mass), Some(diagonal)) = (self.effective_mass.get_mut(i), diagonal) {
                *mass = inverse(&diagonal);
            }
        }
    }

    /// Computes the whitened joint rows from index `first` on, and their entries of `W`.
    pub(super) fn append_rows<const S: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, R, S>,
        first: usize,
        envelope: &[usize; N],
    ) {
        let (contacts, n) = (self.counts.contacts, self.velocities());
        let mut scaled = Vec::new();
        for (j, row) in scene.rows().iter().enumerate().skip(first) {
            let Some(whitened) = self.whitened_rows.get_mut(j) else {
                break;
            };
            let [entries] = row.row.data.0;
            scaled.clear();
            let column = entries.map(|entry| [entry]);
            solve_upper_block(&self.mass, (envelope, n), &column, whitened, &mut scaled);
            if let Some(target) = self.delassus.rows.get_mut(j) {
                for (block, y) in target.contacts.iter_mut().zip(&self.whitened).take(contacts) {
                    [*block] = products(&scaled, y);
                }
            }
            for (k, y) in self.whitened_rows.iter().enumerate().take(j + 1) {
                let [[mut entry]] = products(&scaled, y);
                if k == j {
                    entry += row.compliance;
                }
                for (a, b) in [(j, k), (k, j)] {
                    let row = self.delassus.rows.get_mut(a);
                    if let Some(w) = row.and_then(|row| row.rows.get_mut(b)) {
                        *w = entry;
                    }
                }
            }
        }
    }

    /// Sets the estimate of the relative rounding of `W`: `64 eps` times the largest quotient of an `M_kk` and its pivot, or, where that is
    /// not small, times the largest `M_kk (M⁻¹)_kk`.
    fn measure_uncertainty(&mut self, mass: &[[T; N]; N]) {
        let share = T::literal(GROWTH) * T::EPSILON;
        let mut growth = T::ONE;
        for (mass, reciprocal) in diagonal_of(mass).zip(diagonal_of(&self.mass)) {
            growth = at_least((mass * reciprocal).abs(), growth);
        }
        if share * growth > T::literal(SMALL) {
            growth = at_least(self.largest_mobility(mass), growth);
        }
        self.uncertainty = share * growth;
    }

    /// The largest `M_kk (M⁻¹)_kk`: `M_kk` is the mass that a velocity feels with all others held, `1 / (M⁻¹)_kk` with all of them free. (Of
    /// a pivot those behind it are free.)
    #[cold]
    #[inline(never)]
    fn largest_mobility(&self, mass: &[[T; N]; N]) -> T {
        let mut largest = T::ONE;
        for (k, mass) in diagonal_of(mass).take(self.velocities()).enumerate() {
            let mut whitened = from_fn(|j| if j == k { T::ONE } else { T::ZERO });
            self.whiten(&mut whitened);
            largest = at_least(mass * self.energy(&whitened), largest);
        }
        largest
    }
}

/// Share of the largest inverse mass of a contact below which the inverse mass of another of its rows is mere rounding: the row counts as
/// zero.
pub(super) fn rounding_share<T: Real>() -> T {
    let share = T::literal(16.0) * T::EPSILON;
    share * share
}

/// Has the normal row of a contact a nonzero entry?
pub(super) fn normal_moves<T: Real, const N: usize, const D: usize>(contact: &Contact<T, N, D>) -> bool {
    let columns = contact.jacobian.data.0.iter();
    let mut normal = columns.filter_map(|column| column.first());
    normal.any(|&entry| entry != T::ZERO)
}

/// Writes row `a` of block `W_ij`, and its mirror image, so that `W` is symmetric to the bit, also within a diagonal block. (With a `W`
/// that is not symmetric, a tumbling box gains energy in single precision.)
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

/// `Σ_k x_k y_kᵀ` over the entries `k` of `x` that may differ from zero.
#[inline]
fn products<T: Real, const N: usize, const K: usize, const L: usize>(
    x: &[Scaled<'_, T, N, K>],
    y: &[[T; L]; N],
) -> [[T; L]; K] {
    let mut sums = [[T::ZERO; L]; K];
    for Scaled { index, entry, .. } in x.iter().rev() {
        let Some(y) = y.get(*index) else { break };
        for (sums, &x) in sums.iter_mut().zip(entry) {
            for (sum, &y) in sums.iter_mut().zip(y) {
                *sum += x * y;
            }
        }
    }
    sums
}

#[cfg(test)]
mod tests;
