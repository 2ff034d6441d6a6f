//! The second part of the error, `|M v - M v_free - Hᵀ r|`, and `u = H v + w` on the way.

use crate::linalg::cholesky::{BLOCK, axpy, dot};
use crate::linalg::sparsity::{
    GROUP, add_columns, add_columns_and_sizes, add_products, add_products_and_sizes,
};
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::{at_least, larger, quotient, root_sum};
use crate::real::Real;
use crate::scene::Scene;
use nalgebra::ComplexField;

/// Bytes of sums and of as many sizes that fit into registers, with a quarter left for the terms: 32 words on a Cortex-M4F, 32
/// doubles in 16 vectors on a desktop.
const SUMS: usize = if cfg!(target_os = "none") { 48 } else { 96 };

/// The dynamics in the norm of momenta, and in a mixed scene also in the norm `Σ e_k² / M_kk`, in which no light
/// finger is lost beside a heavy body.
pub(crate) struct Dynamics<T: Real> {
    pub(crate) plain: Norms<T>,
    pub(crate) weighted: Option<Norms<T>>,
}

/// `|M v - M v_free - Hᵀ r|`, the largest of `|M v_free|`, `|M v|` and `|Hᵀ r|`, and the norm of the sums of the magnitudes of all
/// terms; each squared, in a unit in which neither of the first two overflows nor vanishes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Norms<T> {
    residual: T,
    size: T,
    pub(crate) magnitude: T,
    pub(crate) unit: T,
}

/// The momenta `M v_free`, `M v` and `Hᵀ r`, and the sums of the magnitudes of the terms of the last two.
struct Momenta<'a, T, const N: usize> {
    free: &'a [T; N],
    inertia: [T; N],
    pushed: [T; N],
    magnitudes: [T; N],
}

impl<T: Real> Norms<T> {
    #[inline]
    fn of<const N: usize>(momenta: &Momenta<'_, T, N>, weight: impl Fn(usize) -> T + Copy) -> Self {
        let norms = Self::in_unit(momenta, T::ONE, weight);
        if norms.is_safe() {
            return norms;
        }
        // Twice the exponent of the unit: a bound on that of each square.
        let mut exponent = None;
        let sums = momenta.inertia.iter().zip(&momenta.pushed);
        for (k, (&free, (&inertia, &pushed))) in momenta.free.iter().zip(sums).enumerate() {
            let largest = larger(T::ZERO, &[free, inertia, pushed], T::ONE);
            if largest > T::ZERO && largest.is_finite() {
                exponent = exponent.max(Some(2 * largest.exponent() + weight(k).exponent()));
            }
        }
        let unit = exponent.map_or(T::ONE, |exponent: i32| T::power_of_two(-(exponent >> 1)));
        Self::in_unit(momenta, unit, weight)
    }

    /// Can none of its squares have overflown or vanished?
    fn is_safe(&self) -> bool {
        let tiny = T::EPSILON * T::EPSILON * T::EPSILON;
        self.size > tiny && self.size * tiny < T::ONE
    }

    #[cfg_attr(target_os = "none", inline(never))]
    fn in_unit<const N: usize>(
        momenta: &Momenta<'_, T, N>,
        unit: T,
        weight: impl Fn(usize) -> T,
    ) -> Self {
        let [
            mut residual,
            mut size_free,
            mut size_v,
            mut size_r,
            mut magnitude,
        ] = [T::ZERO; 5];
        let sums = momenta.inertia.iter().zip(&momenta.pushed);
        let sums = momenta.free.iter().zip(sums).zip(&momenta.magnitudes);
        for (k, ((&free, (&inertia, &pushed)), &terms)) in sums.enumerate() {
            let (free, inertia, pushed) = (unit * free, unit * inertia, unit * pushed);
            let (gap, weight) = (inertia - free - pushed, weight(k));
            let terms = unit * terms + free.abs();
            residual += gap * gap * weight;
            size_free += free * free * weight;
            size_v += inertia * inertia * weight;
            size_r += pushed * pushed * weight;
            magnitude += terms * terms * weight;
        }
        Self {
            residual,
            size: at_least(size_r, at_least(size_v, size_free)),
            magnitude,
            unit,
        }
    }

    /// Second part of the error, `|M v - M v_free - Hᵀ r| / max(|M v_free|, |M v|, |Hᵀ r|)`. `noise` is the square of a bound on
    /// its rounding, in the same unit.
    pub(crate) fn error(&self, noise: T) -> T {
        root_sum(self.residual, noise, self.size)
    }

