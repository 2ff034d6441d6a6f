//! The search for a proof that a scene has no solution, see [`super`].
//!
//! It minimises `dᵀ W d + (g·d + 1)²` over the `d` that demands allow with the active-set method of Lawson and Hanson (1974).
//! Inverse iteration then brings the minimiser to the null space of `W`.

use super::Proof;
use crate::linalg::elimination::Elimination;
use crate::linalg::stacked::{Stacked, StackedMatrix};
use crate::linalg::vector::at_least;
use crate::real::Real;

/// What a row asks of its velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Demand {
    Nothing,
    NotNegative,
    Zero,
}

impl Demand {
    /// Is that another velocity than this one?
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
    /// `W` with a unit diagonal, of the rows that ask for anything.
    pub(super) gram: StackedMatrix<T, 1, C, R>,
    /// `g`: offsets scaled likewise.
    pub(super) offsets: Proof<T, C, R>,
}

fn dot<T: Real, const C: usize, const R: usize>(x: &Proof<T, C, R>, y: &Proof<T, C, R>) -> T {
    x.iter()
        .zip(y.iter())
        .fold(T::ZERO, |sum, (&x, &y)| sum + x * y)
}

impl<T: Real, const C: usize, const R: usize> Search<T, C, R> {
    /// The rows of `W`.
    fn rows(&self) -> impl Iterator<Item = &Proof<T, C, R>> {
        self.gram
            .contacts
            .as_flattened()
            .iter()
            .chain(&self.gram.rows)
    }

    /// Minimises `dᵀ W d + (g·d / size + 1)²` over the `d` that demands allow; `None` if that stays near 1.
    #[inline(never)]
    pub(super) fn minimise(&self, size: T) -> Option<Proof<T, C, R>> {
        let mut d: Proof<T, C, R> = Proof::zero();
        let mut support = Proof {
            contacts: [[false]; C],
            rows: [false; R],
        };
        let mut g = self.offsets;
        for g in g.iter_mut() {
            *g /= size;
        }
        for _ in 0..4 * (C + R) {
            let rounding = d.iter().fold(T::ONE, |sum, d| sum + d.abs()) * T::EPSILON;
            let approach = T::ONE + dot(&g, &d);
            let mut steepest = rounding * T::literal(64.0);
            let mut entering = None;
            let rows = self.rows().zip(self.demands.iter()).zip(g.iter());
            for (((row, demand), &g), used) in rows.zip(support.iter_mut()) {
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

    /// Goes to the minimiser on the support, and out of it what becomes negative and may not.
    fn descend(
        &self,
        d: &mut Proof<T, C, R>,
        support: &mut Proof<bool, C, R>,
        g: &Proof<T, C, R>,
        rounding: T,
    ) {
        while let Some(minimiser) = self.solve(support, T::ONE, g, g) {
            let mut length = T::ONE;
            let rows = self.demands.iter().zip(d.iter().zip(minimiser.iter()));
            for (demand, (&d, &target)) in rows {
                // `minimiser` is that of `-g`.
                let leaves = *demand == Demand::NotNegative && -target <= T::ZERO && d > T::ZERO;
                if leaves {
                    length = length.min(d / (d + target));
                }
            }
            let mut left = false;
            let rows = self.demands.iter().zip(support.iter_mut());
            for ((demand, used), (d, &target)) in rows.zip(d.iter_mut().zip(minimiser.iter())) {
                *d += (-target - *d) * length;
                if *used && *demand == Demand::NotNegative && *d <= rounding {
                    (*used, left) = (false, true);
                }
                if !*used {
                    *d = T::ZERO;
                }
            }
            if !left {
                break;
            }
        }
    }

    /// Inverse iteration on the support of `d`: what is not in the null space dies out.
    #[inline(never)]
    pub(super) fn purify(&self, d: &mut Proof<T, C, R>) -> Option<()> {
        let support = support(d);
        for _ in 0..3 {
            normalise(d);
            *d = self.solve(&support, T::ZERO, &self.offsets, d)?;
        }
        normalise(d);
        for d in d.iter_mut() {
            if d.abs() < T::EPSILON * T::literal(64.0) {
                *d = T::ZERO;
            }
        }
        let mut rows = d.iter().zip(self.demands.iter());
        let allowed = |(&d, demand): (&T, &Demand)| *demand == Demand::Zero || d >= T::ZERO;
        rows.all(allowed).then_some(())
    }

    /// Takes away what gives this product with `W`.
    pub(super) fn correct(&self, d: &mut Proof<T, C, R>, left: &Proof<T, C, R>) -> Option<()> {
        let correction = self.solve(&support(d), T::ZERO, &self.offsets, left)?;
        let entries = d.iter_mut().zip(self.demands.iter());
        for ((d, demand), &correction) in entries.zip(correction.iter()) {
            *d -= correction;
            if *demand != Demand::Zero {
                *d = (*d).max(T::ZERO);
            }
        }
        Some(())
    }

    /// Solves `(W + weight g gᵀ + δI) x = b` on a support, zero elsewhere.
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
        // The rows and columns of the support, close together.
        let mut matrix = StackedMatrix::zero();
        let mut unknowns = compact(b, support, true);
        let sources = self.rows().zip(support.iter()).zip(g.iter());
        let mut next_row = 0;
        for (i, ((row, &used), &factor)) in sources.enumerate() {
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
            *target = compact(&entries, support, true);
        }
        elimination.factorise(&mut matrix, true)?;
        if !elimination.is_positive() {
            return None;
        }
        elimination.solve(&matrix, &mut unknowns)?;
        Some(compact(&unknowns, support, false))
    }
}

/// Brings the entries of a support close together, contacts and joint rows apart; or back to their places, with zeros elsewhere.
fn compact<T: Real, const C: usize, const R: usize>(
    x: &Proof<T, C, R>,
    support: &Proof<bool, C, R>,
    together: bool,
) -> Proof<T, C, R> {
    let mut moved = Stacked::zero();
    let place = |source: &[T], target: &mut [T], used: &[bool]| {
        let places = used.iter().enumerate().filter(|&(_, &used)| used);
        for (close, (apart, _)) in places.enumerate() {
            let (from, to) = if together {
                (apart, close)
            } else {
                (close, apart)
            };
            if let (Some(&source), Some(target)) = (source.get(from), target.get_mut(to)) {
                *target = source;
            }
        }
    };
    place(
        x.contacts.as_flattened(),
        moved.contacts.as_flattened_mut(),
        support.contacts.as_flattened(),
    );
    place(&x.rows, &mut moved.rows, &support.rows);
    moved
}

/// Rows that are not zero.
fn support<T: Real, const C: usize, const R: usize>(d: &Proof<T, C, R>) -> Proof<bool, C, R> {
    Proof {
        contacts: d.contacts.map(|[d]| [d != T::ZERO]),
        rows: d.rows.map(|d| d != T::ZERO),
    }
}

/// Scales to a largest entry of 1.
fn normalise<T: Real, const C: usize, const R: usize>(d: &mut Proof<T, C, R>) {
    let largest = d
        .iter()
        .fold(T::ZERO, |largest, d| at_least(d.abs(), largest));
    for d in d.iter_mut() {
        *d /= largest;
    }
}
