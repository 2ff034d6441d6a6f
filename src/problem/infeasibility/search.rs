//! The search for a proof that a scene has no solution, see [`super`].
//!
//! The active-set method of Lawson and Hanson (1974) minimises `dᵀ W d + (g·d + 1)²` over the `d` that the demands allow. Inverse
//! iteration then moves the minimiser into the null space of `W`.

use super::{Proof, dot};
use crate::linalg::elimination::Elimination;
use crate::linalg::stacked::{Stacked, StackedMatrix};
use crate::linalg::vector::at_least;
use crate::linalg::zip::{zip3, zip4};
use crate::real::Real;

/// Share of the largest entry of a proof, below which another has no part in it.
const NO_PART: f64 = 1e-6;

/// The condition of a row on its velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Demand {
    /// Any velocity; `d` is 0 there.
    Nothing,
    /// A velocity `>= 0`; `d` is not negative there.
    NotNegative,
    /// The velocity 0; `d` may have either sign there.
    Zero,
}

impl Demand {
    /// Does this velocity violate the condition?
    pub(super) fn is_violated<T: Real>(self, velocity: T) -> bool {
        match self {
            Self::Nothing => false,
            Self::NotNegative => velocity < T::ZERO,
            Self::Zero => velocity != T::ZERO,
        }
    }
}

/// The quadratic form of the search, over rows scaled to unit effective mass.
pub(super) struct Search<T, const C: usize, const R: usize> {
    pub(super) demands: Proof<Demand, C, R>,
    /// `W` with a unit diagonal, over the rows with a demand.
    pub(super) gram: StackedMatrix<T, 1, C, R>,
    /// `g`, the offsets in the scaled rows.
    pub(super) offsets: Proof<T, C, R>,
}

impl<T: Real, const C: usize, const R: usize> Search<T, C, R> {
    /// The rows of `W`.
    fn rows(&self) -> impl Iterator<Item = &Proof<T, C, R>> {
        self.gram.contacts.as_flattened().iter().chain(&self.gram.rows)
    }

    /// Minimises `dᵀ W d + (g·d / size + 1)²` over the `d` that the demands allow; `None` if the minimum is near 1.
    #[inline(never)]
    pub(super) fn minimise(&self, size: T) -> Option<Proof<T, C, R>> {
        let mut d: Proof<T, C, R> = Proof::zero();
        let mut support = Proof { contacts: [[false]; C], rows: [false; R] };
        let mut g = self.offsets;
        for g in g.iter_mut() {
            *g /= size;
        }
        for _ in 0..4 * (C + R) {
            let rounding = d.iter().fold(T::ONE, |sum, d| sum + d.abs()) * T::EPSILON;
            let approach = T::ONE + dot(&g, &d);
            let mut steepest = rounding * T::literal(64.0);
            let mut entering = None;
            let (demands, used) = (self.demands.iter(), support.iter_mut());
            for (row, demand, &g, used) in zip4(self.rows(), demands, g.iter(), used) {
                let slope = -(dot(row, &d) + g * approach);
                let descent = match demand {
                    Demand::Nothing => T::ZERO,
                    Demand::NotNegative => slope,
                    Demand::Zero => slope.abs(),
                };
                if descent > steepest && !*used {
                    (steepest, entering) = (descent, Some(used));
                }
            }
            let Some(used) = entering else { break };
            *used = true;
            self.descend(&mut d, &mut support, &g, rounding);
        }
        (T::ONE + dot(&g, &d) <= T::literal(0.999)).then_some(d)
    }

    /// Moves `d` to the minimiser on the support. Entries that would become negative, although they may not, leave the support.
    fn descend(
        &self,
        d: &mut Proof<T, C, R>,
        support: &mut Proof<bool, C, R>,
        g: &Proof<T, C, R>,
        rounding: T,
    ) {
        while let Some(negative) = self.solve(support, T::ONE, g, g) {
            let mut length = T::ONE;
            for (demand, &d, &target) in zip3(self.demands.iter(), d.iter(), negative.iter()) {
                // The minimiser is `-target`, since the right-hand side is `g` and not `-g`.
                let leaves = *demand == Demand::NotNegative && -target <= T::ZERO && d > T::ZERO;
                if leaves {
                    length = length.min(d / (d + target));
                }
            }
            let mut has_shrunk = false;
            let (demands, used) = (self.demands.iter(), support.iter_mut());
            for (demand, used, d, &target) in zip4(demands, used, d.iter_mut(), negative.iter()) {
                *d += (-target - *d) * length;
                if *used && *demand == Demand::NotNegative && *d <= rounding {
                    (*used, has_shrunk) = (false, true);
                }
                if !*used {
                    *d = T::ZERO;
                }
            }
            if !has_shrunk {
                break;
            }
        }
    }

