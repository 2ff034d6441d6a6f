//! The linearised laws of one contact and of one joint row, in the mode of the solution.
//!
//! The impulse of a contact changes by `dr = Z x + impulse_per_mu dmu`. The unknowns `x` satisfy
//! `Y · du + c x = equation_per_mu dmu`. With the direction `t = u_T / |u_T|` of a slip:
//!
//! | mode | columns of `Z`: changes of the impulse | `Y`, `c`: equations |
//! |---|---|---|
//! | open | none | none |
//! | stick | all rows | `du = 0` |
//! | slip | its length, `(1, -mu t)` | `du_N = 0` (in the relaxation `(1, -mu t) · du = \|u_T\| dmu`) |
//! | | its direction, `p ⟂ t` | `g p · du + h x / alpha = 0`, with `g : h = mu r_N : alpha \|u_T\|` and `g + h = 1` |
//!
//! The last equation is the derivative of `-mu r_N t`, multiplied by `|u_T|`: it also holds for `|u_T| = 0`, where a slip begins.

use crate::linalg::vector::square;
use crate::linalg::zip::zip3;
use crate::real::Real;
use crate::scene::{JointRow, RowLaw};
use crate::sets::ContactSet;
use crate::solution::{ContactMode, Model, RowMode, RowSolution};

/// One of the two matrices of the linearised laws.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Basis {
    /// Directions in which impulses may change.
    Z,
    /// Directions of velocities that have an equation.
    Y,
}

/// The linearised law of a contact, in scaled rows. Unknowns and equations are scaled by about `sqrt(alpha)`, so that the matrix `A` has no
/// unit.
#[derive(Clone, Copy, Debug)]
pub(super) struct LinearContact<T, const D: usize> {
    /// Number of unknowns, at most `D`.
    pub(super) count: usize,
    /// Columns of `Z`.
    z: [[T; D]; D],
    /// Columns of `Y`, one an equation.
    y: [[T; D]; D],
    /// Diagonal of `c`.
    c: [T; D],
    /// Direct change of the impulse with `mu`.
    pub(super) impulse_per_mu: [T; D],
    /// Change of the right-hand side of the first equation with `mu`.
    pub(super) equation_per_mu: T,
}

impl<T: Real, const D: usize> LinearContact<T, D> {
    /// The law of an open contact.
    pub(super) const fn open() -> Self {
        Self {
            count: 0,
            z: [[T::ZERO; D]; D],
            y: [[T::ZERO; D]; D],
            c: [T::ZERO; D],
            impulse_per_mu: [T::ZERO; D],
            equation_per_mu: T::ZERO,
        }
    }

    /// The columns of `Z` or `Y`, one an unknown.
    pub(super) fn basis(&self, basis: Basis) -> impl Iterator<Item = &[T; D]> {
        let columns = match basis {
            Basis::Z => &self.z,
            Basis::Y => &self.y,
        };
        columns.iter().take(self.count)
    }

    /// The equations: columns of `Y` with their entries of `c`.
    pub(super) fn equations(&self) -> impl Iterator<Item = (&[T; D], &T)> {
        self.y.iter().zip(&self.c).take(self.count)
    }

    /// The law of a contact in this mode. `moves`: does this row move anything?
    pub(super) fn new(
        set: &ContactSet<T, D>,
        model: Model,
        mode: ContactMode,
        (u, r): (&[T; D], &[T; D]),
        moves: impl Fn(usize) -> bool,
    ) -> Self {
        let mut law = Self::open();
        if set.alpha <= T::ZERO || mode == ContactMode::Open {
            return law;
        }
        let scale = root(set.alpha);
        if mode == ContactMode::Slip {
            law.slip(set, model, (u, r), scale);
            return law;
        }
        for k in (0..set.pushing_rows()).filter(|&k| moves(k)) {
            let mut row = [T::ZERO; D];
            if let Some(entry) = row.get_mut(k) {
                *entry = scale;
            }
            law.add(row, row, T::ZERO);
        }
        law
    }

    /// Adds an unknown and its equation.
    fn add(&mut self, z: [T; D], y: [T; D], c: T) {
        let mut columns = zip3(&mut self.z, &mut self.y, &mut self.c);
        if let Some((new_z, new_y, new_c)) = columns.nth(self.count) {
            (*new_z, *new_y, *new_c) = (z, y, c);
            self.count += 1;
        }
    }

