//! The law of one contact and of one joint row, linearised where it stands.
//!
//! In the mode that it has, the impulse of a contact changes by `dr = Z x + rub dmu`, with unknowns `x` for which
//! `Y · du + c x = lift dmu` holds, `t = u_T / |u_T|`:
//!
//! | mode | `Z`: what may change of the impulse | `Y`, `c`: what is asked for |
//! |---|---|---|
//! | open | nothing | nothing |
//! | stick | all rows | `du = 0` |
//! | slip | the length of the impulse, `(1, -mu t)` | `du_N = 0` (of the relaxation `(1, -mu t) · du = \|u_T\| dmu`) |
//! | | its direction, `p ⟂ t` | `g p · du + h x / alpha = 0`, with `g : h = mu r_N : alpha \|u_T\|` and `g + h = 1` |
//!
//! The last one is the derivative of `-mu r_N t`, multiplied out: where a slide begins `|u_T| = 0` does no harm.

use crate::linalg::vector::square;
use crate::real::Real;
use crate::scene::{JointRow, RowLaw};
use crate::sets::ContactSet;
use crate::solution::{ContactMode, Model, RowMode, RowSolution};

/// A contact, in scaled rows. Unknowns and equations are scaled by about `sqrt(alpha)`, so that the matrix has no units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local<T, const D: usize> {
    /// Number of unknowns.
    pub(super) count: usize,
    /// Columns of `Z`.
    pub(super) free: [[T; D]; D],
    /// Rows of `Y`.
    pub(super) held: [[T; D]; D],
    /// `c`
    pub(super) damping: [T; D],
    /// By how much the impulse changes with `mu` by itself.
    pub(super) rub: [T; D],
    /// By how much the first equation does.
    pub(super) lift: T,
}

impl<T: Real, const D: usize> Local<T, D> {
    /// An open contact.
    pub(super) const fn open() -> Self {
        Self {
            count: 0,
            free: [[T::ZERO; D]; D],
            held: [[T::ZERO; D]; D],
            damping: [T::ZERO; D],
            rub: [T::ZERO; D],
            lift: T::ZERO,
        }
    }

    /// A contact in this mode. `moves`: does anything move this row?
    pub(super) fn new(
        set: &ContactSet<T, D>,
        model: Model,
        mode: ContactMode,
        (u, r): (&[T; D], &[T; D]),
        moves: impl Fn(usize) -> bool,
    ) -> Self {
        let mut local = Self::open();
        if set.alpha <= T::ZERO || mode == ContactMode::Open {
            return local;
        }
        let scale = root(set.alpha);
        if mode == ContactMode::Slip {
            local.slip(set, model, (u, r), scale);
            return local;
        }
        for k in (0..D).filter(|&k| moves(k)) {
            let mut row = [T::ZERO; D];
            if let Some(entry) = row.get_mut(k) {
                *entry = scale;
            }
            local.add(row, row, T::ZERO);
        }
        local
    }

    /// Adds an unknown and its equation.
    fn add(&mut self, free: [T; D], held: [T; D], damping: T) {
        let places = self.free.iter_mut().zip(&mut self.held);
        if let Some(((z, y), c)) = places.zip(&mut self.damping).nth(self.count) {
            (*z, *y, *c) = (free, held, damping);
            self.count += 1;
        }
    }

    /// Linearises a slide.
    fn slip(&mut self, set: &ContactSet<T, D>, model: Model, (u, r): (&[T; D], &[T; D]), scale: T) {
        let (mu, load) = (set.cone.friction(), r.first().copied().unwrap_or(T::ZERO));
        // The direction of the slide, also at its beginning: that of `alpha u_T - r_T`.
        let mut t = [T::ZERO; D];
        for ((t, &u), &r) in t.iter_mut().zip(u).zip(r).skip(1) {
            *t = set.alpha * u - r;
        }
        let length = square(&t).square_root();
        if length > T::ZERO {
            t = t.map(|t| t / length);
        }
        let speed = square(u.get(1..).unwrap_or_default()).square_root();
        let ray = with_normal(t.map(|t| -mu * t), T::ONE).map(|ray| ray * scale);
        let held = match model {
            Model::Coulomb => with_normal([T::ZERO; D], scale),
            Model::ConvexRelaxation => {
                self.lift = scale * speed;
                ray
            }
        };
        self.add(ray, held, T::ZERO);
        self.rub = t.map(|t| -load * t);
        let (grip, slide) = (mu * load, set.alpha * speed);
        let sum = grip + slide;
        if grip <= T::ZERO || sum <= T::ZERO {
            return;
        }
        let damping = slide / sum * (scale * scale / set.alpha);
        for j in 2..D {
            let across = across(&t, j).map(|p| p * scale);
            self.add(across, across.map(|p| p * grip / sum), damping);
        }
    }
}

/// Tangent `j - 1` perpendicular to the unit tangent `t`: a column of the reflection that takes the first tangent to it.
fn across<T: Real, const D: usize>(t: &[T; D], j: usize) -> [T; D] {
    let (first, own) = (t.get(1).copied(), t.get(j).copied());
    let (Some(first), Some(own)) = (first, own) else {
        return *t;
    };
    let share = -own / (T::ONE + first.abs());
    let mut column = t.map(|t| t * share);
    if let [_, one, ..] = column.as_mut_slice() {
        *one = if first < T::ZERO { own } else { -own };
    }
    if let Some(entry) = column.get_mut(j) {
        *entry += T::ONE;
    }
    column
}

/// A vector with another normal part.
fn with_normal<T: Copy, const D: usize>(mut x: [T; D], normal: T) -> [T; D] {
    if let Some(first) = x.first_mut() {
        *first = normal;
    }
    x
}

/// A power of two near the root.
pub(super) fn root<T: Real>(alpha: T) -> T {
    T::power_of_two(alpha.exponent() >> 1)
}

/// A joint row.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalRow<T> {
    /// By what unknown and equation are scaled if it holds; otherwise its impulse is given, and this is 0.
    pub(super) scale: T,
    /// By how much its impulse changes with each bound.
    pub(super) follows: [T; 2],
}

impl<T: Real> LocalRow<T> {
    /// A row with an impulse that stays.
    pub(super) const fn open() -> Self {
        Self {
            scale: T::ZERO,
            follows: [T::ZERO; 2],
        }
    }

    /// A row in this mode.
    pub(super) fn new<const N: usize>(
        row: &JointRow<T, N>,
        alpha: T,
        found: &RowSolution<T>,
    ) -> Self {
        let mut local = Self::open();
        let [lower, upper] = &mut local.follows;
        match found.mode {
            RowMode::AtLower => *lower = T::ONE,
            RowMode::AtUpper => *upper = T::ONE,
            RowMode::AtLimit | RowMode::Holding if alpha > T::ZERO => local.scale = root(alpha),
            RowMode::Open | RowMode::AtLimit | RowMode::Holding => {}
        }
        if !matches!(row.law, RowLaw::Box { .. }) {
            local.follows = [T::ZERO; 2];
        }
        local
    }

    /// Number of unknowns.
    pub(super) fn count(&self) -> usize {
        usize::from(self.scale > T::ZERO)
    }
}