    /// `|M v - M v_free - Hᵀ r|²`
    pub(crate) fn residual(&self) -> T {
        self.residual
    }

    /// Takes `M v - M v_free - Hᵀ r`, computed anew.
    fn replace_gaps<const N: usize>(&mut self, gaps: &[T; N], weight: impl Fn(usize) -> T) {
        self.residual = T::ZERO;
        for (k, &gap) in gaps.iter().enumerate() {
            let gap = self.unit * gap;
            self.residual += gap * gap * weight(k);
        }
    }

    /// They are compared with momenta that are less by as much as rounding may have added: `noise` is the square of that.
    pub(crate) fn compare_with_less(&mut self, noise: T) {
        // Of a quotient, which no unit changes.
        let left = (T::ONE - quotient(noise, self.size).square_root()).max(T::ZERO);
        self.size *= left * left;
    }

    /// Squares of momenta are compared with no less than this, in the unit.
    pub(crate) fn compare_with(&mut self, least: T) {
        self.size = self.size.max(least);
    }
}

impl<T: Real> Dynamics<T> {
    /// Takes `M v - M v_free - Hᵀ r`, computed anew.
    pub(crate) fn replace_gaps<const N: usize>(&mut self, mass: &[[T; N]; N], gaps: &[T; N]) {
        self.plain.replace_gaps(gaps, |_| T::ONE);
        if let Some(weighted) = &mut self.weighted {
            weighted.replace_gaps(gaps, weights(mass));
        }
    }
}

/// `1 / M_kk`
fn weights<T: Real, const N: usize>(mass: &[[T; N]; N]) -> impl Fn(usize) -> T + Copy {
    move |k| {
        let own = mass.get(k).and_then(|column| column.get(k)).copied();
        T::ONE / own.unwrap_or(T::ONE)
    }
}

/// Evaluates the dynamics, and fills `u = H v + w`, without compliance, of impulses in rows that are not scaled; and the sums of the
/// magnitudes of the terms of `u`.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn momentum<
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize,
    const S: usize,
>(
    scene: &Scene<T, N, D, C, R, S>,
    free: &[T; N],
    v: &[T; N],
    r: &Stacked<T, D, C, R>,
    u: &mut Stacked<T, D, C, R>,
    sizes: &mut Stacked<T, D, C, R>,
) -> Dynamics<T> {
    let mass = &scene.mass().data.0;
    let mut momenta = Momenta {
        free,
        inertia: [T::ONE; N], // all of it is overwritten, and zeros would call memset
        pushed: [T::ZERO; N],
        magnitudes: [T::ONE; N],
    };
    let Momenta {
        inertia,
        pushed,
        magnitudes,
        ..
    } = &mut momenta;
    multiply::<T, N, true>(mass, v, (&mut *inertia, &mut *magnitudes));
    let places = u.rows.iter_mut().zip(&mut sizes.rows);
    for (row, (&r, (u, size))) in scene.rows().iter().zip(r.rows.iter().zip(places)) {
        let [entries] = &row.row.data.0;
        *u = dot(entries, v) + row.offset;
        *size = row.offset.abs();
        for (&entry, &v) in entries.iter().zip(v) {
            *size += (entry * v).abs();
        }
        if r != T::ZERO {
            axpy(r, entries, pushed);
            for (magnitude, &entry) in magnitudes.iter_mut().zip(entries) {
                *magnitude += (r * entry).abs();
            }
        }
    }
    let (groups, last) = v.as_chunks::<GROUP>();
    let (places, place) = pushed.as_chunks_mut::<GROUP>();
    let (size_places, size_place) = magnitudes.as_chunks_mut::<GROUP>();
    let targets = u.contacts.iter_mut().zip(&mut sizes.contacts);
    let contacts = scene.supported().zip(&r.contacts).zip(targets);
    for (((contact, support), r), (u, size)) in contacts {
        let mut velocity: [T; D] = contact.offset.into();
        let mut terms = velocity.map(ComplexField::abs);
        let (columns, rest) = contact.jacobian.data.0.as_chunks::<GROUP>();
        for group in support.groups::<N>() {
            let columns = columns.get(group).zip(groups.get(group));
            let targets = places.get_mut(group).zip(size_places.get_mut(group));
            if let (Some((columns, v)), Some((pushed, magnitudes))) = (columns, targets) {
                add_columns_and_sizes(columns, v, (&mut velocity, &mut terms));
                add_products_and_sizes(columns, *r, (pushed, magnitudes));
            }
        }
        add_columns_and_sizes(rest, last, (&mut velocity, &mut terms));
        add_products_and_sizes(rest, *r, (&mut *place, &mut *size_place));
        (*u, *size) = (velocity, terms);
    }
    let is_mixed = scene.is_mixed();
    Dynamics {
        plain: Norms::of(&momenta, |_| T::ONE),
        weighted: is_mixed.then(|| Norms::of(&momenta, weights(mass))),
    }
}