    /// Adds the unknowns and equations of a slipping contact.
    fn slip(&mut self, set: &ContactSet<T, D>, model: Model, (u, r): (&[T; D], &[T; D]), scale: T) {
        let (mu, load) = (set.cone.friction(), r.first().copied().unwrap_or(T::ZERO));
        // The direction of `alpha u_T - r_T` is that of the slip, also where the slip begins.
        let mut t = [T::ZERO; D];
        for (t, &u, &r) in zip3(&mut t, u, r).skip(1) {
            *t = set.alpha * u - r;
        }
        let length = square(&t).square_root();
        if length > T::ZERO {
            t = t.map(|t| t / length);
        }
        let speed = square(u.get(1..).unwrap_or_default()).square_root();
        let ray = with_normal(t.map(|t| -mu * t), T::ONE).map(|ray| ray * scale);
        let y = match model {
            Model::Coulomb => with_normal([T::ZERO; D], scale),
            Model::ConvexRelaxation => {
                self.equation_per_mu = scale * speed;
                ray
            }
        };
        self.add(ray, y, T::ZERO);
        self.impulse_per_mu = t.map(|t| -load * t);
        let (grip, slip) = (mu * load, set.alpha * speed);
        let sum = grip + slip;
        if grip <= T::ZERO || sum <= T::ZERO {
            return;
        }
        let c = slip / sum * (scale * scale / set.alpha);
        for j in 2..D {
            let across = across(&t, j).map(|p| p * scale);
            self.add(across, across.map(|p| p * grip / sum), c);
        }
    }
}

/// A unit tangent perpendicular to the unit tangent `t`, another one for each `j` from 2 to `D - 1`: column `j` of the reflection that
/// takes the first tangent to `t` (or `-t`).
fn across<T: Real, const D: usize>(t: &[T; D], j: usize) -> [T; D] {
    let (first, entry) = (t.get(1).copied(), t.get(j).copied());
    let (Some(first), Some(entry)) = (first, entry) else {
        return *t;
    };
    let share = -entry / (T::ONE + first.abs());
    let mut column = t.map(|t| t * share);
    if let [_, one, ..] = column.as_mut_slice() {
        *one = if first < T::ZERO { entry } else { -entry };
    }
    if let Some(entry) = column.get_mut(j) {
        *entry += T::ONE;
    }
    column
}

/// The vector `x` with the normal entry `normal`.
fn with_normal<T: Copy, const D: usize>(mut x: [T; D], normal: T) -> [T; D] {
    if let Some(first) = x.first_mut() {
        *first = normal;
    }
    x
}

/// A power of two near the square root of `alpha`.
fn root<T: Real>(alpha: T) -> T {
    T::power_of_two(alpha.exponent() >> 1)
}

/// The linearised law of a joint row.
#[derive(Clone, Copy, Debug)]
pub(super) struct LinearRow<T> {
    /// Scale of the unknown and the equation of a row that holds; 0 for other rows, which have none.
    pub(super) scale: T,
    /// Direct change of the impulse with each bound.
    pub(super) impulse_per_bound: [T; 2],
}

impl<T: Real> LinearRow<T> {
    /// The law of a row with a constant impulse.
    pub(super) const fn open() -> Self {
        Self { scale: T::ZERO, impulse_per_bound: [T::ZERO; 2] }
    }

    /// The law of a row in this mode.
    pub(super) fn new<const N: usize>(row: &JointRow<T, N>, alpha: T, found: &RowSolution<T>) -> Self {
        let mut law = Self::open();
        let [lower, upper] = &mut law.impulse_per_bound;
        match found.mode {
            RowMode::AtLower => *lower = T::ONE,
            RowMode::AtUpper => *upper = T::ONE,
            RowMode::AtLimit | RowMode::Holding if alpha > T::ZERO => law.scale = root(alpha),
            RowMode::Open | RowMode::AtLimit | RowMode::Holding => {}
        }
        if !matches!(row.law, RowLaw::Box { .. }) {
            law.impulse_per_bound = [T::ZERO; 2];
        }
        law
    }

    /// Number of unknowns.
    pub(super) fn count(&self) -> usize {
        usize::from(self.scale > T::ZERO)
    }
}
