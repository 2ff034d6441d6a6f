//! Bounds on the rounding of the error of a solution; [`crate::guide::error`] lists them.
//!
//! Each product and each sum is off by at most `eps / 2` of its result (IEEE 754). A term of a sum of `n` products and an offset takes part
//! in `n + 1` operations, so the sum is off by at most `(n + 1) eps / 2` of the sum of the magnitudes of its terms (C.-P. Jeannerod and S. M.
//! Rump, 2013). [`Scene::dynamics`](crate::Scene::dynamics) computes these sums of
//! magnitudes beside the sums, and [`Problem::rounding`] the bounds.
//!
//! If the error with a bound exceeds the tolerance, [`Problem::refine`] computes the sums again as dot products that carry their
//! error along ([`crate::linalg::dot2`]). These are off by `eps / 2` of their result, and at most
//! `(n + 4) (n + 1 + k) (eps / 2)²` of the magnitudes of their terms, if `k` operations follow. Each of these adds `eps / 2` of
//! the result.

use crate::linalg::blocks::diagonal_of;
use crate::linalg::dot2::Dot2;
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::{rounding_bound, square};
use crate::linalg::zip::{zip3, zip4, zip5};
use crate::problem::Problem;
use crate::problem::judge::dynamics::{Dynamics, Norms};
use crate::real::Real;
use crate::sets::Sets;
use crate::sets::energy::VelocityNoise;
use crate::solution::Model;

/// Squares of bounds on rounding.
#[derive(Clone, Copy)]
pub(crate) struct Rounding<T: Real, const C: usize, const R: usize> {
    /// Of `M v - M v_free - Hᵀ r`, in the unit of [`Dynamics::plain`].
    pub(crate) momentum: T,
    /// Of the same in the norm `Σ e_k² / M_kk`, in the unit of [`Dynamics::weighted`].
    pub(crate) weighted: T,
    /// Of the velocities of contacts and joint rows.
    pub(crate) velocities: VelocityNoise<T, C, R>,
}

/// Number of operations in which a velocity of compliance takes part: a product of up to five factors, a sum, and the operations on
/// its way to a momentum.
const COMPLIANCE: usize = 8;

/// Number of operations in which a velocity takes part after the sum of its terms: one product by `alpha`; on a surface the sum with
/// the velocity of compliance and the scaling; in the relaxation the cancellation of the parts of a sliding contact.
fn operations_after<const D: usize>(has_surface: bool, model: Model) -> usize {
    let on_surface = if has_surface { 2 } else { 0 };
    let relaxed = match model {
        Model::Coulomb => 0,
        Model::ConvexRelaxation => 3 + usize::from(D > 3),
    };
    1 + on_surface + relaxed
}

