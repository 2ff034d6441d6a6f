//! The impulse of one contact with more than two tangents, for torsional and rolling friction.
//!
//! As in [`super::coulomb_sweep`], `r_T = (S + λI)⁻¹ b` with the `λ >= 0` that puts the impulse on the cone. The ratio of
//! `mu r_N` to `|r_T|` is nearly linear in `λ` and grows with it. Newton's method finds the `λ` at which it is 1, between bounds.

use crate::linalg::block_factor::BlockFactor;
use crate::linalg::blocks::product;
use crate::linalg::vector::{norm, square};
use crate::linalg::zip::zip3;
use crate::real::Real;

/// Most steps of Newton's method; the next sweep continues from the `λ` of the last one.
const STEPS: usize = 12;

/// The equations of a contact after elimination of `r_N`. Vectors have a zero in the normal row.
struct Tangents<T, const D: usize> {
    /// `S`, with a unit row for the normal.
    schur: [[T; D]; D],
    /// `trace(S)`
    trace: T,
    b: [T; D],
    /// `W_NT`
    coupling: [T; D],
    /// `u_N` of the free velocity.
    approach: T,
    /// `W_NN`
    inverse_mass: T,
    mu: T,
}

/// The impulse of the contact at some `λ`.
struct Impulse<T, const D: usize> {
    /// `r_T`, with a zero in the normal row.
    tangents: [T; D],
    /// `r_N`
    normal: T,
}

impl<T: Real, const D: usize> Tangents<T, D> {
    /// The equations of a contact with the diagonal block `W_ii` and the free velocity `u`.
    #[inline]
    fn new(block: &[[T; D]; D], u: &[T; D], mu: T) -> Option<Self> {
        let (&[approach, ..], &[first, ..]) = (u.as_slice(), block.as_slice()) else {
            return None;
        };
        let inverse_mass = *first.first()?;
        let mut coupling = first;
        *coupling.first_mut()? = T::ZERO;
        let (mut schur, mut b) = (*block, [T::ZERO; D]);
        let mut trace = T::ZERO;
        for (k, row, b) in zip3(0..D, &mut schur, &mut b) {
            let share = *coupling.get(k)? / inverse_mass;
            *b = share * approach - *u.get(k)?;
            for (entry, &coupled) in row.iter_mut().zip(&coupling) {
                *entry -= share * coupled;
            }
            *row.first_mut()? = T::ZERO;
            trace += *row.get(k)?;
        }
        *b.first_mut()? = T::ZERO;
        schur.first_mut()?.fill(T::ZERO);
        *schur.first_mut()?.first_mut()? = T::ONE;
        Some(Self { schur, trace, b, coupling, approach, inverse_mass, mu })
    }

    /// `(S + λI)⁻¹ column`
    fn solve(&self, lambda: T, column: &[T; D]) -> Option<[T; D]> {
        let mut matrix = self.schur;
        for (k, row) in matrix.iter_mut().enumerate() {
            *row.get_mut(k)? += lambda;
        }
        let factor = BlockFactor::new(matrix)?;
        let mut x = [[T::ZERO; D]; D];
        for (row, &entry) in x.iter_mut().zip(column) {
            *row.first_mut()? = entry;
        }
        factor.eliminate(&mut x);
        factor.scale(&mut x);
        factor.back_substitute(&mut x);
        let mut solution = [T::ZERO; D];
        for (entry, row) in solution.iter_mut().zip(&x) {
            *entry = *row.first()?;
        }
        Some(solution)
    }

    /// The impulse at this `λ`.
    fn impulse(&self, lambda: T) -> Option<Impulse<T, D>> {
        let tangents = self.solve(lambda, &self.b)?;
        let normal = -(self.approach + product(&self.coupling, &tangents)) / self.inverse_mass;
        Some(Impulse { tangents, normal })
    }

    /// `mu r_N / |r_T| - 1` of the impulse at this `λ`, and its derivative by `λ`.
    fn ratio(&self, lambda: T, impulse: &Impulse<T, D>) -> Option<(T, T)> {
        let Impulse { tangents, normal } = impulse;
        let turned = self.solve(lambda, tangents)?.map(|x| -x);
        let growth = -product(&self.coupling, &turned) / self.inverse_mass;
        let squares = square(tangents);
        let length = squares.square_root();
        let slope = growth - *normal * product(tangents, &turned) / squares;
        Some((self.mu * *normal / length - T::ONE, self.mu * slope / length))
    }
}

/// The impulse of a contact from `W_ii` and its free velocity `u`; `None` if there is none. `multiplier` is the `λ` of the last
/// sweep, and becomes the next guess.
pub(super) fn push<T: Real, const D: usize>(
    block: &[[T; D]; D],
    u: &[T; D],
    mu: T,
    multiplier: &mut T,
) -> Option<[T; D]> {
    let tangents = Tangents::new(block, u, mu)?;
    let size = tangents.trace;
    // With this `λ` a row that nothing moves, whose entries are rounding, has a pivot, too.
    let floor = size * T::EPSILON * T::literal(64.0);
    let sticking = tangents.impulse(floor)?;
    let bound = mu * sticking.normal;
    if sticking.normal >= T::ZERO && square(&sticking.tangents) <= bound * bound {
        *multiplier = T::ZERO;
        return Some(joined(sticking.normal, &sticking.tangents, T::ONE));
    }
    let (mut low, mut high) = (floor, None);
    if *multiplier <= floor {
        let isotropic = -norm(&tangents.b) * tangents.inverse_mass / (mu * tangents.approach);
        *multiplier = (isotropic - size).max(size * T::literal(1e-3));
    }
    let mut last = None;
    for _ in 0..STEPS {
        let lambda = *multiplier;
        let impulse = tangents.impulse(lambda)?;
        let (excess, slope) = tangents.ratio(lambda, &impulse)?;
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
        if impulse.normal > T::ZERO {
            let stretch = mu * impulse.normal / norm(&impulse.tangents);
            last = Some(joined(impulse.normal, &impulse.tangents, stretch));
        }
        if excess.abs() < T::literal(1e-3) {
            break;
        }
    }
    last
}

/// The impulse with this normal component and the stretched tangents.
fn joined<T: Real, const D: usize>(normal: T, tangents: &[T; D], stretch: T) -> [T; D] {
    let mut impulse = tangents.map(|tangent| tangent * stretch);
    if let Some(first) = impulse.first_mut() {
        *first = normal;
    }
    impulse
}

#[cfg(test)]
mod tests;
