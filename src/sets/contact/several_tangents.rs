//! The impulse of one contact with more than two tangents: torsional and rolling friction.
//!
//! As in [`super::coulomb_sweep`], `r_T = (S + λI)⁻¹ b` with the `λ >= 0` that puts the impulse on the cone. The ratio of
//! `mu r_N` to `|r_T|` is nearly linear in `λ` and grows with it: Newton's method, kept between bounds.

use crate::linalg::blocks::product;
use crate::linalg::pivot::Pivot;
use crate::linalg::vector::{norm, square};
use crate::real::Real;

/// Steps of Newton's method at most; the next sweep goes on from there.
const STEPS: usize = 12;

/// The contact without its normal row; vectors have a zero there.
struct Tangents<'a, T, const D: usize> {
    /// `S`, with a unit row for the normal.
    schur: [[T; D]; D],
    b: [T; D],
    /// `W_NT`, with a zero.
    coupling: [T; D],
    approach: T,
    inertia: T,
    mu: &'a T,
}

/// `r_T` and `r_N` at some `λ`.
struct Point<T, const D: usize> {
    tangents: [T; D],
    normal: T,
}

impl<T: Real, const D: usize> Tangents<'_, T, D> {
    /// `(S + λI)⁻¹` times both columns.
    fn solve(&self, lambda: T, column: &[T; D]) -> Option<[T; D]> {
        let mut matrix = self.schur;
        for (k, row) in matrix.iter_mut().enumerate() {
            *row.get_mut(k)? += lambda;
        }
        let pivot = Pivot::new(matrix)?;
        let mut x = [[T::ZERO; D]; D];
        for (row, &entry) in x.iter_mut().zip(column) {
            *row.first_mut()? = entry;
        }
        pivot.eliminate(&mut x);
        pivot.scale(&mut x);
        pivot.back_substitute(&mut x);
        let mut solution = [T::ZERO; D];
        for (entry, row) in solution.iter_mut().zip(&x) {
            *entry = *row.first()?;
        }
        Some(solution)
    }

    fn at(&self, lambda: T) -> Option<Point<T, D>> {
        let tangents = self.solve(lambda, &self.b)?;
        let normal = -(self.approach + product(&self.coupling, &tangents)) / self.inertia;
        Some(Point { tangents, normal })
    }

    /// `mu r_N / |r_T| - 1` and its derivative.
    fn ratio(&self, lambda: T, point: &Point<T, D>) -> Option<(T, T)> {
        let turned = self.solve(lambda, &point.tangents)?.map(|x| -x);
        let growth = -product(&self.coupling, &turned) / self.inertia;
        let squares = square(&point.tangents);
        let length = squares.square_root();
        let slope = growth - point.normal * product(&point.tangents, &turned) / squares;
        Some((
            *self.mu * point.normal / length - T::ONE,
            *self.mu * slope / length,
        ))
    }
}

/// The impulse, from the velocity that the others leave and near the last `λ`; `None` if there is none.
pub(super) fn push<T: Real, const D: usize>(
    own: &[[T; D]; D],
    u: &[T; D],
    mu: T,
    multiplier: &mut T,
) -> Option<[T; D]> {
    let (&[approach, ..], &[first, ..]) = (u.as_slice(), own.as_slice()) else {
        return None;
    };
    let inertia = *first.first()?;
    let mut coupling = first;
    *coupling.first_mut()? = T::ZERO;
    let (mut schur, mut b) = (*own, [T::ZERO; D]);
    let mut size = T::ZERO;
    for (k, (row, b)) in schur.iter_mut().zip(&mut b).enumerate() {
        let share = *coupling.get(k)? / inertia;
        *b = share * approach - *u.get(k)?;
        for (entry, &coupled) in row.iter_mut().zip(&coupling) {
            *entry -= share * coupled;
        }
        *row.first_mut()? = T::ZERO;
        size += *row.get(k)?;
    }
    *b.first_mut()? = T::ZERO;
    schur.first_mut()?.fill(T::ZERO);
    *schur.first_mut()?.first_mut()? = T::ONE;
    let tangents = Tangents {
        schur,
        b,
        coupling,
        approach,
        inertia,
        mu: &mu,
    };
    // What rounding leaves of a row that nothing moves has a pivot, too.
    let floor = size * T::EPSILON * T::literal(64.0);
    let held = tangents.at(floor)?;
    if held.normal >= T::ZERO && square(&held.tangents) <= mu * held.normal * (mu * held.normal) {
        *multiplier = T::ZERO;
        return Some(joined(held.normal, &held.tangents, T::ONE));
    }
    let (mut low, mut high) = (floor, None);
    if *multiplier <= floor {
        *multiplier = (-norm(&b) * inertia / (mu * approach) - size).max(size * T::literal(1e-3));
    }
    let mut last = None;
    for _ in 0..STEPS {
        let lambda = *multiplier;
        let point = tangents.at(lambda)?;
        let (excess, slope) = tangents.ratio(lambda, &point)?;
        if excess < T::ZERO {
            low = lambda;
        } else {
            high = Some(lambda);
        }
        let newton = lambda - excess / slope;
        let inside = newton > low && high.is_none_or(|high| newton < high);
        *multiplier = match high {
            _ if inside => newton,
            Some(high) => (low * high).square_root(),
            None => (lambda + size) * T::literal(4.0),
        };
        if point.normal > T::ZERO {
            let stretch = mu * point.normal / norm(&point.tangents);
            last = Some(joined(point.normal, &point.tangents, stretch));
        }
        if excess.abs() < T::literal(1e-3) {
            break;
        }
    }
    last
}

/// The impulse of a normal part and tangents that are stretched.
fn joined<T: Real, const D: usize>(normal: T, tangents: &[T; D], stretch: T) -> [T; D] {
    let mut impulse = tangents.map(|tangent| tangent * stretch);
    if let Some(first) = impulse.first_mut() {
        *first = normal;
    }
    impulse
}

#[cfg(test)]
mod tests;
