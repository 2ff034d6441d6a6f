//! Scenes of which `W` and `q` are given instead of `M` and `H`.

use super::Scene;
use super::checks::fingerprint;
use crate::error::{Error, Input};
use crate::linalg::sparsity::Support;
use crate::linalg::stacked::{Counts, Stacked};
use crate::real::Real;
use nalgebra::{ArrayStorage, SMatrix};

/// The root of `W`, column by column.
type Root<T, const N: usize, const D: usize, const C: usize, const R: usize> =
    [Stacked<T, D, C, R>; N];

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Scene<T, N, D, C, R, S>
{
    /// Takes the Delassus operator `W = H M⁻¹ Hᵀ` in place of `M` and `H`, for dynamics that give it directly.
    ///
    /// Push contacts and joint rows first, with any Jacobian and with `q_i = H_i v_free + w_i` as offsets, and solve with a free
    /// impulse of 0. `W` is row by row (or column by column), `D` for each contact and then one for each joint row, symmetric,
    /// without compliance, and may be singular: `N` has to be its rank at least, for which the number of generalised velocities is
    /// always enough.
    ///
    /// `M` and the Jacobians of before are lost: a scene that gets others needs [`Self::clear`] and a mass again, and without one is
    /// not solved ([`Error::MassNotPositiveDefinite`]).
    ///
    /// Internally `M` is the unit matrix and `H` a root of `W`, found by Cholesky's factorisation with pivots. So the velocity of a
    /// solution has no meaning, and its error in the dynamics is rounding: what "solved" promises is the error of the
    /// contacts and joint rows, for the `W` that was given. By how much `H Hᵀ` differs from it counts as rounding of their
    /// velocities.
    ///
    /// ```
    /// use nalgebra::{matrix, vector};
    /// use stiction::{Contact, Kernel, Settings};
    ///
    /// // 2 kg on a floor, pushed sideways: W = 1/m, q = v_free.
    /// let mut kernel = Kernel::<f64, 2, 2, 1>::new();
    /// let (jacobian, offset) = (matrix![0.0, 0.0; 0.0, 0.0], vector![-0.01, 0.02]);
    /// kernel.scene_mut().push(&Contact { jacobian, offset, mu: 0.5, key: 0 })?;
    /// kernel.scene_mut().set_delassus(&[0.5, 0.0, 0.0, 0.5])?;
    /// let solution = kernel.solve(&vector![0.0, 0.0], &Settings::new(1e-9))?;
    /// assert!((solution.contacts[0].impulse - vector![0.02, -0.01]).norm() < 1e-9); // m v, mu of it
    /// # Ok::<(), stiction::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::DelassusSize`] if it has not as many entries as there are pairs of rows; [`Error::NotFinite`];
    /// [`Error::DelassusNotGram`] if it is not symmetric, not positive semidefinite, or of a rank above `N`. The scene stays what
    /// it was.
    pub fn set_delassus(&mut self, delassus: &[T]) -> Result<(), Error> {
        self.refused.mass = true; // until the end
        let counts = self.counts;
        let size = D * counts.contacts + counts.rows;
        let wanted = size * size;
        if delassus.len() != wanted {
            return Err(Error::DelassusSize { wanted });
        }
        if let Some(place) = delassus.iter().position(|entry| !entry.is_finite()) {
            return Err(Error::NotFinite {
                input: Input::Delassus,
                row: place.checked_div(size).unwrap_or(0),
                column: place.checked_rem(size).unwrap_or(0),
            });
        }
        let root: Root<T, N, D, C, R> = root(delassus, counts);
        self.delassus_gap = gap(delassus, &root, counts)?;
        self.mass = SMatrix::from_array_storage(ArrayStorage([[T::ZERO; N]; N]));
        for (j, column) in self.mass.data.0.iter_mut().enumerate() {
            if let Some(entry) = column.get_mut(j) {
                *entry = T::ONE;
            }
        }
        let print = fingerprint(self.mass.as_slice(), C + R);
        self.mass_print = Some(self.delassus_gap.hash(print));
        let contacts = self.contacts.iter_mut().zip(&mut self.supports);
        for (i, (contact, support)) in contacts.enumerate().take(counts.contacts) {
            for (column, root) in contact.jacobian.data.0.iter_mut().zip(&root) {
                *column = root.contacts.get(i).copied().unwrap_or([T::ZERO; D]);
            }
            *support = Support::all();
        }
        for (j, row) in self.rows.iter_mut().enumerate().take(counts.rows) {
            for (entry, root) in row.row.iter_mut().zip(&root) {
                *entry = root.rows.get(j).copied().unwrap_or(T::ZERO);
            }
        }
        self.contacts_print = self.prints_of_contacts();
        self.rows_print = self.prints_of_rows();
        self.refused.mass = false;
        Ok(())
    }

    /// Takes away the unit matrix in place of a mass, if there is one: Jacobians come that are no roots of a `W`.
    pub(super) fn forget_delassus(&mut self) {
        if self.delassus_gap > T::ZERO {
            self.mass = SMatrix::from_array_storage(ArrayStorage([[T::ZERO; N]; N]));
            (self.mass_print, self.delassus_gap) = (None, T::ZERO);
        }
    }
}

