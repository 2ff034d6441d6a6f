//! Changes of data and of solutions, and what the derivative makes of one out of the other.

use super::Derivative;
use super::local::{Local, LocalRow};
use crate::linalg::blocks::product;
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::zeros;
use crate::real::Real;
use nalgebra::SVector;

/// A change of the data of a solve, or a gradient with respect to them.
///
/// Entries are those of the scene's contacts and joint rows, in its order; others are not read, and 0 in a gradient. `M`, `H` and
/// compliance change through these, with the `v` and `r` of the solution:
///
/// | change | is that of | gradient |
/// |---|---|---|
/// | `dM` of the mass matrix | `free_impulse` by `-dM v` | `-free_impulse vᵀ` |
/// | `dH_i` of a Jacobian | `free_impulse` by `dH_iᵀ r_i`, `offsets[i]` by `dH_i v` | `offsets[i] vᵀ + r_i free_impulseᵀ` |
/// | the same of a joint row | `free_impulse` by `dH_jᵀ λ_j`, `row_offsets[j]` by `dH_j v` | `row_offsets[j] vᵀ + λ_j free_impulseᵀ` |
/// | `dR` of compliance | `offsets[i]` by `dR r_i`, `row_offsets[j]` by `dR λ_j` | `offsets[i] r_i`, row by row; `row_offsets[j] λ_j` |
///
/// (`M` with the free impulse as it is. Who computes that from `M` adds what it changes by.)
#[derive(Clone, Debug, PartialEq)]
pub struct Inputs<T, const N: usize, const D: usize, const C: usize, const R: usize = 0> {
    /// Free impulse `M v_free` (N·s).
    pub free_impulse: SVector<T, N>,
    /// Offsets `w_i` of contacts (m/s).
    pub offsets: [SVector<T, D>; C],
    /// Friction coefficients, as [`crate::Scene::set_friction`] sets them.
    pub friction: [T; C],
    /// Offsets of joint rows (m/s, rad/s).
    pub row_offsets: [T; R],
    /// Bounds of joint rows, lower and upper (N·s, N·m·s); of a [`crate::RowLaw::Box`] alone.
    pub bounds: [[T; 2]; R],
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>
    Inputs<T, N, D, C, R>
{
    /// No change.
    #[must_use]
    pub const fn zero() -> Self {
        Self {
            free_impulse: zeros(),
            offsets: [const { zeros() }; C],
            friction: [T::ZERO; C],
            row_offsets: [T::ZERO; R],
            bounds: [[T::ZERO; 2]; R],
        }
    }
}

/// A change of a solution, or the weights of its parts in a sum.
#[derive(Clone, Debug, PartialEq)]
pub struct Outputs<T, const N: usize, const D: usize, const C: usize, const R: usize = 0> {
    /// Generalised velocity `v`.
    pub velocity: SVector<T, N>,
    /// Contact impulses `r_i` (N·s), normal first, in the order of the scene.
    pub impulses: [SVector<T, D>; C],
    /// Impulses `λ_j` of joint rows (N·s, N·m·s).
    pub row_impulses: [T; R],
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>
    Outputs<T, N, D, C, R>
{
    /// No change.
    #[must_use]
    pub const fn zero() -> Self {
        Self {
            velocity: zeros(),
            impulses: [const { zeros() }; C],
            row_impulses: [T::ZERO; R],
        }
    }
}

/// `Z` or `Y`.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Free,
    Held,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Derivative<'_, T, N, D, C, R, S>
{
    /// The change of the solution with this change of the data: `N²` multiplications, `2 N m` for `m` contact and joint rows in use,
    /// and `u²` for `u` of them that hold.
    #[must_use]
    pub fn forward(&self, change: &Inputs<T, N, D, C, R>) -> Outputs<T, N, D, C, R> {
        let [mut momentum] = change.free_impulse.data.0;
        self.factor.whiten(&mut momentum);
        let mut impulses = self.given(change);
        let b = self.right_side(change, &momentum, &impulses);
        if let Some((x, _)) = self.lu.solve(&b) {
            for (sum, &found) in impulses.iter_mut().zip(self.spread(&x, Side::Free).iter()) {
                *sum += found;
            }
        }
        let mut response = Outputs::zero();
        let [v] = &mut response.velocity.data.0;
        self.factor.velocity(&momentum, &impulses, v);
        let places = response.impulses.iter_mut().zip(&impulses.contacts);
        for (i, (place, &impulse)) in places.enumerate() {
            *place = self.scene.scale(i, impulse).into();
        }
        response.row_impulses = impulses.rows;
        response
    }

    /// The largest share of a change that no velocity follows (dimensionless): rounding where the change fits.
    ///
    /// In a hyperstatic scene offsets and Jacobians may change so that not all contacts can keep their modes: a fourth leg becomes shorter.
    /// There is no derivative then, and [`Self::forward`] lets the contacts go that it has no pivot for.
    #[must_use]
    pub fn misfit(&self, change: &Inputs<T, N, D, C, R>) -> T {
        let [mut momentum] = change.free_impulse.data.0;
        self.factor.whiten(&mut momentum);
        let b = self.right_side(change, &momentum, &self.given(change));
        let largest = b.max(0..D * C + R);
        let left = self.lu.solve(&b).map_or(T::ZERO, |(_, left)| left);
        crate::linalg::vector::quotient(left, largest)
    }

    /// The gradient of `Σ weight · change` of the solution with respect to the data, at the cost of [`Self::forward`] and `m²`
    /// multiplications.
    #[must_use]
    pub fn adjoint(&self, weights: &Outputs<T, N, D, C, R>) -> Inputs<T, N, D, C, R> {
        let [mut momentum] = weights.velocity.data.0;
        self.factor.whiten(&mut momentum);
        let mut pull = Stacked::zero();
        self.factor.contact_velocity(&momentum, &mut pull);
        for (i, (pull, weight)) in pull.contacts.iter_mut().zip(&weights.impulses).enumerate() {
            add(pull, &self.scene.scale(i, (*weight).into()));
        }
        for (pull, &weight) in pull.rows.iter_mut().zip(&weights.row_impulses) {
            *pull += weight;
        }
        let c = self.collect(&pull, Side::Free);
        let y = self.lu.solve_transposed(&c).unwrap_or(Stacked::zero());
        let mut answer = self.spread(&y, Side::Held);
        answer.iter_mut().for_each(|answer| *answer = -*answer);
        let mut moved = Stacked::zero();
        if self.is_given() {
            let counts = self.scene.counts();
            self.factor.delassus().times(&answer, &mut moved, counts);
        }

        let mut gradient = Inputs::zero();
        let [p] = &mut gradient.free_impulse.data.0;
        self.factor.velocity(&momentum, &answer, p);
        let mut unknown = 0;
        let places = gradient.offsets.iter_mut().zip(&mut gradient.friction);
        let sources = answer
            .contacts
            .iter()
            .zip(pull.contacts.iter().zip(&moved.contacts));
        for (i, ((local, (offset, mu)), (&answer, (pull, moved)))) in
            self.contacts.iter().zip(places).zip(sources).enumerate()
        {
            *offset = self.scene.scale(i, answer).into();
            *mu = product(&local.rub, pull) + product(&local.rub, moved);
            if local.lift > T::ZERO {
                *mu += local.lift * y.at(unknown).copied().unwrap_or(T::ZERO);
            }
            unknown += local.count;
        }
        gradient.row_offsets = answer.rows;
        let sources = self.rows.iter().zip(pull.rows.iter().zip(&moved.rows));
        for (bounds, (local, (&pull, &moved))) in gradient.bounds.iter_mut().zip(sources) {
            *bounds = local.follows.map(|follows| follows * (pull + moved));
        }
        gradient
    }

    /// Is there an impulse that changes by itself: friction that slips, a row at its bound?
    fn is_given(&self) -> bool {
        let mut rubs = self.contacts.iter().map(|local| local.rub);
        let mut follows = self.rows.iter().map(|local| local.follows);
        rubs.any(|rub| rub != [T::ZERO; D]) || follows.any(|follows| follows != [T::ZERO; 2])
    }

    /// What impulses change by themselves.
    fn given(&self, change: &Inputs<T, N, D, C, R>) -> Stacked<T, D, C, R> {
        let mut given = Stacked::zero();
        let sources = self.contacts.iter().zip(&change.friction);
        for (given, (local, &mu)) in given.contacts.iter_mut().zip(sources) {
            *given = local.rub.map(|rub| rub * mu);
        }
        let sources = self.rows.iter().zip(&change.bounds);
        for (given, (local, bounds)) in given.rows.iter_mut().zip(sources) {
            *given = product(&local.follows, bounds);
        }
        given
    }

    /// `k - Yᵀ (W d0 + dq)`
    fn right_side(
        &self,
        change: &Inputs<T, N, D, C, R>,
        momentum: &[T; N],
        given: &Stacked<T, D, C, R>,
    ) -> Stacked<T, D, C, R> {
        let (mut moved, counts) = (Stacked::zero(), self.scene.counts());
        self.factor.contact_velocity(momentum, &mut moved);
        for (i, (moved, &offset)) in moved.contacts.iter_mut().zip(&change.offsets).enumerate() {
            add(moved, &self.scene.scale(i, offset.into()));
        }
        for (moved, &offset) in moved.rows.iter_mut().zip(&change.row_offsets) {
            *moved += offset;
        }
        if given.iter().any(|&given| given != T::ZERO) {
            let mut more = Stacked::zero();
            self.factor.delassus().times(given, &mut more, counts);
            for (moved, &more) in moved.iter_mut().zip(more.iter()) {
                *moved += more;
            }
        }
        let mut b = self.collect(&moved, Side::Held);
        b.iter_mut().for_each(|b| *b = -*b);
        let mut first = 0;
        for (local, &mu) in self.contacts.iter().zip(&change.friction) {
            if local.lift > T::ZERO
                && let Some(b) = b.at_mut(first)
            {
                *b += local.lift * mu;
            }
            first += local.count;
        }
        b
    }

    /// From unknowns to contacts and joint rows: `Z x`, `Y x`.
    pub(super) fn spread(&self, x: &Stacked<T, D, C, R>, side: Side) -> Stacked<T, D, C, R> {
        let (mut spread, mut places) = (Stacked::zero(), x.iter());
        for (sum, local) in spread.contacts.iter_mut().zip(&self.contacts) {
            let vectors = if side == Side::Free {
                &local.free
            } else {
                &local.held
            };
            for (vector, &x) in vectors.iter().take(local.count).zip(&mut places) {
                add(sum, &vector.map(|entry| entry * x));
            }
        }
        for (sum, local) in spread.rows.iter_mut().zip(&self.rows) {
            if local.count() > 0
                && let Some(&x) = places.next()
            {
                *sum = local.scale * x;
            }
        }
        spread
    }

    /// The transpose of [`Self::spread`].
    fn collect(&self, u: &Stacked<T, D, C, R>, side: Side) -> Stacked<T, D, C, R> {
        let mut collected = Stacked::zero();
        collect(&self.contacts, &self.rows, u, side, &mut collected);
        collected
    }
}

/// From contacts and joint rows to unknowns: `Zᵀ u`, `Yᵀ u`.
pub(super) fn collect<T: Real, const D: usize, const C: usize, const R: usize>(
    contacts: &[Local<T, D>; C],
    rows: &[LocalRow<T>; R],
    u: &Stacked<T, D, C, R>,
    side: Side,
    collected: &mut Stacked<T, D, C, R>,
) {
    let mut places = collected.iter_mut();
    for (u, local) in u.contacts.iter().zip(contacts) {
        let vectors = if side == Side::Free {
            &local.free
        } else {
            &local.held
        };
        for vector in vectors.iter().take(local.count) {
            if let Some(place) = places.next() {
                *place = product(vector, u);
            }
        }
    }
    for (&u, local) in u.rows.iter().zip(rows) {
        if local.count() > 0
            && let Some(place) = places.next()
        {
            *place = local.scale * u;
        }
    }
}

/// Adds a vector.
fn add<T: Real, const D: usize>(sum: &mut [T; D], x: &[T; D]) {
    for (sum, &x) in sum.iter_mut().zip(x) {
        *sum += x;
    }
}
