//! The second part of the error, `|M v - M v_free - Hᵀ r|`, and `u = H v + w` on the way.

use crate::laws::{Coulomb, Laws, Room};
use crate::linalg::cholesky::BLOCK;
use crate::linalg::hints::{opaque, rolled};
use crate::linalg::sparsity::{GROUP, add_columns, add_products};
use crate::problem::residual::{larger, root_sum, unit};
use crate::{Real, Scene};
use core::hint::black_box;

/// Bytes of sums that fit into registers, with a quarter left for the terms: 32 words on a Cortex-M4F, 32 doubles in 16
/// vectors on a desktop.
const SUMS: usize = if cfg!(target_os = "none") { 96 } else { 192 };

/// The dynamics in the norm of momenta, and in a scene with joint rows also in the norm `Σ e_k² m / M_kk`, in which no light
/// finger is lost beside a heavy body (`m` is the reference mass).
pub(crate) struct Dynamics<T: Real, L: Laws = Coulomb> {
    pub(crate) plain: Norms<T>,
    /// `Σ_a r_a² |H_a|²` over the rows, a bound on the sums of magnitudes in `Hᵀ r`.
    pub(crate) pushed: T,
    pub(crate) weighted: L::Room<Norms<T>>,
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
    fn of<const N: usize>(free: &[T; N], inertia: &[T; N], pushed: &[T; N]) -> Self {
        let norms = Self::in_unit(free, inertia, pushed, T::ONE, |_| T::ONE);
        if norms.is_safe() {
            return norms;
        }
        let mut largest = T::ZERO;
        for ((&free, &inertia), &pushed) in opaque(free).iter().zip(inertia).zip(pushed) {
            rolled();
            largest = larger(largest, &[free, inertia, pushed], T::ONE);
        }
        Self::in_unit(free, inertia, pushed, unit(largest), |_| T::ONE)
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
        let sums = opaque(free).iter().zip(inertia).zip(pushed).enumerate();
        for (k, ((&free, &inertia), &pushed)) in sums {
            rolled();
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
            rolled();
            let gap = self.unit * gap;
            self.residual += gap * gap * weight(k);
        }
    }

    /// Momenta are compared with no less than this.
    pub(crate) fn compare_with(&mut self, least: T) {
        let least = least * self.unit;
        self.size = self.size.max(least * least);
    }
}

impl<T: Real, L: Laws> Dynamics<T, L> {
    /// Takes `M v - M v_free - Hᵀ r`, computed anew.
    pub(crate) fn replace_gaps<const N: usize, const D: usize, const C: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, L>,
        gaps: &[T; N],
    ) {
        self.plain.replace_gaps(gaps, |_| T::ONE);
        if let Some(weighted) = self.weighted.get_mut() {
            weighted.replace_gaps(gaps, weights(scene));
        }
    }
}

/// `m / M_kk` with the reference mass `m`.
fn weights<T: Real, const N: usize, const D: usize, const C: usize, L: Laws>(
    scene: &Scene<T, N, D, C, L>,
) -> impl Fn(usize) -> T + Copy {
    let (mass, reference) = (&scene.mass().data.0, scene.reference_mass());
    move |k| {
        let own = mass.get(k).and_then(|column| column.get(k)).copied();
        reference / own.unwrap_or(T::ONE)
    }
}

/// Evaluates the dynamics, and fills `u = H v + w`.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn momentum<T: Real, const N: usize, const D: usize, const C: usize, L: Laws>(
    scene: &Scene<T, N, D, C, L>,
    free: &[T; N],
    v: &[T; N],
    r: &[[T; D]],
    u: &mut [[T; D]],
) -> Dynamics<T, L> {
    let mass = &scene.mass().data.0;
    // M v and Hᵀ r, by dofs.
    let mut inertia = [T::ONE; N]; // all of it is overwritten, and zeros would call memset
    let mut pushed = [T::ZERO; N];
    if N * size_of::<T>() <= SUMS {
        multiply::<T, N, N>(mass, 0, v, &mut inertia);
    } else {
        // The last block repeats some rows, so that all blocks have the same size.
        let (mut first, last) = (0, black_box(N - BLOCK));
        while first < last + BLOCK {
            multiply::<T, N, BLOCK>(mass, first.min(last), v, &mut inertia);
            first += BLOCK;
        }
    }
    let (groups, last) = v.as_chunks::<GROUP>();
    let (places, place) = pushed.as_chunks_mut::<GROUP>();
    let mut magnitudes = T::ZERO;
    for (((contact, support), r), u) in scene.supported().zip(r).zip(u) {
        rolled();
        let mut velocity: [T; D] = contact.offset.into();
        let mut squares = [T::ZERO; D];
        let (columns, rest) = contact.jacobian.data.0.as_chunks::<GROUP>();
        for group in support.groups::<N>() {
            rolled();
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
    let plain = Norms::of(free, &inertia, &pushed);
    let mut weighted = L::Room::EMPTY;
    if L::MIXED {
        weighted = L::Room::with(weighted_norms(weights(scene), free, &inertia, &pushed));
    }
    Dynamics {
        plain,
        pushed: magnitudes,
        weighted,
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

/// In the norm `Σ e_k² m / M_kk`; with roots only where squares might overflow or vanish.
fn weighted_norms<T: Real, const N: usize>(
    weight: impl Fn(usize) -> T + Copy,
    free: &[T; N],
    inertia: &[T; N],
    pushed: &[T; N],
) -> Norms<T> {
    let norms = Norms::in_unit(free, inertia, pushed, T::ONE, weight);
    if norms.is_safe() {
        return norms;
    }
    let [free, inertia, pushed] = [free, inertia, pushed].map(|sums| {
        let mut k = 0..N;
        sums.map(|sum| sum * k.next().map_or(T::ONE, weight).square_root())
    });
    Norms::of(&free, &inertia, &pushed)
}

/// `R` entries of `M v` from row `first` on.
#[inline]
fn multiply<T: Real, const N: usize, const R: usize>(
    mass: &[[T; N]; N],
    first: usize,
    v: &[T; N],
    products: &mut [T; N],
) {
    let mut sums = [T::ZERO; R];
    // All of it unrolled at once would have more sums than registers.
    for (column, &v) in black_box(mass.as_slice()).iter().zip(v) {
        rolled();
        let Some(column) = column.get(first..).and_then(<[T]>::first_chunk::<R>) else {
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
