//! The second part of the error, `|M v - M v_free - Hᵀ r|`, and `u = H v + w` on the way.

use crate::cone::square;
use crate::linalg::cholesky::{BLOCK, axpy, dot};
use crate::linalg::sparsity::{GROUP, add_columns, add_products};
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::{larger, root_sum};
use crate::{Real, Scene};

/// Bytes of sums that fit into registers, with a quarter left for the terms: 32 words on a Cortex-M4F, 32 doubles in 16
/// vectors on a desktop.
const SUMS: usize = if cfg!(target_os = "none") { 96 } else { 192 };

/// The dynamics in the norm of momenta, and in a mixed scene also in the norm `Σ e_k² / M_kk`, in which no light
/// finger is lost beside a heavy body.
pub(crate) struct Dynamics<T: Real> {
    pub(crate) plain: Norms<T>,
    /// `Σ_a r_a² |H_a|²` over the rows, a bound on the sums of magnitudes in `Hᵀ r`.
    pub(crate) pushed: T,
    pub(crate) weighted: Option<Norms<T>>,
}

/// `|M v - M v_free - Hᵀ r|` and the largest of `|M v_free|`, `|M v|` and `|Hᵀ r|`, both squared, in a unit in which
/// neither overflows nor vanishes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Norms<T> {
    residual: T,
    size: T,
    /// `|M v_free|²`
    pub(crate) free: T,
    pub(crate) unit: T,
}

impl<T: Real> Norms<T> {
    /// From `M v_free`, `M v` and `Hᵀ r`.
    #[inline]
    fn of<const N: usize>(
        free: &[T; N],
        inertia: &[T; N],
        pushed: &[T; N],
        weight: impl Fn(usize) -> T + Copy,
    ) -> Self {
        let norms = Self::in_unit(free, inertia, pushed, T::ONE, weight);
        if norms.is_safe() {
            return norms;
        }
        // Twice the exponent of the unit: a bound on that of each square.
        let mut exponent = None;
        for (k, ((&free, &inertia), &pushed)) in free.iter().zip(inertia).zip(pushed).enumerate() {
            let largest = larger(T::ZERO, &[free, inertia, pushed], T::ONE);
            if largest > T::ZERO && largest.is_finite() {
                exponent = exponent.max(Some(2 * largest.exponent() + weight(k).exponent()));
            }
        }
        let unit = exponent.map_or(T::ONE, |exponent: i32| T::power_of_two(-(exponent >> 1)));
        Self::in_unit(free, inertia, pushed, unit, weight)
    }

    /// Can none of its squares have overflown or vanished?
    fn is_safe(&self) -> bool {
        let tiny = T::EPSILON * T::EPSILON * T::EPSILON;
        self.size > tiny && self.size * tiny < T::ONE
    }

    #[cfg_attr(target_os = "none", inline(never))]
    fn in_unit<const N: usize>(
        free: &[T; N],
        inertia: &[T; N],
        pushed: &[T; N],
        unit: T,
        weight: impl Fn(usize) -> T,
    ) -> Self {
        let [mut residual, mut size_free, mut size_v, mut size_r] = [T::ZERO; 4];
        let sums = free.iter().zip(inertia).zip(pushed).enumerate();
        for (k, ((&free, &inertia), &pushed)) in sums {
            let (free, inertia, pushed) = (unit * free, unit * inertia, unit * pushed);
            let (gap, weight) = (inertia - free - pushed, weight(k));
            residual += gap * gap * weight;
            size_free += free * free * weight;
            size_v += inertia * inertia * weight;
            size_r += pushed * pushed * weight;
        }
        Self {
            residual,
            size: size_free.max(size_v).max(size_r),
            free: size_free,
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

/// Evaluates the dynamics, and fills `u = H v + w`, without compliance, of impulses in rows that are not scaled.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn momentum<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    scene: &Scene<T, N, D, C, R>,
    free: &[T; N],
    v: &[T; N],
    r: &Stacked<T, D, C, R>,
    u: &mut Stacked<T, D, C, R>,
) -> Dynamics<T> {
    let mass = &scene.mass().data.0;
    // M v and Hᵀ r, by dofs.
    let mut inertia = [T::ONE; N]; // all of it is overwritten, and zeros would call memset
    let mut pushed = [T::ZERO; N];
    if N * size_of::<T>() <= SUMS {
        multiply::<T, N, N>(mass, 0, v, &mut inertia);
    } else {
        // The last block repeats some rows, so that all blocks have the same size.
        let (mut first, last) = (0, N - BLOCK);
        while first < last + BLOCK {
            multiply::<T, N, BLOCK>(mass, first.min(last), v, &mut inertia);
            first += BLOCK;
        }
    }
    let mut magnitudes = T::ZERO;
    for (row, (&r, u)) in scene.rows().iter().zip(r.rows.iter().zip(&mut u.rows)) {
        let [entries] = &row.row.data.0;
        *u = dot(entries, v) + row.offset;
        if r != T::ZERO {
            axpy(r, entries, &mut pushed);
            magnitudes += r * r * square(entries);
        }
    }
    let (groups, last) = v.as_chunks::<GROUP>();
    let (places, place) = pushed.as_chunks_mut::<GROUP>();
    let contacts = scene.supported().zip(&r.contacts).zip(&mut u.contacts);
    for (((contact, support), r), u) in contacts {
        let mut velocity: [T; D] = contact.offset.into();
        let mut squares = [T::ZERO; D];
        let (columns, rest) = contact.jacobian.data.0.as_chunks::<GROUP>();
        for group in support.groups::<N>() {
            let columns = columns.get(group);
            if let (Some(columns), Some(v), Some(pushed)) =
                (columns, groups.get(group), places.get_mut(group))
            {
                add_columns(columns, v, &mut velocity);
                add_products(columns, *r, pushed);
                add_row_squares(columns, &mut squares);
            }
        }
        add_columns(rest, last, &mut velocity);
        add_products(rest, *r, place);
        add_row_squares(rest, &mut squares);
        for (&r, square) in r.iter().zip(squares) {
            magnitudes += r * r * square;
        }
        *u = velocity;
    }
    Dynamics {
        plain: Norms::of(free, &inertia, &pushed, |_| T::ONE),
        pushed: magnitudes,
        weighted: scene
            .is_mixed()
            .then(|| Norms::of(free, &inertia, &pushed, weights(mass))),
    }
}

/// `sums_d += Σ_j column_jd²`
#[inline]
fn add_row_squares<T: Real, const D: usize>(columns: &[[T; D]], sums: &mut [T; D]) {
    for column in columns {
        for (sum, &entry) in sums.iter_mut().zip(column) {
            *sum += entry * entry;
        }
    }
}

/// `K` entries of `M v` from row `first` on.
#[inline]
fn multiply<T: Real, const N: usize, const K: usize>(
    mass: &[[T; N]; N],
    first: usize,
    v: &[T; N],
    products: &mut [T; N],
) {
    let mut sums = [T::ZERO; K];
    // All of it unrolled at once would have more sums than registers.
    for (column, &v) in mass.as_slice().iter().zip(v) {
        let Some(column) = column.get(first..).and_then(<[T]>::first_chunk::<K>) else {
            break;
        };
        for (sum, &mass) in sums.iter_mut().zip(column) {
            *sum += mass * v;
        }
    }
    for (product, sum) in products.iter_mut().skip(first).zip(sums) {
        *product = sum;
    }
}

#[cfg(test)]
mod tests;
