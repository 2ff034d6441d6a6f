//! The default penalty `rho` of the augmented Lagrangian, and the number of dofs that contacts and joint rows move.

use crate::linalg::blocks::diagonal_of;
use crate::linalg::sparsity::GROUP;
use crate::real::Real;
use crate::scene::Scene;

/// Is `rho` positive and finite?
#[inline]
pub(crate) fn is_usable<T: Real>(rho: T) -> bool {
    rho > T::ZERO && rho.is_finite()
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Scene<T, N, D, C, R, S>
{
    /// The default `rho`, a power of two near 6 times the geometric mean of `M_jj / (HᵀH)_jj`.
    ///
    /// The quotient is the mass that a contact feels if it moves dof `j` alone. So `rho` has the unit of a mass. Units of dofs do not matter,
    /// nor do dofs that no contact moves. The geometric mean also fits stacks of unlike bodies, where the trace of `W` shows only the
    /// lightest. The mean of binary exponents needs no logarithm, and a change of units by a power of two changes it exactly.
    pub(crate) fn default_penalty(&self) -> T {
        let mut participation = [T::ZERO; N];
        let least = self.participation(&mut participation);
        let moved = participation.iter().filter(|&&share| share > least);
        let exponents = moved.clone().map(|share| share.exponent()).sum::<i32>();
        let count = i32::try_from(moved.count()).unwrap_or(0);
        let mean = exponents.checked_div_euclid(count);
        mean.map_or(T::ONE, |mean| T::power_of_two(2 - mean))
    }

    /// Number of dofs that contacts and joint rows move.
    pub(crate) fn moved_dofs(&self) -> usize {
        let mut participation = [T::ZERO; N];
        let least = self.participation(&mut participation);
        participation.iter().filter(|&&share| share > least).count()
    }

    /// Fills zeros with the participation `(HᵀH)_jj / M_jj` of each dof. Returns the value up to which a participation is mere rounding.
    #[cfg_attr(target_os = "none", inline(never))]
    fn participation(&self, participation: &mut [T; N]) -> T {
        let (groups, last) = participation.as_chunks_mut::<GROUP>();
        for (contact, support) in self.contacts().iter().zip(self.supports()) {
            let (columns, rest) = contact.jacobian.data.0.as_chunks::<GROUP>();
            for group in support.groups::<N>(self.velocities()) {
                if let (Some(columns), Some(participation)) = (columns.get(group), groups.get_mut(group)) {
                    add_squares(columns, participation);
                }
            }
            add_squares(rest, last);
        }
        for row in self.rows() {
            for (sum, &entry) in participation.iter_mut().zip(row.row.iter()) {
                *sum += entry * entry;
            }
        }
        let mut largest = T::ZERO;
        for (participation, mass) in participation.iter_mut().zip(diagonal_of(&self.mass().data.0)) {
            *participation /= mass;
            if *participation > largest {
                largest = *participation;
            }
        }
        largest * T::literal(1e-9)
    }
}

/// `sums_j += |column_j|²`
#[inline]
fn add_squares<T: Real, const D: usize>(columns: &[[T; D]], sums: &mut [T]) {
    for (sum, column) in sums.iter_mut().zip(columns) {
        *sum = column.iter().fold(*sum, |sum, &entry| sum + entry * entry);
    }
}
