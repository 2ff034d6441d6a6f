//! Hyperstatic scenes: impulses that can change without moving a body.

use crate::linalg::cholesky::factorise;
use crate::linalg::stacked::Stacked;
use crate::problem::Problem;
use crate::real::Real;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Problem<'_, T, N, D, C, R, S>
{
    /// Is the scene hyperstatic at these impulses: can they change without moving a body? `rows` is the number of rows whose impulses count
    /// as unknown.
    ///
    /// It is with rows >= moved dofs + `D`. With fewer, but no fewer than moved dofs, it is if all contacts that push stick and their rows and
    /// those that hold depend on one another, as those of a rod on two points. (Between slipping contacts the friction is known.)
    pub(crate) fn is_hyperstatic(&self, r: &Stacked<T, D, C, R>, rows: usize) -> bool {
        let moved = self.factor.moved();
        let all_stick = || self.sets.free_rows(r) == self.sets.holding_rows(r);
        let are_dependent = || rows > moved || rows == moved && !self.has_full_rank(r);
        self.makes_hyperstatic(rows) || rows >= moved && all_stick() && are_dependent()
    }

    /// Are the rows independent that push or hold at these impulses? A row that moves nothing does not count.
    #[inline(never)]
    fn has_full_rank(&self, r: &Stacked<T, D, C, R>) -> bool {
        let mut holding = self.sets.holding(r);
        let delassus = self.factor.delassus();
        for (i, holding) in holding.contacts.iter_mut().enumerate() {
            for (k, holds) in holding.iter_mut().enumerate() {
                *holds &= delassus.inverse_mass(i, k) > T::ZERO;
            }
        }
        for (j, holds) in holding.rows.iter_mut().enumerate() {
            *holds &= delassus.row_inverse_mass(j) > T::ZERO;
        }
        // Of the matrix the lower triangle is read: rows of contacts come before joint rows.
        let (mut matrix, mut rows) = ([[T::ZERO; N]; N], 0);
        let mut targets = matrix.iter_mut();
        let contacts = delassus.contacts.as_flattened().iter().zip(holding.contacts.as_flattened());
        for (source, _) in contacts.filter(|&(_, &holds)| holds) {
            let Some(target) = targets.next() else { return false };
            gather(source.as_flattened().iter().zip(holding.contacts.as_flattened()), target);
            rows += 1;
        }
        for (source, _) in delassus.rows.iter().zip(&holding.rows).filter(|&(_, &holds)| holds) {
            let Some(target) = targets.next() else { return false };
            gather(source.iter().zip(holding.iter()), target);
            rows += 1;
        }
        let mut factor = matrix;
        factorise((&matrix, rows), T::EPSILON * T::literal(256.0), &mut factor, &mut [usize::MAX; N]).is_ok()
    }

    /// Would the scene be hyperstatic if all contacts and joint rows pushed?
    pub(crate) fn may_be_hyperstatic(&self) -> bool {
        self.makes_hyperstatic(self.sets.pushing_rows())
    }

    /// Are there more rows than moved dofs? Then Coulomb's law may have a second solution.
    pub(crate) fn has_spare_rows(&self) -> bool {
        self.sets.pushing_rows() > self.factor.moved()
    }

    /// Is this number of rows at least moved dofs + `D`?
    pub(crate) fn makes_hyperstatic(&self, rows: usize) -> bool {
        rows >= self.factor.moved().saturating_add(D)
    }
}

/// Fills a row with the entries that are held.
fn gather<'a, T: Real>(entries: impl Iterator<Item = (&'a T, &'a bool)>, row: &mut [T]) {
    let held = entries.filter_map(|(&entry, &holds)| holds.then_some(entry));
    row.iter_mut().zip(held).for_each(|(target, entry)| *target = entry);
}
