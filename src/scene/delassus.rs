//! Scenes of which `W` and `q` are given instead of `M` and `H`.

use super::Scene;
use super::checks::{check_finite, fingerprint};
use crate::laws::Laws;
use crate::linalg::hints::rolled;
use crate::linalg::sparsity::Support;
use crate::{Error, Input, Real};
use nalgebra::{ArrayStorage, SMatrix};

impl<T: Real, const N: usize, const D: usize, const C: usize, L: Laws> Scene<T, N, D, C, L> {
    /// Takes the Delassus operator `W = H M⁻¹ Hᵀ` in place of `M` and `H`, for dynamics that give it directly.
    ///
    /// Push the contacts first, with any Jacobian and with `q_i = H_i v_free + w_i` as offsets, and solve with a free impulse
    /// of 0. `W` is row by row in blocks of `D` rows a contact, symmetric, without compliance, and may be singular: `N` has
    /// to be its rank at least, for which the number of generalised velocities is always enough.
    ///
    /// Internally `M` is the unit matrix and `H` a root of `W`, found by Cholesky's factorisation with pivots. So the velocity of a
    /// solution has no meaning, and its error in the dynamics is rounding: what "solved" promises is the error of the
    /// contacts, for the `W` that was given. By how much `H Hᵀ` differs from it counts as rounding of their velocities.
    ///
    /// ```
    /// use nalgebra::{matrix, vector};
    /// use stiction::{Contact, Factor, Scene, Settings, Solver};
    ///
    /// // 2 kg on a floor, pushed sideways: W = 1/m, q = v_free.
    /// let mut scene = Scene::<f64, 2, 2, 1>::new();
    /// let (jacobian, offset) = (matrix![0.0, 0.0; 0.0, 0.0], vector![-0.01, 0.02]);
    /// scene.push(&Contact { jacobian, offset, mu: 0.5, key: 0 })?;
    /// scene.set_delassus(&[[[[0.5, 0.0]], [[0.0, 0.5]]]])?;
    /// let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
    /// let solution = solver.solve(&scene, &factor, &vector![0.0, 0.0], &Settings::new(1e-9))?;
    /// assert!((solution.contacts[0].impulse - vector![0.02, -0.01]).norm() < 1e-9); // m v, mu of it
    /// # Ok::<(), stiction::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::DelassusNotGram`] if it is not symmetric, not positive semidefinite, or of a rank above
    /// `N`. The scene stays what it was.
    pub fn set_delassus(&mut self, delassus: &[[[[T; D]; C]; D]; C]) -> Result<(), Error> {
        let used = delassus.get(..self.count).unwrap_or_default();
        for row in used.as_flattened() {
            let row = SMatrix::from_array_storage(ArrayStorage(*row));
            check_finite(&row, Input::Delassus)?;
        }
        let root = root(used);
        let gap = gap(used, &root)?;
        self.mass = SMatrix::from_array_storage(ArrayStorage([[T::ZERO; N]; N]));
        for (j, column) in self.mass.data.0.iter_mut().enumerate() {
            if let Some(entry) = column.get_mut(j) {
                *entry = T::ONE;
            }
        }
        self.delassus_gap = gap;
        self.mass_print = fingerprint(self.mass.as_slice(), C);
        self.contacts_print = 0;
        for (i, root) in root.into_iter().enumerate().take(self.count) {
            if let Some(contact) = self.contacts.get_mut(i) {
                contact.jacobian.data.0 = root;
            }
            if let Some(support) = self.supports.get_mut(i) {
                *support = Support::all();
            }
            self.contacts_print = self.contacts_print.wrapping_add(self.contact_print(i));
        }
        Ok(())
    }
}

