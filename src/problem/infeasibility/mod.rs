//! Proof that a scene has no solution: Farkas' lemma over rigid contacts, limits and equalities.
//!
//! Coulomb's law asks for `H_N v + w_N >= 0`, a limit for `row · v + offset >= 0`, an equality for `row · v + offset = 0`. No velocity
//! satisfies all of them if and only if there is a `d`, not negative except on equalities, with `H_Nᵀ d_N + Jᵀ d_J = 0` and
//! `w_N · d_N + offset · d_J < 0`, for instance for two walls that close on a body. `J` has the joint rows. Boxes, tangents and compliant
//! rows ask for nothing. [`crate::guide::error`] says more under "Infeasible scenes".
//!
//! Two checks follow the search. A velocity `v` that satisfies the scene has `|w · d| <= |v|_M |Hᵀ d|_{M⁻¹}`. The first check
//! asks that it would be 1e9 times (f32: 4,200 times) as fast as the offsets. The second asks that each entry of `Hᵀ d` is zero
//! up to rounding, so that the entries of a heavy body do not hide one of a light body.

use crate::factor::{Delassus, Factor};
use crate::linalg::blocks::diagonal_of;
use crate::linalg::dot2::Dot2;
use crate::linalg::stacked::{Stacked, StackedMatrix};
use crate::linalg::vector::at_least;
use crate::linalg::zip::{zip3, zip4, zip5};
use crate::problem::Problem;
use crate::real::Real;
use crate::scene::{RowLaw, Scene};
use search::{Demand, Search};

mod jam;
mod search;
mod squeeze;