/// Share of the tolerance that bounds without sums of magnitudes may take.
const CRUDE: f64 = 0.125;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Problem<'_, T, N, D, C, R, S>
{
    /// Bounds from the sums of magnitudes of the terms: `sizes` of the velocities without compliance, and those of `dynamics`. The
    /// impulses `written` are in physical rows.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn rounding(
        &self,
        written: &Stacked<T, D, C, R>,
        sizes: &Stacked<T, D, C, R>,
        dynamics: &mut Dynamics<T>,
    ) -> Rounding<T, C, R> {
        let (scene, sets, n) = (self.scene, &self.sets, self.scene.velocities());
        let mut velocities = VelocityNoise { contacts: [[T::ZERO; 2]; C], rows: [T::ZERO; R] };
        let used = 0..sets.contacts().len();
        for (i, bound, sizes, r) in zip4(used, &mut velocities.contacts, &sizes.contacts, &written.contacts) {
            let scaling = scene.scaling(i);
            let after = operations_after::<D>(scaling.is_some(), self.model);
            let share = rounding_bound::<T>(n + 1 + after);
            let mut bounds = sizes.map(|size| share * size);
            if let Some(scaling) = scaling {
                for (bound, added) in bounds.iter_mut().zip(scaling.compliance_velocity(r)) {
                    *bound += rounding_bound::<T>(COMPLIANCE) * added.abs();
                }
            }
            *bound = squares(&scene.scaled_velocity(i, bounds));
        }
        let share = rounding_bound::<T>(n + 3);
        for (bound, row, &size, &r) in zip4(&mut velocities.rows, scene.rows(), &sizes.rows, &written.rows) {
            let added = rounding_bound::<T>(COMPLIANCE) * (row.compliance * r).abs();
            *bound = square(&[share * size + added]);
        }
        // A term of `M v` or of `Hᵀ r` takes part in one of these sums, and in two more.
        let share = rounding_bound::<T>(n.max(rows(sets)) + 3);
        let noise = |norms: &mut Norms<T>| {
            let noise = share * share * norms.magnitude;
            norms.reduce_size(noise);
            noise
        };
        Rounding {
            momentum: noise(&mut dynamics.plain),
            weighted: dynamics.weighted.as_mut().map_or(T::ZERO, noise),
            velocities,
        }
    }

    /// Bounds without sums of magnitudes, from the diagonals of `M` and `W` alone, in double precision and without joint rows; `None`
    /// if they may exceed their share of the tolerance.
    ///
    /// `M` and `W = H M⁻¹ Hᵀ` are positive semidefinite: `|M_ik| <= sqrt(M_ii M_kk)` and `|H_ak| <= sqrt(W_aa M_kk)`. With
    /// `S = Σ_k sqrt(M_kk) |v_k|` and `P = Σ_a sqrt(W_aa) |r_a|` the magnitudes of the terms of a momentum are then at most
    /// `sqrt(M_kk) (S + P) + |p_k|` with the free impulse `p`, and those of a velocity `sqrt(W_aa) S + |w_a|`.
    #[inline]
    pub(crate) fn crude_rounding(
        &self,
        v: &[T; N],
        r: &Stacked<T, D, C, R>,
        tolerance: T,
    ) -> Option<Rounding<T, C, R>> {
        let (scene, sets, [free]) = (self.scene, &self.sets, &self.free_impulse.data.0);
        // Single precision has too few digits for them.
        let usable = T::EPSILON < T::literal(1e-10)
            && !scene.is_mixed()
            && self.factor.uncertainty() < T::literal(0.1);
        if !usable {
            return None;
        }
        let (mut trace, mut energy) = (T::ZERO, T::ZERO);
        for (mass, &v) in diagonal_of(&scene.mass().data.0).zip(v) {
            trace += mass;
            energy += mass * (v * v);
        }
        let n = scene.velocities();
        let free = square(free.get(..n).unwrap_or_default());
        // Bounds on `S²` and `P²`, by Cauchy and Schwarz; twice as large, for their own rounding and that of `W`.
        let moved = T::count(2 * n) * energy;
        let share = rounding_bound::<T>(n + 1 + operations_after::<D>(false, self.model));
        let share = T::literal(2.0) * share * share;
        let mut velocities = VelocityNoise { contacts: [[T::ONE; 2]; C], rows: [T::ONE; R] };
        let mut pushed = T::ZERO;
        for (bound, set, contact, r) in
            zip4(&mut velocities.contacts, sets.contacts(), scene.contacts(), &r.contacts)
        {
            let inverse = set.inverse_mass();
            pushed += inverse * square(r);
            let offset = square(&<[T; D]>::from(contact.offset));
            *bound = [share * (offset + inverse * moved); 2];
        }
        let pushed = T::count(2 * sets.contacts().len()) * pushed;
        // `(a + b + c)² <= 3 (a² + b² + c²)`
        let share = rounding_bound::<T>(n.max(rows(sets)) + 3);
        let terms = T::literal(3.0) * (trace * (moved + pushed) + free);
        let noise = share * share * terms;
        let tiny = T::EPSILON * T::EPSILON * T::EPSILON;
        let enough = T::literal(CRUDE) * tolerance;
        let is_safe = energy > tiny && free > tiny && terms * tiny < T::ONE;
        (is_safe && noise <= enough * enough * free).then_some(Rounding {
            momentum: noise,
            weighted: T::ZERO,
            velocities,
        })
    }

    /// Computes `u = H v + w` with the velocities of compliance, and `M v - M v_free - Hᵀ r`, again with twice the digits. It replaces
    /// the bounds of [`Self::rounding`] by those of the new sums.
    #[inline(never)]
    pub(crate) fn refine(
        &self,
        v: &[T; N],
        written: &Stacked<T, D, C, R>,
        (u, dynamics): (&mut Stacked<T, D, C, R>, &mut Dynamics<T>),
        rounding: &mut Rounding<T, C, R>,
    ) {
        let [free] = &self.free_impulse.data.0;
        let (mass, n) = (&self.scene.mass().data.0, self.scene.velocities());
        let mut differences = free.map(|free| Dot2::of(-free));
        for (column, &v) in mass.iter().zip(v).take(n) {
            for (difference, &mass) in differences.iter_mut().zip(column) {
                if mass != T::ZERO {
                    difference.add(mass, v);
                }
            }
        }
        let bounds = &mut rounding.velocities;
        self.refine_contacts(v, written, u, bounds, &mut differences);
        self.refine_rows(v, written, u, bounds, &mut differences);
        let differences = differences.map(Dot2::value);
        let differences = differences.get(..n).unwrap_or_default();
        if !differences.iter().all(T::is_finite) {
            return;
        }
        dynamics.replace_residual(mass, differences);
        // Here all terms stand in one sum. `(a + b)² <= 2 (a² + b²)`
        let half = T::EPSILON * T::literal(0.5);
        let share = rounding_bound::<T>(n + rows(&self.sets) + 3);
        let norms = [Some(&dynamics.plain), dynamics.weighted.as_ref()];
        [rounding.momentum, rounding.weighted] = norms.map(|norms| {
            norms.map_or(T::ZERO, |norms| {
                let (rounded, share) = (half * half * norms.residual(), share * share);
                T::literal(2.0) * (share * share * norms.magnitude + rounded)
            })
        });
    }

    /// The part of [`Self::refine`] for contacts. Their impulses are subtracted from `differences`.
    #[inline]
    fn refine_contacts(
        &self,
        v: &[T; N],
        written: &Stacked<T, D, C, R>,
        u: &mut Stacked<T, D, C, R>,
        bounds: &mut VelocityNoise<T, C, R>,
        differences: &mut [Dot2<T>; N],
    ) {
        let (scene, half) = (self.scene, T::EPSILON * T::literal(0.5));
        for (i, bound, u, contact, r) in
            zip5(0..C, &mut bounds.contacts, &mut u.contacts, scene.contacts(), &written.contacts)
        {
            let mut sums = <[T; D]>::from(contact.offset).map(Dot2::of);
            for (&v, column, difference) in zip3(v, &contact.jacobian.data.0, &mut *differences) {
                if *column == [T::ZERO; D] {
                    continue;
                }
                for (sum, &h, &r) in zip3(&mut sums, column, r) {
                    sum.add(h, v);
                    difference.add(-h, r);
                }
            }
            let values = sums.map(Dot2::value);
            if !values.iter().all(T::is_finite) {
                continue; // too large for a product in twice the digits
            }
            *u = values;
            let scaling = scene.scaling(i);
            let times = 1 + operations_after::<D>(scaling.is_some(), self.model);
            let mut rounded = values.map(|value| value.abs() * T::count(times));
            if let Some(scaling) = scaling {
                for (rounded, u, added) in zip3(&mut rounded, u, scaling.compliance_velocity(r)) {
                    *u += added;
                    *rounded += added.abs() * T::count(COMPLIANCE);
                }
            }
            let second_order = T::count(self.scene.velocities() + 4) * bound[0].square_root();
            let sizes = scene.scaled_velocity(i, rounded);
            *bound = squares(&sizes.map(|size| half * (size + second_order)));
        }
    }

    /// The part of [`Self::refine`] for joint rows. Their impulses are subtracted from `differences`.
    #[inline]
    fn refine_rows(
        &self,
        v: &[T; N],
        written: &Stacked<T, D, C, R>,
        u: &mut Stacked<T, D, C, R>,
        bounds: &mut VelocityNoise<T, C, R>,
        differences: &mut [Dot2<T>; N],
    ) {
        for (bound, u, row, &r) in zip4(&mut bounds.rows, &mut u.rows, self.scene.rows(), &written.rows) {
            let mut sum = Dot2::of(row.offset);
            for (&v, &h, difference) in zip3(v, &row.row, &mut *differences) {
                if h != T::ZERO {
                    sum.add(h, v);
                    difference.add(-h, r);
                }
            }
            let value = sum.value();
            if value.is_finite() {
                let added = row.compliance * r;
                *u = value + added;
                let rounded = value.abs() * T::literal(3.0) + added.abs() * T::count(COMPLIANCE);
                let second_order = T::count(self.scene.velocities() + 4) * bound.square_root();
                let half = T::EPSILON * T::literal(0.5);
                *bound = square(&[half * (rounded + second_order)]);
            }
        }
    }
}

/// Number of rows of contacts and joint rows in use.
fn rows<T: Real, const D: usize, const C: usize, const R: usize>(sets: &Sets<T, D, C, R>) -> usize {
    D * sets.contacts().len() + sets.rows().len()
}

/// Square of the norm of all rows of a contact, and of the normal row.
fn squares<T: Real, const D: usize>(bounds: &[T; D]) -> [T; 2] {
    [square(bounds), square(bounds.get(..1).unwrap_or_default())]
}

#[cfg(test)]
mod tests;