/// [`momentum`] of contacts alone, without sums of magnitudes.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn plain_momentum<
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize,
    const S: usize,
>(
    scene: &Scene<T, N, D, C, R, S>,
    free: &[T; N],
    v: &[T; N],
    r: &Stacked<T, D, C, R>,
    u: &mut Stacked<T, D, C, R>,
) -> Dynamics<T> {
    let zeros = [T::ZERO; N];
    let [mut inertia, mut pushed] = [zeros; 2];
    let mass = &scene.mass().data.0;
    multiply::<T, N, false>(mass, v, (&mut inertia, &mut pushed)); // zeros stay zeros
    let (groups, last) = v.as_chunks::<GROUP>();
    let (places, place) = pushed.as_chunks_mut::<GROUP>();
    let contacts = scene.supported().zip(&r.contacts).zip(&mut u.contacts);
    for (((contact, support), &r), u) in contacts {
        let mut velocity: [T; D] = contact.offset.into();
        let pushes = r != [T::ZERO; D];
        let (columns, rest) = contact.jacobian.data.0.as_chunks::<GROUP>();
        for group in support.groups::<N>() {
            let columns = columns.get(group).zip(groups.get(group));
            if let (Some((columns, v)), Some(pushed)) = (columns, places.get_mut(group)) {
                add_columns(columns, v, &mut velocity);
                if pushes {
                    add_products(columns, r, pushed);
                }
            }
        }
        add_columns(rest, last, &mut velocity);
        add_products(rest, r, &mut *place);
        *u = velocity;
    }
    let momenta = Momenta {
        free,
        inertia,
        pushed,
        magnitudes: zeros,
    };
    Dynamics {
        plain: Norms::of(&momenta, |_| T::ONE),
        weighted: None,
    }
}

/// `M v` and, with `SIZES`, the sums of the magnitudes of its terms; zeros in their place without.
#[inline]
fn multiply<T: Real, const N: usize, const SIZES: bool>(
    mass: &[[T; N]; N],
    v: &[T; N],
    (products, magnitudes): (&mut [T; N], &mut [T; N]),
) {
    if N * size_of::<T>() <= SUMS * if SIZES { 1 } else { 2 } {
        return multiply_rows::<T, N, N, SIZES>(mass, 0, v, (products, magnitudes));
    }
    // The last block repeats some rows, so that all blocks have the same size.
    let (mut first, last) = (0, N - BLOCK);
    while first < last + BLOCK {
        let places = (&mut *products, &mut *magnitudes);
        multiply_rows::<T, N, BLOCK, SIZES>(mass, first.min(last), v, places);
        first += BLOCK;
    }
}

/// `K` entries of [`multiply`] from row `first` on.
#[inline]
fn multiply_rows<T: Real, const N: usize, const K: usize, const SIZES: bool>(
    mass: &[[T; N]; N],
    first: usize,
    v: &[T; N],
    (products, magnitudes): (&mut [T; N], &mut [T; N]),
) {
    let mut sums = [[T::ZERO; 2]; K];
    // All of it unrolled at once would have more sums than registers.
    for (column, &v) in mass.as_slice().iter().zip(v) {
        let Some(column) = column.get(first..).and_then(<[T]>::first_chunk::<K>) else {
            break;
        };
        for ([sum, size], &mass) in sums.iter_mut().zip(column) {
            let product = mass * v;
            *sum += product;
            if SIZES {
                *size += product.abs();
            }
        }
    }
    let products = products.get_mut(first..).unwrap_or_default();
    let magnitudes = magnitudes.get_mut(first..).unwrap_or_default();
    for ((product, magnitude), [sum, size]) in products.iter_mut().zip(magnitudes).zip(sums) {
        (*product, *magnitude) = (sum, size);
    }
}

#[cfg(test)]
mod tests;
