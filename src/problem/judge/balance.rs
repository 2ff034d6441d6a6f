//! Bounds on rounding without a sum of momenta: `v` is computed from the Cholesky factor of `M`, so its momentum balances but for rounding.

use super::dynamics::{Dynamics, Norms};
use super::rounding::{Rounding, operations_after, rows};
use crate::linalg::blocks::diagonal_of;
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::{at_least, quotient, rounding_bound, square};
use crate::linalg::zip::zip3;
use crate::problem::Problem;
use crate::real::Real;
use crate::sets::energy::VelocityNoise;

/// Share of the tolerance that a bound without sums may take. (The error is the largest of its parts, so this bound adds to no other part.)
const A_PRIORI: f64 = 0.5;

/// The dynamics of a velocity whose momentum balances but for rounding.
pub(crate) struct Balance<T: Real> {
    /// Bound on `S²`, with `S = Σ_k sqrt(M_kk) |v_k|`.
    pub(crate) moved: T,
    pub(crate) dynamics: Dynamics<T>,
    /// Squares of bounds on the rounding of the momentum, in both norms.
    pub(crate) momentum: [T; 2],
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Problem<'_, T, N, D, C, R, S>
{
    /// The dynamics of a velocity `v` that was computed from the impulses `r`, without a sum: the momentum `M v - M v_free - Hᵀ r` is
    /// rounding alone. `None` if the bound on it exceeds its share of the tolerance.
    ///
    /// Whitened contacts, whitened momentum and `v` solve triangular systems. Each is exact for a factor that is off by
    /// `N eps / 2`, and the factor for an `M` that is off by `(N + 1) eps / 2` of `|Lᵀ| |D⁻¹| |L|` (Higham, *Accuracy and Stability of
    /// Numerical Algorithms*, 8.5 and 10.3). By Cauchy and Schwarz the entries of that are at most `sqrt(M_kk M_ll)`. So the
    /// momentum of dof `k` is off by at most
    ///
    /// `sqrt(M_kk) ((2 N + 4) S + (N + m + 4) (P + E)) eps / 2`, `S = Σ_k sqrt(M_kk) |v_k|`, `P = Σ_a sqrt(W_aa) |r_a|`,
    ///
    /// with the energy `E² = pᵀ M⁻¹ p` of the free impulse and the number `m` of rows.
    pub(crate) fn momentum_balance(
        &self,
        v: &[T; N],
        r: &Stacked<T, D, C, R>,
        tolerance: T,
    ) -> Option<Balance<T>> {
        let (scene, sets, [free]) = (self.scene, &self.sets, &self.free_impulse.data.0);
        if !self.factor.balances() {
            return None;
        }
        let n = scene.velocities();
        let is_mixed = scene.is_mixed();
        let [mut trace, mut energy, mut size, mut weighted_size] = [T::ZERO; 4];
        for (mass, &v, &free) in zip3(diagonal_of(&scene.mass().data.0), v, free).take(n) {
            trace += mass;
            energy += mass * (v * v);
            size += free * free;
            if is_mixed {
                weighted_size += free * free / mass;
            }
        }
        let (delassus, mut pushed) = (self.factor.delassus(), T::ZERO);
        for (set, r) in sets.contacts().iter().zip(&r.contacts) {
            pushed += set.inverse_mass() * square(r);
        }
        for (j, &r) in r.rows.iter().enumerate().take(sets.rows().len()) {
            pushed += delassus.row_inverse_mass(j) * (r * r);
        }
        // Bounds on `S²` and `P²`, by Cauchy and Schwarz.
        let moved = T::count(n) * energy;
        let pushed = T::count(sets.contacts().len() + sets.rows().len()) * pushed;
        let [of_v, of_r] = [2 * n + 4, n + rows(sets) + 4].map(rounding_bound::<T>);
        // Roots of quotients, which do not depend on the unit.
        let largest = at_least(moved, at_least(pushed, self.free_energy));
        let [s, p, e] =
            [moved, pushed, self.free_energy].map(|square| quotient(square, largest).square_root());
        let share = T::literal(1.01) * (of_v * s + of_r * (p + e)); // a hundredth for its own rounding
        let noise = largest * (share * share);
        let (plain, weighted) = (trace * noise, T::count(n) * noise);
        let tiny = T::EPSILON * T::EPSILON * T::EPSILON;
        let enough = T::literal(A_PRIORI) * tolerance;
        let enough = enough * enough;
        let is_safe = size > tiny && trace * largest * tiny < T::ONE;
        let is_small = plain <= enough * size && (!is_mixed || weighted <= enough * weighted_size);
        if !is_safe || !is_small {
            return None;
        }
        let weighted_norms = is_mixed.then(|| Norms::balanced(weighted_size));
        let mut dynamics = Dynamics { plain: Norms::balanced(size), weighted: weighted_norms };
        self.set_least_sizes(&mut dynamics);
        Some(Balance { moved, dynamics, momentum: [plain, weighted] })
    }

    /// Do the sums of momenta confirm that `v` balances? With the factor of `M` they do. In the memory of an old factor a bit may have flipped.
    #[cold]
    #[inline(never)]
    pub(crate) fn is_confirmed(&self, v: &[T; N], written: &Stacked<T, D, C, R>, tolerance: T) -> bool {
        let mut rounding = Rounding::<T, C, R>::unset();
        let dynamics = self.sum_momenta(v, written, &mut rounding);
        rounding.momentum_error(&dynamics) <= tolerance
    }

    /// Bounds on velocities without sums, from the diagonals of `M` and `W` alone: `moved` is a bound on `S²`, see [`Self::momentum_balance`].
    /// The scene has contacts alone. (By Cauchy and Schwarz `|H_ak| <= sqrt(W_aa M_kk)`, so the magnitudes of `H_a v` are at most `sqrt(W_aa) S`.)
    #[inline]
    pub(crate) fn crude_velocity_rounding(&self, moved: T, bounds: &mut VelocityNoise<T, C, R>) {
        let share =
            rounding_bound::<T>(self.scene.velocities() + 1 + operations_after::<D>(false, self.model));
        // `(a + b)² <= 2 (a² + b²)`; and an eighth more for the rounding of `W`, below a tenth (`Factor::balances`), and its own.
        let share = T::literal(2.25) * share * share;
        for (bound, set, contact) in zip3(&mut bounds.contacts, self.sets.contacts(), self.scene.contacts()) {
            let offset = square(&<[T; D]>::from(contact.offset));
            *bound = [share * (offset + set.inverse_mass() * moved); 2];
        }
    }
}

#[cfg(test)]
mod tests;
