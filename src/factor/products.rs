//! Products with `H M⁻¹` and `M⁻¹ Hᵀ`, computed with the whitened `X_i` of contacts and joint rows.
//!
//! In these comments `g` is a momentum. A function takes it *whitened*, as the `x` of `Lᵀ D⁻¹ x = g`; so `gᵀ M⁻¹ g = xᵀ D⁻¹ x`.

use super::Factor;
use crate::linalg::blocks::diagonal_of;
use crate::linalg::cholesky::{axpy, dot};
use crate::linalg::stacked::Stacked;
use crate::linalg::substitution::{solve_lower, solve_upper};
use crate::linalg::zip::zip3;
use crate::real::Real;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize> Factor<T, N, D, C, R> {
    /// Whitened contacts `X_i`, for the contacts in use.
    #[inline]
    fn whitened_contacts(&self) -> &[[[T; D]; N]] {
        self.whitened.get(..self.counts.contacts).unwrap_or_default()
    }

    /// Whitened joint rows, for the rows in use.
    #[inline]
    fn whitened_rows(&self) -> impl Iterator<Item = &[T]> {
        self.whitened_row_columns().iter().map(|row| row.as_flattened())
    }

    /// Whitened contacts with the groups of their nonzero rows.
    pub(crate) fn supported_contacts(
        &self,
    ) -> impl Iterator<Item = (&[[T; D]; N], impl Iterator<Item = usize> + Clone)> {
        let supports = self.supports.iter().map(|support| support.groups::<N>(self.velocities()));
        self.whitened_contacts().iter().zip(supports)
    }

    /// Whitened joint rows, each as a matrix of one column.
    pub(crate) fn whitened_row_columns(&self) -> &[[[T; 1]; N]] {
        self.whitened_rows.get(..self.counts.rows).unwrap_or_default()
    }

    /// Reciprocals of the pivots of `M`: `P` in `gᵀ M⁻¹ g = xᵀ P x`, for the velocities in use.
    pub(crate) fn reciprocal_pivots(&self) -> impl Iterator<Item = T> {
        diagonal_of(&self.mass).take(self.velocities())
    }

    /// Whitens `g` in place, and clears what the scene does not use: solves `Lᵀ D⁻¹ x = g`.
    pub(crate) fn whiten(&self, g: &mut [T; N]) {
        let n = self.velocities();
        if n < N {
            clear_behind(g, n);
        }
        solve_upper(&self.mass, g, n);
    }

    /// Fills `u` with `H M⁻¹ g` for a whitened `g`, in the rows in use. Returns `gᵀ M⁻¹ g`.
    pub(crate) fn contact_velocity(&self, g: &[T; N], u: &mut Stacked<T, D, C, R>) -> T {
        let mut scaled = *g;
        let mut energy = T::ZERO;
        for (scaled, reciprocal) in scaled.iter_mut().zip(diagonal_of(&self.mass)) {
            let g = *scaled;
            *scaled *= reciprocal;
            energy += g * *scaled;
        }
        // As many as in a kernel of this size: `dot` sums them in the same groups.
        let in_use = scaled.get(..self.velocities()).unwrap_or_default();
        for (u, whitened) in u.rows.iter_mut().zip(self.whitened_rows()) {
            *u = dot(whitened, in_use);
        }
        for (u, whitened, support) in zip3(&mut u.contacts, self.whitened_contacts(), &self.supports) {
            let mut sums = [T::ZERO; D];
            support.add_product((whitened, self.velocities()), &scaled, &mut sums);
            *u = sums;
        }
        energy
    }

    /// `gᵀ M⁻¹ g` for a whitened `g`.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn energy(&self, g: &[T; N]) -> T {
        let mut energy = T::ZERO;
        for (&g, reciprocal) in g.iter().zip(diagonal_of(&self.mass)) {
            energy += g * (g * reciprocal);
        }
        energy
    }

    /// Fills `u` with `H M⁻¹ (g + Hᵀ r)` for a whitened `g`. Returns the square of `g + Hᵀ r` in the norm of `M⁻¹`.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn impulse_velocity(
        &self,
        g: &[T; N],
        r: &Stacked<T, D, C, R>,
        u: &mut Stacked<T, D, C, R>,
    ) -> T {
        let mut momentum = *g;
        self.add_whitened(r, &mut momentum);
        self.contact_velocity(&momentum, u)
    }

    /// Adds the whitened `Hᵀ r` to a whitened `g`.
    pub(crate) fn add_whitened(&self, r: &Stacked<T, D, C, R>, g: &mut [T; N]) {
        for (&r, whitened) in r.rows.iter().zip(self.whitened_rows()) {
            if r != T::ZERO {
                axpy(r, whitened, g);
            }
        }
        for (&r, whitened, support) in zip3(&r.contacts, self.whitened_contacts(), &self.supports) {
            if r != [T::ZERO; D] {
                support.add_transposed_product((whitened, self.velocities()), r, g);
            }
        }
    }

    /// Fills `v` with `M⁻¹ (g + Hᵀ r)` for a whitened `g`.
    pub(crate) fn velocity(&self, g: &[T; N], r: &Stacked<T, D, C, R>, v: &mut [T; N]) {
        *v = *g;
        self.add_whitened(r, v);
        solve_lower(&self.mass, v, self.velocities());
    }
}

/// Clears the entries from `n` on.
#[cold]
#[inline(never)]
fn clear_behind<T: Real>(g: &mut [T], n: usize) {
    g.get_mut(n..).unwrap_or_default().fill(T::ZERO);
}