/// One number for the normal of each contact, and one for each joint row.
pub(crate) type Proof<T, const C: usize, const R: usize> = Stacked<T, 1, C, R>;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Problem<'_, T, N, D, C, R, S>
{
    /// Searches for a `d` that proves the scene infeasible, in physical rows; `None` if it finds none.
    #[inline(never)]
    pub(crate) fn certificate(&self) -> Option<Stacked<T, D, C, R>> {
        let (scene, factor) = (self.scene, self.factor);
        let (mut demands, mut offsets) = (scene.demands(), scene.offsets());
        let mass = scene.reference_mass();
        // Roots of effective masses over the reference mass; 0 for rows without a demand.
        let mut scales = Proof::zero();
        let contacts = (0..C).map(|i| factor.delassus().inverse_mass(i, 0));
        let inverse_masses = contacts.chain((0..R).map(|j| factor.delassus().row_inverse_mass(j)));
        let mut immovable = None;
        for (index, demand, offset, scale, inverse_mass) in
            zip5(0..C + R, demands.iter_mut(), offsets.iter_mut(), scales.iter_mut(), inverse_masses)
        {
            if *demand == Demand::Nothing || inverse_mass <= T::ZERO {
                if demand.is_violated(*offset) {
                    immovable = Some((index, *offset));
                }
                (*demand, *offset) = (Demand::Nothing, T::ZERO);
                continue;
            }
            *scale = T::ONE / (inverse_mass * mass).square_root();
            *offset *= *scale;
        }
        if let Some((index, offset)) = immovable {
            // A violated row that nothing moves is a proof by itself.
            let mut alone = Proof::zero();
            let sign = if offset < T::ZERO { T::ONE } else { -T::ONE };
            *alone.iter_mut().nth(index)? = sign;
            return Some(normals(&alone));
        }
        let mut search = Search { demands, gram: StackedMatrix::zero(), offsets };
        normalised(factor.delassus(), mass, &scales, &mut search.gram);
        let fastest = offsets.iter();
        let fastest = fastest.fold(T::ZERO, |fastest, g| at_least(g.abs(), fastest));
        let mut d = search.minimise(fastest)?;
        search.purify(&mut d)?;
        // Two steps of iterative refinement: `W d` is rounding.
        for _ in 0..2 {
            let residual = row_products(factor, &product(&d, &scales), mass);
            search.correct(&mut d, &product(&residual, &scales))?;
        }
        let approach = -product(&d, &offsets).iter().fold(T::ZERO, |sum, &x| sum + x);
        let [proof, d] = [normals(&product(&d, &scales)), normals(&d)];
        let is_strong = is_strong(self.leak(&proof), approach, &normals(&offsets), &d);
        (is_strong && scene.cancels(&proof, &d)).then_some(proof)
    }

    /// `|Hᵀ d|` in the norm of `m M⁻¹`, with the reference mass `m`. (Where `M` is nearly singular, that norm would magnify the rounding of
    /// sums without twice the digits.)
    #[inline(never)]
    fn leak(&self, d: &Stacked<T, D, C, R>) -> T {
        let mut sums = [Dot2::of(T::ZERO); N];
        self.scene.add_momentum(d, &mut sums);
        let mut momentum = sums.map(Dot2::value);
        self.factor.whiten(&mut momentum);
        (self.factor.energy(&momentum) * self.scene.reference_mass()).square_root()
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Scene<T, N, D, C, R, S>
{
    /// The demand of the normal of each contact, and of each joint row.
    fn demands(&self) -> Proof<Demand, C, R> {
        let mut demands = Proof { contacts: [[Demand::Nothing]; C], rows: [Demand::Nothing; R] };
        let contacts = demands.contacts.iter_mut().enumerate();
        for (i, [demand]) in contacts.take(self.contacts().len()) {
            let scaling = self.scaling(i);
            let compliance = scaling.and_then(|scaling| scaling.compliance.first());
            if compliance.is_none_or(|&compliance| compliance == T::ZERO) {
                *demand = Demand::NotNegative;
            }
        }
        for (demand, row) in demands.rows.iter_mut().zip(self.rows()) {
            if row.compliance == T::ZERO {
                *demand = match row.law {
                    RowLaw::Limit => Demand::NotNegative,
                    RowLaw::Equality => Demand::Zero,
                    RowLaw::Box { .. } => Demand::Nothing,
                };
            }
        }
        demands
    }

    /// Normal offsets of contacts, and offsets of joint rows.
    fn offsets(&self) -> Proof<T, C, R> {
        let mut offsets = Proof::zero();
        for ([offset], contact) in offsets.contacts.iter_mut().zip(self.contacts()) {
            *offset = contact.offset.iter().next().copied().unwrap_or(T::ZERO);
        }
        for (offset, row) in offsets.rows.iter_mut().zip(self.rows()) {
            *offset = row.offset;
        }
        offsets
    }

    /// Does standing still violate any demand? Otherwise the scene is feasible.
    pub(crate) fn is_conceivably_infeasible(&self) -> bool {
        let (demands, offsets) = (self.demands(), self.offsets());
        let mut rows = demands.iter().zip(offsets.iter());
        rows.any(|(demand, &offset)| demand.is_violated(offset))
    }

    /// Is each entry of `Hᵀ d_N + Jᵀ d_J` zero up to rounding: at most 1e-9 (f32: 8 eps) of `Σ |weights|` times the largest entry
    /// of its column in rows of unit effective mass? In such rows `d` is `weights`.
    #[inline(never)]
    fn cancels(&self, d: &Stacked<T, D, C, R>, weights: &Stacked<T, D, C, R>) -> bool {
        let [mut sums, mut sizes] = [[T::ZERO; N]; 2];
        let mut add = |column: usize, entry: T, d: T, weight: T| {
            let targets = sums.get_mut(column).zip(sizes.get_mut(column));
            if let Some((sum, size)) = targets.filter(|_| weight != T::ZERO) {
                *sum += entry * d;
                *size = at_least((entry * d / weight).abs(), *size);
            }
        };
        for (contact, d, weights) in zip3(self.contacts(), &d.contacts, &weights.contacts) {
            for (column, entries) in contact.jacobian.data.0.iter().enumerate() {
                for (&entry, &d, &weight) in zip3(entries, d, weights) {
                    add(column, entry, d, weight);
                }
            }
        }
        for (row, &d, &weight) in zip3(self.rows(), &d.rows, &weights.rows) {
            for (column, &entry) in row.row.iter().enumerate() {
                add(column, entry, d, weight);
            }
        }
        let total = weights.iter().fold(T::ZERO, |sum, weight| sum + weight.abs());
        let share = T::literal(1e-9).max(T::literal(8.0) * T::EPSILON) * total;
        let reference = self.reference_mass();
        let mut entries = zip3(&sums, &sizes, diagonal_of(&self.mass().data.0));
        entries.all(|(sum, &size, mass)| {
            // An entry that is tiny beside the root of the mass counts as rounding.
            let root = (mass / reference).square_root();
            sum.abs() <= share * (size + root * T::literal(1e-6))
        })
    }
}

/// Fills `gram` with `W`, scaled to a unit diagonal, for the rows with a scale.
fn normalised<T: Real, const D: usize, const C: usize, const R: usize>(
    delassus: &Delassus<T, D, C, R>,
    mass: T,
    scales: &Proof<T, C, R>,
    gram: &mut StackedMatrix<T, 1, C, R>,
) {
    // Unused rows, whose scale is 0, may have numbers of an earlier scene in the factor.
    let entry = |source: T, x: T, y: T| {
        let used = x > T::ZERO && y > T::ZERO;
        if used { x * y * (source * mass) } else { T::ZERO }
    };
    for ([row], sources, &[x]) in zip3(&mut gram.contacts, &delassus.contacts, &scales.contacts) {
        let Some(sources) = sources.first() else {
            continue;
        };
        for ([target], source, &[y]) in zip3(&mut row.contacts, sources, &scales.contacts) {
            *target = entry(source.first().copied().unwrap_or(T::ZERO), x, y);
        }
    }
    for (j, row, sources, &x) in zip4(0..R, &mut gram.rows, &delassus.rows, &scales.rows) {
        for ([target], [mirrored], source, &[y]) in
            zip4(&mut row.contacts, &mut gram.contacts, &sources.contacts, &scales.contacts)
        {
            *target = entry(source.first().copied().unwrap_or(T::ZERO), x, y);
            if let Some(mirrored) = mirrored.rows.get_mut(j) {
                *mirrored = *target;
            }
        }
        for (target, &source, &y) in zip3(&mut row.rows, &sources.rows, &scales.rows) {
            *target = entry(source, x, y);
        }
    }
}

/// Is `approach = -w · d` so large, compared with `leak = |Hᵀ d|`, that a velocity which meets the offsets would be 1e9 times
/// (f32: 4,200 times) as fast as the fastest of them? `offsets` and `x` are `w` and `d` in rows of unit effective mass.
#[inline(never)]
fn is_strong<T: Real, const D: usize, const C: usize, const R: usize>(
    mut leak: T,
    approach: T,
    offsets: &Stacked<T, D, C, R>,
    x: &Stacked<T, D, C, R>,
) -> bool {
    let mut fastest = T::ZERO;
    for (&offset, &x) in offsets.iter().zip(x.iter()) {
        fastest = at_least(offset.abs(), fastest);
        leak += x.abs() * T::literal(0.25) * T::EPSILON; // rounding of the leak
    }
    let proportion = T::literal(1e9).min(T::literal(5e-4) / T::EPSILON);
    approach > T::ZERO && leak * proportion * fastest <= approach
}

/// `m W d` without compliance, with the reference mass `m`. It is computed from `Hᵀ d`, so the rounding of `W` does not enter.
fn row_products<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    factor: &Factor<T, N, D, C, R>,
    d: &Proof<T, C, R>,
    mass: T,
) -> Proof<T, C, R> {
    let rows = normals(d);
    let mut velocities = Stacked::zero();
    factor.impulse_velocity(&[T::ZERO; N], &rows, &mut velocities);
    let mut products = Proof::zero();
    for ([product], velocity) in products.contacts.iter_mut().zip(&velocities.contacts) {
        *product = velocity.first().copied().unwrap_or(T::ZERO) * mass;
    }
    products.rows = velocities.rows.map(|velocity| velocity * mass);
    products
}

/// How far a velocity violates the law of its row: that with which a limit closes, and any of an equality.
#[inline]
fn violation<T: Real>(law: RowLaw<T>, velocity: T) -> T {
    match law {
        RowLaw::Limit => at_least(-velocity, T::ZERO),
        RowLaw::Equality => velocity,
        RowLaw::Box { .. } => T::ZERO,
    }
}

/// `x · y`
#[inline(never)]
fn dot<T: Real, const D: usize, const C: usize, const R: usize>(
    x: &Stacked<T, D, C, R>,
    y: &Stacked<T, D, C, R>,
) -> T {
    x.iter().zip(y.iter()).fold(T::ZERO, |sum, (&x, &y)| sum + x * y)
}

/// Multiplies `x` by the weights, entry by entry.
#[inline(never)]
fn weigh<T: Real, const D: usize, const C: usize, const R: usize>(
    x: &mut Stacked<T, D, C, R>,
    weights: &Stacked<T, D, C, R>,
) {
    for (x, &weight) in x.iter_mut().zip(weights.iter()) {
        *x *= weight;
    }
}

/// `d` along the normals, with 0 along the tangents.
#[inline(never)]
fn normals<T: Real, const D: usize, const C: usize, const R: usize>(
    d: &Proof<T, C, R>,
) -> Stacked<T, D, C, R> {
    let mut stacked = Stacked::zero();
    for (row, &[d]) in stacked.contacts.iter_mut().zip(&d.contacts) {
        if let Some(first) = row.first_mut() {
            *first = d;
        }
    }
    stacked.rows = d.rows;
    stacked
}

/// The product, entry by entry.
fn product<T: Real, const C: usize, const R: usize>(
    x: &Proof<T, C, R>,
    y: &Proof<T, C, R>,
) -> Proof<T, C, R> {
    let mut product = *x;
    weigh(&mut product, y);
    product
}

#[cfg(test)]
mod tests;