/// `H` with `H Hᵀ = W`, contact by contact in columns: pivots are the rows that are known least, relative to their own
/// entry.
#[inline(never)]
fn root<T: Real, const N: usize, const D: usize, const C: usize>(
    delassus: &[[[[T; D]; C]; D]],
) -> [[[T; D]; N]; C] {
    let mut root = [[[T::ZERO; D]; N]; C];
    // Share of the diagonal entry that is left; none of a row that was a pivot. (Where nearly nothing is left of the diagonal,
    // the rest of the row may be its root.)
    let mut left = [[Some(T::ONE); D]; C];
    let entry = |i: usize, k: usize, j: usize, l: usize| {
        let row = delassus.get(i).and_then(|rows| rows.get(k));
        let block = row.and_then(|row| row.get(j));
        block
            .and_then(|block| block.get(l))
            .copied()
            .unwrap_or(T::ZERO)
    };
    let floor = T::EPSILON * T::literal(8.0);
    for column in 0..N {
        let mut pivot = (floor, None);
        for (i, left) in left.iter().enumerate().take(delassus.len()) {
            for (k, left) in left.iter().enumerate() {
                let left = left.unwrap_or(T::ZERO);
                if left > pivot.0 && entry(i, k, i, k) > T::ZERO {
                    pivot = (left, Some((i, k)));
                }
            }
        }
        let Some((p, q)) = pivot.1 else { break };
        let mut row = [T::ZERO; N];
        for (entry, columns) in row.iter_mut().zip(root.get(p).into_iter().flatten()) {
            *entry = columns.get(q).copied().unwrap_or(T::ZERO);
        }
        let scale = T::ONE / (pivot.0 * entry(p, q, p, q)).square_root();
        let slots = root.iter_mut().zip(&mut left).enumerate();
        for (i, (columns, left)) in slots.take(delassus.len()) {
            rolled();
            for (k, left) in left.iter_mut().enumerate() {
                let known = columns
                    .iter()
                    .zip(&row)
                    .fold(T::ZERO, |sum, (column, &row)| {
                        sum + column.get(k).copied().unwrap_or(T::ZERO) * row
                    });
                let new = (entry(p, q, i, k) - known) * scale;
                let target = columns.get_mut(column).and_then(|column| column.get_mut(k));
                if let (Some(target), Some(share)) = (target, left.as_mut()) {
                    *target = new;
                    *share -= new * new / entry(i, k, i, k).max(T::EPSILON * new * new);
                }
                if (i, k) == (p, q) {
                    *left = None;
                }
            }
        }
    }
    root
}

/// By how much `H Hᵀ` differs from `W`: the largest difference of `W_ab` over `sqrt(W_aa W_bb)`, and what rounding hides of it.
/// An error if that is more than the rounding of as many sums as there are.
#[inline(never)]
fn gap<T: Real, const N: usize, const D: usize, const C: usize>(
    delassus: &[[[[T; D]; C]; D]],
    root: &[[[T; D]; N]; C],
) -> Result<T, Error> {
    let count = delassus.len();
    let rounding = T::EPSILON * T::count(4 * (N + count * D));
    // Half an `eps` for each operation of a product.
    let (hidden, mut largest) = (T::EPSILON * T::count(N + 2) * T::literal(0.5), T::ZERO);
    let rows = || {
        delassus
            .iter()
            .zip(root)
            .flat_map(|(rows, root)| rows.iter().zip((0..).zip([root; D])))
    };
    let own = |index: usize| {
        let row = delassus
            .as_flattened()
            .get(index)
            .map(|row| row.as_flattened());
        row.and_then(|row| row.get(index))
            .copied()
            .unwrap_or(T::ZERO)
    };
    for (row, (entries, (k, root_row))) in rows().enumerate() {
        let columns = root
            .iter()
            .take(count)
            .flat_map(|root| (0..D).map(move |l| (l, root)));
        for (column, (&entry, (l, root_column))) in
            entries.as_flattened().iter().zip(columns).enumerate()
        {
            let pairs = root_row.iter().zip(root_column);
            let product = pairs.fold(T::ZERO, |sum, (x, y)| {
                let x = x.get(k).copied().unwrap_or(T::ZERO);
                sum + x * y.get(l).copied().unwrap_or(T::ZERO)
            });
            let size = (own(row).abs() * own(column).abs()).square_root();
            let gap = (product - entry).abs();
            let is_near = gap <= rounding * size;
            if !is_near {
                return Err(Error::DelassusNotGram { row, column });
            }
            if gap > largest * size {
                largest = gap / size;
            }
        }
    }
    Ok(largest + hidden)
}
