//! LU factorisation of a matrix that may be singular. It gives the rank, and solves with the matrix and with its transpose.
//!
//! `P A Q = L U` has as many pivots as `A` has rank. Pivots are diagonal entries where these are large enough, otherwise the
//! largest entries (complete pivoting). A solve ignores equations without a pivot. Unknowns without a pivot are free; a solve
//! chooses them so that the solution is the shortest, each unknown times its weight. The columns of the free unknowns store the matrices for that
//! choice ([`Lu::find_null_space`]).

use crate::linalg::stacked::{Stacked, StackedMatrix};
use crate::real::Real;

/// A factorised matrix of some rows and columns, as many as there are contact rows and joint rows at most.
#[derive(Clone, Debug)]
pub(crate) struct Lu<T, const D: usize, const C: usize, const R: usize> {
    matrix: StackedMatrix<T, D, C, R>,
    /// Reciprocals of the pivots.
    reciprocals: Stacked<T, D, C, R>,
    /// Index in `A` of each row of `P A Q`.
    rows: Stacked<usize, D, C, R>,
    /// Index in `A` of each column of `P A Q`.
    columns: Stacked<usize, D, C, R>,
    /// Weight of each column of `A` in the length of a solution.
    weights: Stacked<T, D, C, R>,
    size: usize,
    rank: usize,
}

impl<T: Real, const D: usize, const C: usize, const R: usize> Lu<T, D, C, R> {
    /// All zeros, without rows and columns.
    pub(crate) const fn zero() -> Self {
        Self {
            matrix: StackedMatrix::zero(),
            reciprocals: Stacked::zero(),
            rows: Stacked { contacts: [[0; D]; C], rows: [0; R] },
            columns: Stacked { contacts: [[0; D]; C], rows: [0; R] },
            weights: Stacked::zero(),
            size: 0,
            rank: 0,
        }
    }

    /// Sets the number of rows and columns of [`Self::zero`].
    pub(crate) fn begin(&mut self, size: usize) {
        self.size = size;
        for (index, row) in self.rows.iter_mut().enumerate() {
            *row = index;
        }
        self.columns = self.rows;
    }

    /// The weights of the columns, to be filled in before [`Self::factorise`].
    pub(crate) const fn weights_mut(&mut self) -> &mut Stacked<T, D, C, R> {
        &mut self.weights
    }

    /// The weight of a column of `P A Q`.
    fn weight(&self, column: usize) -> Option<T> {
        self.weights.at(*self.columns.at(column)?).copied()
    }

    /// A row of `A`, to be filled in before [`Self::factorise`].
    pub(crate) fn row_mut(&mut self, row: usize) -> Option<&mut Stacked<T, D, C, R>> {
        self.matrix.row_mut(row)
    }

    pub(crate) const fn size(&self) -> usize {
        self.size
    }

    pub(crate) const fn rank(&self) -> usize {
        self.rank
    }

