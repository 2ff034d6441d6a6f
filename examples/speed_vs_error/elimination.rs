//! Gaussian elimination with partial pivoting, in place, up to `R` unknowns.

use stiction::Real;

pub(crate) struct Elimination<T, const R: usize> {
    rows: [[T; R]; R],
    rhs: [T; R],
    count: usize,
}

impl<T: Real, const R: usize> Elimination<T, R> {
    pub(crate) const fn new() -> Self {
        Self { rows: [[T::ZERO; R]; R], rhs: [T::ZERO; R], count: 0 }
    }

    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    /// One more equation, to be filled in.
    pub(crate) fn push(&mut self) -> (&mut [T; R], &mut T) {
        let row = self.count;
        self.count += 1;
        (&mut self.rows[row], &mut self.rhs[row])
    }

    /// Solves as many equations as were pushed; `None` if they are singular.
    pub(crate) fn solve(&mut self) -> Option<&[T]> {
        let count = self.count;
        for k in 0..count {
            let size = |row: &[T; R]| row[k].abs();
            let mut pivot = k;
            for i in k + 1..count {
                if size(&self.rows[i]) > size(&self.rows[pivot]) {
                    pivot = i;
                }
            }
            self.rows.swap(k, pivot);
            self.rhs.swap(k, pivot);
            let (above, below) = self.rows.split_at_mut(k + 1);
            let top = &above[k][k..count];
            if top[0] == T::ZERO || !top[0].is_finite() {
                return None;
            }
            let reciprocal = T::ONE / top[0];
            let known = self.rhs[k];
            for (row, rhs) in below.iter_mut().zip(&mut self.rhs[k + 1..count]) {
                let row = &mut row[k..count];
                let factor = row[0] * reciprocal;
                if factor != T::ZERO {
                    for (entry, &pivot) in row.iter_mut().zip(top) {
                        *entry -= factor * pivot;
                    }
                    *rhs -= factor * known;
                }
            }
        }
        for k in (0..count).rev() {
            let row = &self.rows[k][k..count];
            let (head, tail) = self.rhs.split_at_mut(k + 1);
            let later = row[1..].iter().zip(&tail[..count - k - 1]);
            let sum = later.fold(head[k], |sum, (&entry, &x)| sum - entry * x);
            head[k] = sum / row[0];
        }
        Some(&self.rhs[..count])
    }
}