/// `W_ab`
fn entry<T: Real>(delassus: &[T], size: usize, a: usize, b: usize) -> T {
    delassus.get(a * size + b).copied().unwrap_or(T::ZERO)
}

/// `H` with `H Hᵀ = W`: pivots are the rows that are known least, relative to their own entry.
#[inline(never)]
fn root<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    delassus: &[T],
    counts: Counts,
) -> Root<T, N, D, C, R> {
    let size = D * counts.contacts + counts.rows;
    let mut root = [Stacked::zero(); N];
    // Share of the diagonal entry that is left; none of a row that was a pivot. (Where nearly nothing is left of the diagonal,
    // the rest of the row may be its root.)
    let mut left: Stacked<T, D, C, R> = Stacked::zero();
    left.iter_mut().for_each(|left| *left = T::ONE);
    for column in 0..N {
        let mut pivot = (T::EPSILON * T::literal(8.0), None);
        for (a, &left) in left.in_use(counts).enumerate() {
            if left > pivot.0 && entry(delassus, size, a, a) > T::ZERO {
                pivot = (left, Some(a));
            }
        }
        let Some(p) = pivot.1 else { break };
        let scale = T::ONE / (pivot.0 * entry(delassus, size, p, p)).square_root();
        let mut new = Stacked::<T, D, C, R>::zero();
        for (a, new) in new.in_use_mut(counts).enumerate() {
            *new = entry(delassus, size, p, a);
        }
        for done in root.iter().take(column) {
            let own = done.in_use(counts).nth(p).copied().unwrap_or(T::ZERO);
            for (new, &x) in new.in_use_mut(counts).zip(done.in_use(counts)) {
                *new -= own * x;
            }
        }
        new.in_use_mut(counts).for_each(|new| *new *= scale);
        let shares = left.in_use_mut(counts).zip(new.in_use(counts));
        for (a, (share, &new)) in shares.enumerate() {
            *share -= new * new / entry(delassus, size, a, a).max(T::EPSILON * new * new);
            if a == p {
                *share = T::ZERO;
            }
        }
        if let Some(place) = root.get_mut(column) {
            *place = new;
        }
    }
    root
}

/// By how much `H Hᵀ` differs from `W`: the largest difference of `W_ab` over `sqrt(W_aa W_bb)`, and what rounding hides of it.
/// An error if that is more than the rounding of as many sums as there are.
#[inline(never)]
fn gap<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    delassus: &[T],
    root: &Root<T, N, D, C, R>,
    counts: Counts,
) -> Result<T, Error> {
    let size = D * counts.contacts + counts.rows;
    let rounding = T::EPSILON * T::count(4 * (N + size));
    // Half an `eps` for each operation of a product.
    let (hidden, mut largest) = (T::EPSILON * T::count(N + 2) * T::literal(0.5), T::ZERO);
    for row in 0..size {
        let mut products = Stacked::<T, D, C, R>::zero();
        for column in root {
            let own = column.in_use(counts).nth(row).copied().unwrap_or(T::ZERO);
            for (product, &x) in products.in_use_mut(counts).zip(column.in_use(counts)) {
                *product += own * x;
            }
        }
        for (column, &product) in products.in_use(counts).enumerate() {
            let own = |a: usize| entry(delassus, size, a, a).abs();
            let mut scale = (own(row) * own(column)).square_root();
            if scale * scale < T::least_normal() {
                scale = own(row).square_root() * own(column).square_root(); // no product that vanishes
            }
            let gap = (product - entry(delassus, size, row, column)).abs();
            let is_near = gap <= rounding * scale || gap < T::least_normal();
            if !is_near {
                return Err(Error::DelassusNotGram { row, column });
            }
            if gap > largest * scale {
                largest = gap / scale;
            }
        }
    }
    Ok(largest + hidden)
}