    /// Factorises the matrix. Elimination ends when no entry exceeds `floor`; such entries count as zero.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn factorise(&mut self, floor: T) -> Option<()> {
        let size = self.size;
        while let Some((row, column)) = self.find_pivot(floor) {
            let k = self.rank;
            self.move_to_pivot(k, row, column)?;
            let source = *self.matrix.row(k)?;
            let reciprocal = T::ONE / *source.at(k)?;
            *self.reciprocals.at_mut(k)? = reciprocal;
            for row in self.matrix.iter_mut().take(size).skip(k + 1) {
                let entry = row.at_mut(k)?;
                if *entry != T::ZERO {
                    let factor = *entry * reciprocal;
                    *entry = factor;
                    row.subtract(factor, &source, k + 1..size);
                }
            }
            self.rank += 1;
        }
        if self.rank < size {
            self.find_null_space()?;
        }
        Some(())
    }

    /// Row and column of the next pivot. The first choice is the next diagonal entry or, if that is below a quarter of the
    /// largest one, the largest. It is taken if it is above `floor` and above a quarter of the largest entry of its row and
    /// column. Otherwise the largest entry of all is taken. (In a semidefinite matrix no entry exceeds the largest diagonal
    /// entry.)
    fn find_pivot(&self, floor: T) -> Option<(usize, usize)> {
        let (k, size) = (self.rank, self.size);
        let diagonal = |i: usize| {
            let entry = self.matrix.row(i).and_then(|row| row.at(i));
            entry.copied().unwrap_or(T::ZERO).abs()
        };
        let (mut largest, mut best) = (T::ZERO, k);
        for i in k..size {
            let size = diagonal(i);
            if size > largest {
                (largest, best) = (size, i);
            }
        }
        let share = T::literal(0.25);
        if diagonal(k) > largest * share {
            best = k;
        }
        let pivot = diagonal(best);
        if pivot > floor {
            let in_row = self.matrix.row(best)?.max(k..size);
            let rows = self.matrix.iter().take(size).skip(k);
            let column = rows.filter_map(|row| row.at(best));
            let in_both = column.fold(in_row, |max, entry| max.max(entry.abs()));
            if pivot > in_both * share {
                return Some((best, best));
            }
        }
        let (mut largest, mut position) = (floor, None);
        for (i, row) in self.matrix.iter().enumerate().take(size).skip(k) {
            let max = row.max(k..size);
            if max > largest {
                (largest, position) = (max, Some((i, row.index_of_max(k..size))));
            }
        }
        position
    }

    /// Exchanges a row and a column with row and column `k`.
    fn move_to_pivot(&mut self, k: usize, row: usize, column: usize) -> Option<()> {
        if row != k {
            self.matrix.swap(k, row)?;
            self.rows.swap(k, row)?;
        }
        if column != k {
            for row in self.matrix.iter_mut().take(self.size) {
                row.swap(k, column)?;
            }
            self.columns.swap(k, column)?;
        }
        Some(())
    }

    /// Computes a basis of the null space, the columns of `N = (-T, I)` with `T = U₁⁻¹ U₂`, over unknowns times their weights. `U₁` has the columns of `U`
    /// with a pivot, `U₂` the free ones. `T` replaces `U₂`. Below it stands the factor `L D Lᵀ` of `Nᵀ N = I + Tᵀ T`, stored as `D Lᵀ`,
    /// with the reciprocals of `D` in `reciprocals`.
    #[cold]
    #[inline(never)]
    fn find_null_space(&mut self) -> Option<()> {
        let (size, rank) = (self.size, self.rank);
        for i in (0..rank).rev() {
            let mut row = *self.matrix.row(i)?;
            for j in i + 1..rank {
                row.subtract(*row.at(j)?, self.matrix.row(j)?, rank..size);
            }
            let reciprocal = *self.reciprocals.at(i)?;
            for c in rank..size {
                *row.at_mut(c)? *= reciprocal;
            }
            *self.matrix.row_mut(i)? = row;
        }
        for i in 0..rank {
            let weight = self.weight(i)?;
            for c in rank..size {
                let share = weight / self.weight(c)?;
                *self.matrix.row_mut(i)?.at_mut(c)? *= share;
            }
        }
        for a in rank..size {
            let mut gram = *self.matrix.row(a)?;
            for c in rank..size {
                *gram.at_mut(c)? = if c == a { T::ONE } else { T::ZERO };
            }
            for i in 0..rank {
                let source = self.matrix.row(i)?;
                gram.subtract(-*source.at(a)?, source, a..size);
            }
            for b in rank..a {
                let source = self.matrix.row(b)?;
                let factor = *source.at(a)? * *self.reciprocals.at(b)?;
                gram.subtract(factor, source, a..size);
            }
            *self.reciprocals.at_mut(a)? = T::ONE / *gram.at(a)?;
            *self.matrix.row_mut(a)? = gram;
        }
        Some(())
    }

    /// A vector of the null space in which no free unknown is 0, in the order of `A`; `None` if the null space is empty.
    pub(crate) fn null_vector(&self) -> Option<Stacked<T, D, C, R>> {
        let (size, rank) = (self.size, self.rank);
        let mut free = Stacked::<T, D, C, R>::zero();
        let mut part = T::ONE;
        for c in rank..size {
            *free.at_mut(c)? = part * self.weight(c)?;
            part *= T::literal(-0.9);
        }
        let mut null = Stacked::zero();
        for (i, &column) in self.columns.iter().enumerate().take(size) {
            let weighted =
                if i < rank { -self.matrix.row(i)?.dot(&free, rank..size) } else { *free.at(i)? };
            *null.at_mut(column)? = weighted / self.weight(i)?;
        }
        (rank < size).then_some(null)
    }

    /// Multiplies by the weights, or divides by them.
    fn scale(&self, x: &mut Stacked<T, D, C, R>, divides: bool) -> Option<()> {
        for (i, x) in x.iter_mut().enumerate().take(self.size) {
            let weight = self.weight(i)?;
            *x = if divides { *x / weight } else { *x * weight };
        }
        Some(())
    }

    /// Projects `x`, each entry times its weight, onto the complement of the null space: `x - N (Nᵀ N)⁻¹ Nᵀ x` with `N = (-T, 1)`.
    fn remove_null_space(&self, x: &mut Stacked<T, D, C, R>) -> Option<()> {
        let (size, rank) = (self.size, self.rank);
        let mut share = *x;
        for (i, &x) in x.iter().enumerate().take(rank) {
            share.subtract(x, self.matrix.row(i)?, rank..size);
        }
        for a in rank..size {
            let known = *share.at(a)? * *self.reciprocals.at(a)?;
            share.subtract(known, self.matrix.row(a)?, a + 1..size);
        }
        for a in (rank..size).rev() {
            let known = self.matrix.row(a)?.dot(&share, a + 1..size);
            let unknown = share.at_mut(a)?;
            *unknown = (*unknown - known) * *self.reciprocals.at(a)?;
        }
        for (i, x) in x.iter_mut().enumerate().take(size) {
            if i < rank {
                *x += self.matrix.row(i)?.dot(&share, rank..size);
            } else {
                *x -= *share.at(i)?;
            }
        }
        Some(())
    }

    /// Solves `U x = y` in place over the pivots.
    fn back_substitute(&self, x: &mut Stacked<T, D, C, R>) -> Option<()> {
        for i in (0..self.rank).rev() {
            let known = self.matrix.row(i)?.dot(x, i + 1..self.rank);
            let unknown = x.at_mut(i)?;
            *unknown = (*unknown - known) * *self.reciprocals.at(i)?;
        }
        Some(())
    }

    /// The shortest solution of the equations with a pivot, and the largest residual of the equations without one.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn solve(&self, b: &Stacked<T, D, C, R>) -> Option<(Stacked<T, D, C, R>, T)> {
        let mut x = Stacked::zero();
        let mut residual = T::ZERO;
        for (i, &row) in self.rows.iter().enumerate().take(self.size) {
            let known = self.matrix.row(i)?.dot(&x, 0..i.min(self.rank));
            let entry = *b.at(row)? - known;
            if i < self.rank {
                *x.at_mut(i)? = entry;
            } else {
                residual = residual.max(entry.abs());
            }
        }
        self.back_substitute(&mut x)?;
        if self.rank < self.size {
            self.scale(&mut x, false)?;
            self.remove_null_space(&mut x)?;
            self.scale(&mut x, true)?;
        }
        let mut ordered = Stacked::zero();
        for (&column, &x) in self.columns.iter().zip(x.iter()).take(self.size) {
            *ordered.at_mut(column)? = x;
        }
        Some((ordered, residual))
    }

    /// The solution of `Aᵀ y = c` that is the transpose of [`Self::solve`].
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn solve_transposed(&self, c: &Stacked<T, D, C, R>) -> Option<Stacked<T, D, C, R>> {
        let mut y = Stacked::zero();
        for (y, &column) in y.iter_mut().zip(self.columns.iter()).take(self.size) {
            *y = *c.at(column)?;
        }
        if self.rank < self.size {
            self.scale(&mut y, true)?;
            self.remove_null_space(&mut y)?;
            self.scale(&mut y, false)?;
        }
        for i in 0..self.rank {
            let known = *y.at(i)? * *self.reciprocals.at(i)?;
            *y.at_mut(i)? = known;
            y.subtract(known, self.matrix.row(i)?, i + 1..self.rank);
        }
        for i in (0..self.rank).rev() {
            let known = *y.at(i)?;
            y.subtract(known, self.matrix.row(i)?, 0..i);
        }
        let mut ordered = Stacked::zero();
        for (&row, &y) in self.rows.iter().zip(y.iter()).take(self.rank) {
            *ordered.at_mut(row)? = y;
        }
        Some(ordered)
    }
}