    /// Moves `d` into the null space of `W`, by inverse iteration on its support. Entries that have no part in it leave the support: those of the
    /// minimiser are rounding there, and may become negative.
    #[inline(never)]
    pub(super) fn purify(&self, d: &mut Proof<T, C, R>) -> Option<()> {
        for _ in 0..4 {
            self.normalise(d);
            *d = self.solve(&support(d), T::ZERO, &self.offsets, d)?;
        }
        self.normalise(d);
        Some(())
    }

    /// Scales `d` to a largest entry of 1, and sets those to zero that are tiny or not allowed.
    fn normalise(&self, d: &mut Proof<T, C, R>) {
        let largest = d.iter().fold(T::ZERO, |largest, d| at_least(d.abs(), largest));
        for (d, demand) in d.iter_mut().zip(self.demands.iter()) {
            *d /= largest;
            let size = if *demand == Demand::Zero { d.abs() } else { *d };
            if size < T::literal(NO_PART) {
                *d = T::ZERO;
            }
        }
    }

    /// Subtracts from `d` a correction with the product `residual` with `W`: one step of iterative refinement.
    pub(super) fn correct(&self, d: &mut Proof<T, C, R>, residual: &Proof<T, C, R>) -> Option<()> {
        let correction = self.solve(&support(d), T::ZERO, &self.offsets, residual)?;
        for (d, demand, &correction) in zip3(d.iter_mut(), self.demands.iter(), correction.iter()) {
            *d -= correction;
            if *demand != Demand::Zero {
                *d = (*d).max(T::ZERO);
            }
        }
        Some(())
    }

    /// The solution of `(W + weight g gᵀ + δI) x = b` on a support, with `x = 0` elsewhere.
    fn solve(
        &self,
        support: &Proof<bool, C, R>,
        weight: T,
        g: &Proof<T, C, R>,
        b: &Proof<T, C, R>,
    ) -> Option<Proof<T, C, R>> {
        let count = support.iter().filter(|&&used| used).count();
        let ridge = T::EPSILON * T::count(4 * count);
        let mut elimination = Elimination::none();
        let contacts = support.contacts.iter().map(|&[used]| usize::from(used));
        let rows = support.rows.iter().filter(|&&used| used).count();
        elimination.lay_out(contacts, rows);
        // The rows and columns of the support, without gaps.
        let mut matrix = StackedMatrix::zero();
        let mut unknowns = repack(b, support, true);
        let mut next_row = 0;
        for (i, row, &used, &factor) in zip4(0..C + R, self.rows(), support.iter(), g.iter()) {
            if !used {
                continue;
            }
            let mut entries = *row;
            for (entry, &g) in entries.iter_mut().zip(g.iter()) {
                *entry += weight * factor * g;
            }
            *entries.iter_mut().nth(i)? += ridge;
            let target = if i < C {
                matrix.contacts.get_mut(i)?.first_mut()?
            } else {
                next_row += 1;
                matrix.rows.get_mut(next_row - 1)?
            };
            *target = repack(&entries, support, true);
        }
        elimination.factorise(&mut matrix, true)?;
        if !elimination.is_positive() {
            return None;
        }
        elimination.solve(&matrix, &mut unknowns)?;
        Some(repack(&unknowns, support, false))
    }
}

/// Moves the entries of a support to the front, among contacts and among joint rows. With `compact` false it moves them back, with zeros
/// outside the support.
fn repack<T: Real, const C: usize, const R: usize>(
    x: &Proof<T, C, R>,
    support: &Proof<bool, C, R>,
    compact: bool,
) -> Proof<T, C, R> {
    let mut moved = Stacked::zero();
    let copy = |source: &[T], target: &mut [T], used: &[bool]| {
        let indices = used.iter().enumerate().filter(|&(_, &used)| used);
        let indices = indices.map(|(index, _)| index);
        for (front, index) in indices.enumerate() {
            let (from, to) = if compact { (index, front) } else { (front, index) };
            if let (Some(&source), Some(target)) = (source.get(from), target.get_mut(to)) {
                *target = source;
            }
        }
    };
    copy(x.contacts.as_flattened(), moved.contacts.as_flattened_mut(), support.contacts.as_flattened());
    copy(&x.rows, &mut moved.rows, &support.rows);
    moved
}

/// The rows in which `d` is not zero.
fn support<T: Real, const C: usize, const R: usize>(d: &Proof<T, C, R>) -> Proof<bool, C, R> {
    Proof { contacts: d.contacts.map(|[d]| [d != T::ZERO]), rows: d.rows.map(|d| d != T::ZERO) }
}
