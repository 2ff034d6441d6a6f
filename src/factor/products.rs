//! Products with `W`, `H M⁻¹` and `M⁻¹ Hᵀ`.

use super::Factor;
use crate::Real;
use crate::laws::Laws;
use crate::linalg::blocks::{ContactVector, multiply_transposed};
use crate::linalg::hints::{opaque, opaque_mut, rolled};
use crate::linalg::sparsity::{GROUP, Support, add_columns, add_products};
use crate::linalg::substitution::{solve_lower, solve_upper};

impl<T: Real, const N: usize, const D: usize, const C: usize, L: Laws> Factor<T, N, D, C, L> {
    /// `y = W x`
    #[inline]
    pub(crate) fn delassus_times(&self, mut x: &[[T; D]], y: &mut [[T; D]]) {
        if L::MIXED {
            // Stops that are not reached stand behind the contacts.
            while let Some((last, others)) = x.split_last()
                && *last == [T::ZERO; D]
            {
                x = others;
            }
        }
        multiply_transposed(&self.delassus, x, y);
    }

    /// `X_i` and its nonzero columns, for the contacts in use.
    #[inline]
    fn whitened(&self) -> impl Iterator<Item = (&[[T; D]; N], Support)> {
        let whitened = self.whitened.get(..self.contacts).unwrap_or_default();
        opaque(whitened).iter().zip(self.supports.iter().copied())
    }

    /// Whitens `g`: replaces it by the `x` of `Uᵀ D⁻¹ x = g`, from which [`Self::contact_velocity`] and [`Self::velocity`]
    /// start.
    pub(crate) fn whiten(&self, g: &mut [T; N]) {
        solve_upper(&self.mass, g);
    }

    /// `H M⁻¹ g` for a `g` that was whitened. Returns `gᵀ M⁻¹ g`.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn contact_velocity(&self, g: &[T; N], u: &mut [[T; D]]) -> T {
        let mut scaled = *g;
        let mut energy = T::ZERO;
        for (i, (scaled, row)) in opaque_mut(&mut scaled)
            .iter_mut()
            .zip(&self.mass)
            .enumerate()
        {
            rolled();
            let g = *scaled;
            *scaled *= row.get(i).copied().unwrap_or(T::ZERO);
            energy += g * *scaled;
        }
        let (scaled, last) = scaled.as_chunks::<GROUP>();
        for (u, (whitened, support)) in opaque_mut(u).iter_mut().zip(self.whitened()) {
            let (columns, rest) = whitened.as_chunks::<GROUP>();
            let mut sums = [T::ZERO; D];
            for group in support.groups::<N>() {
                rolled();
                if let (Some(columns), Some(g)) = (columns.get(group), scaled.get(group)) {
                    add_columns(columns, g, &mut sums);
                }
            }
            add_columns(rest, last, &mut sums);
            *u = sums;
        }
        energy
    }

    /// `H M⁻¹ (g + Hᵀ r)` for a `g` that was whitened.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn impulse_velocity(&self, g: &[T; N], r: &[[T; D]], u: &mut [[T; D]]) {
        let mut momentum = *g;
        self.add_whitened(r, &mut momentum);
        let _ = self.contact_velocity(&momentum, u);
    }

    /// `m W d` without compliance in the first `K` rows of each slot, and `|Hᵀ d|` in the norm of `m M⁻¹`, with a reference mass
    /// `m`; by way of `Hᵀ d`, so that both are small where that is.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn row_products<const K: usize>(
        &self,
        d: &ContactVector<T, K, C>,
        mass: T,
    ) -> (ContactVector<T, K, C>, T) {
        let mut momentum = [T::ZERO; N];
        let mut rows = d.map(first_rows);
        self.add_whitened(&rows, &mut momentum);
        let energy = self.contact_velocity(&momentum, &mut rows);
        let products = rows.map(|row| first_rows(row.map(|entry| entry * mass)));
        (products, (energy * mass).max(T::ZERO).square_root())
    }

    /// Adds `Hᵀ r`, whitened, to `g`.
    #[cfg_attr(target_os = "none", inline(never))]
    fn add_whitened(&self, r: &[[T; D]], g: &mut [T; N]) {
        let (g, last) = g.as_chunks_mut::<GROUP>();
        for (&r, (whitened, support)) in opaque(r).iter().zip(self.whitened()) {
            if r == [T::ZERO; D] {
                continue;
            }
            let (columns, rest) = whitened.as_chunks::<GROUP>();
            for group in support.groups::<N>() {
                rolled();
                if let (Some(columns), Some(g)) = (columns.get(group), g.get_mut(group)) {
                    add_products(columns, r, g);
                }
            }
            add_products(rest, r, last);
        }
    }

    /// `v = M⁻¹ (Hᵀ r + g)` for a `g` that was whitened.
    pub(crate) fn velocity(&self, g: &[T; N], r: &[[T; D]], v: &mut [T; N]) {
        *v = *g;
        self.add_whitened(r, v);
        solve_lower(&self.mass, v);
    }
}

/// The first rows of a slot, as many as both have; zeros behind them.
fn first_rows<T: Real, const FROM: usize, const TO: usize>(rows: [T; FROM]) -> [T; TO] {
    let mut first = [T::ZERO; TO];
    for (first, row) in first.iter_mut().zip(rows) {
        *first = row;
    }
    first
}
