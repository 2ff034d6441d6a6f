//! One contact on the central path: its impulse, its velocity and the algebra of its cone.
//!
//! With `Λ = diag(1, mu, ..., mu)` and `r = Λ x`, `y = Λ u` the friction cone is that of Lorentz, `x_N >= |x_T|`. `∘` is
//! the Jordan product of that cone, `a ∘ b = (a·b, a_N b_T + b_N a_T)`, `J = diag(1, -1, ..., -1)`,
//! `det a = a_N² - |a_T|²` and `Q(a) b = 2 a (a·b) - det(a) J b`.

use crate::Real;
use crate::cone::{add_to_normal, norm, split};
use crate::laws::{Coulomb, Laws, Room};
use crate::problem::ContactLaw;
use crate::solution::zeros;
use crate::solver::interior_point::lorentz::{
    across, divide, first, joined, jordan, keep_inside, reach, size,
};
use crate::solver::interior_point::row_pairs::RowPairs;
use nalgebra::SVector;

/// The part of a contact that is on the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// Nothing: nothing moves it.
    Nothing,
    /// Its normal row: it has no friction.
    Normal,
    /// All rows, the normal one apart: Coulomb's law.
    Coulomb,
    /// All rows as one: the convex relaxation.
    Cone,
}

impl Part {
    pub(crate) fn of<T: Real, const D: usize, L: Laws>(law: &ContactLaw<T, D, L>) -> Self {
        if law.alpha <= T::ZERO {
            Self::Nothing
        } else if law.rows() == 1 {
            Self::Normal
        } else if law.shift_factor > T::ZERO {
            Self::Coulomb
        } else {
            Self::Cone
        }
    }

    /// Are its rows bound to each other?
    pub(crate) fn is_cone<const D: usize>(self) -> bool {
        D > 1 && matches!(self, Self::Coulomb | Self::Cone)
    }

    /// Number of unknowns.
    pub(crate) fn count<const D: usize>(self) -> usize {
        match self {
            Self::Nothing => 0,
            Self::Normal => 1,
            Self::Coulomb | Self::Cone => D,
        }
    }
}

/// A contact on the central path, or how it moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair<T: Real, const D: usize, L: Laws = Coulomb> {
    pub(crate) part: Part,
    /// `x = Λ⁻¹ r`
    pub(crate) x: SVector<T, D>,
    /// `(s, y_T)`: an extra unknown `s >= |y_T|`, and the tangential velocity. In the convex relaxation `s` is `y_N`.
    pub(crate) w: SVector<T, D>,
    /// `y_N`; unused in the convex relaxation, where `w[0]` is `y_N`.
    pub(crate) normal: T,
    /// Of joint rows: in place of the three before, but for impulses.
    pub(super) rows: L::Room<RowPairs<T, D>>,
}

/// `Λ v`
pub(crate) fn widen<T: Real, const D: usize, L: Laws>(
    law: &ContactLaw<T, D, L>,
    v: &SVector<T, D>,
) -> SVector<T, D> {
    let mut wide = *v;
    if law.rows.get().is_some() {
        return wide;
    }
    for wide in wide.iter_mut().skip(1) {
        *wide *= law.cone.friction();
    }
    wide
}

/// `Λ_kk`
pub(crate) fn width<T: Real, const D: usize, L: Laws>(law: &ContactLaw<T, D, L>, k: usize) -> T {
    if k == 0 || law.rows.get().is_some() {
        T::ONE
    } else {
        law.cone.friction()
    }
}

/// `Λ⁻¹ v`
fn narrow<T: Real, const D: usize, L: Laws>(
    law: &ContactLaw<T, D, L>,
    v: &SVector<T, D>,
) -> SVector<T, D> {
    joined(first(v), v / law.cone.friction())
}

impl<T: Real, const D: usize, L: Laws> Pair<T, D, L> {
    /// No contact yet.
    pub(crate) const fn none() -> Self {
        Self {
            part: Part::Nothing,
            x: zeros(),
            w: zeros(),
            normal: T::ZERO,
            rows: L::Room::EMPTY,
        }
    }

    /// Number of unknowns.
    pub(crate) fn count(&self) -> usize {
        self.rows
            .get()
            .map_or(self.part.count::<D>(), |rows| rows.count)
    }

    /// The CHKS-smoothed pair (Chen, Harker, Kanzow, Smale) with the same `gain w - x / (gain alpha)` as an impulse and a
    /// velocity.
    pub(crate) fn centred(
        law: &ContactLaw<T, D, L>,
        r: &SVector<T, D>,
        u: &SVector<T, D>,
        tau: T,
        gain: T,
        beta: T,
    ) -> Self {
        if let Some(laws) = law.rows.get() {
            let mut pair = Self::none();
            pair.x = *r;
            pair.rows = L::Room::with(RowPairs::centred(
                (laws, law.alpha),
                &mut pair.x,
                u,
                tau,
                gain,
            ));
            return pair;
        }
        let part = Part::of(law);
        let mass = gain * law.alpha;
        let z = match part {
            Part::Nothing => return Self::none(),
            Part::Normal => joined(first(u) * gain - first(r) / mass, zeros()),
            _ => widen(law, u) * gain - narrow(law, r) / mass,
        };
        let square = tau / law.alpha;
        let [two, four] = [2.0, 4.0].map(T::literal);
        // (l + sqrt(l² + 4 square)) / 2, without cancellation
        let smooth = |l: T| {
            let root = (l * l + four * square).square_root();
            if l > T::ZERO {
                (l + root) / two
            } else {
                two * square / (root - l)
            }
        };
        let (normal, tangent) = split(&z);
        let length = norm(tangent);
        let direction = if length > T::ZERO { z / length } else { z };
        let vector = |low: T, high: T| joined((low + high) / two, direction * ((high - low) / two));
        let w = vector(smooth(normal - length), smooth(normal + length));
        let x = vector(smooth(length - normal), smooth(-normal - length)) * mass;
        Self {
            part,
            x,
            w: w * (beta / gain),
            normal: tau / first(&x),
            rows: L::Room::EMPTY,
        }
    }

    /// The products that are to become `tau`.
    pub(crate) fn products(&self, beta: T) -> [Option<T>; 2] {
        let normal = first(&self.x) * self.normal;
        let cone = self.x.dot(&self.w) / beta;
        match self.part {
            Part::Nothing => [None; 2],
            Part::Normal => [Some(normal), None],
            Part::Cone => [Some(cone), None],
            Part::Coulomb => [Some(normal), Some(cone)],
        }
    }

    /// The greatest length up to a limit with which it may move.
    pub(crate) fn reach(&self, step: &Self, mut limit: T) -> T {
        if let (Some(rows), Some(step)) = (self.rows.get(), step.rows.get()) {
            return rows.reach(step, limit);
        }
        if self.part.is_cone::<D>() {
            limit = reach(&self.x, &step.x, limit);
            limit = reach(&self.w, &step.w, limit);
        } else if first(&step.x) < T::ZERO {
            limit = limit.min(-first(&self.x) / first(&step.x));
        }
        if step.normal < T::ZERO {
            limit = limit.min(-self.normal / step.normal);
        }
        limit
    }

    /// Moves it.
    pub(crate) fn go(&mut self, step: &Self, length: T) {
        self.x += step.x * length;
        self.w += step.w * length;
        self.normal += step.normal * length;
        if let (Some(rows), Some(step)) = (self.rows.get_mut(), step.rows.get()) {
            rows.go(step, length);
        }
        if self.part.is_cone::<D>() {
            keep_inside(&mut self.x);
            keep_inside(&mut self.w);
        }
    }
}

/// The Nesterov-Todd scaling of a pair: the `V = sqrt(stretch)⁻¹ V(ω)` with `V w = V⁻¹ x`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scaling<T, const D: usize> {
    /// `ω`, of determinant 1.
    omega: SVector<T, D>,
    /// `sqrt(det w / det x)`
    stretch: T,
}

impl<T: Real, const D: usize> Scaling<T, D> {
    pub(crate) const fn none() -> Self {
        Self {
            omega: zeros(),
            stretch: T::ZERO,
        }
    }

    pub(crate) fn of<L: Laws>(pair: &Pair<T, D, L>) -> Self {
        let (of_x, of_w) = (size(&pair.x), size(&pair.w));
        let (x, w) = (pair.x / of_x, pair.w / of_w);
        let mirrored = joined(first(&w), -w);
        let half = (T::ONE + x.dot(&w)) * T::literal(0.5);
        Self {
            omega: (x + mirrored) / (half.square_root() * T::literal(2.0)),
            stretch: of_w / of_x,
        }
    }

    /// `V(ω) a`, or `V(ω)⁻¹ a` with the sign -1.
    fn turn(&self, a: &SVector<T, D>, sign: T) -> SVector<T, D> {
        let (normal, shared) = (first(&self.omega), across(&self.omega, a));
        let tilt = sign * first(a) + shared / (T::ONE + normal);
        joined(normal * first(a) + sign * shared, a + self.omega * tilt)
    }

    /// `V⁻² a = stretch Q(Jω) a`
    pub(crate) fn compliance(&self, a: &SVector<T, D>) -> SVector<T, D> {
        let (normal, shared) = (first(&self.omega), across(&self.omega, a));
        let twice = (normal * first(a) - shared) * T::literal(2.0);
        let rest = joined(normal * twice - first(a), a - self.omega * twice);
        rest * self.stretch
    }

    /// Row `k` of `V⁻²`; in a separate normal row `y_N / x_N`.
    pub(crate) fn row<L: Laws>(&self, pair: &Pair<T, D, L>, k: usize) -> SVector<T, D> {
        let mut unit: SVector<T, D> = zeros();
        if let Some(rows) = pair.rows.get() {
            if let Some(entry) = unit.as_mut_slice().get_mut(k) {
                *entry = rows.answer(k);
            }
            return unit;
        }
        if k == 0 && pair.part != Part::Cone {
            return joined(pair.normal / first(&pair.x), unit);
        }
        if let Some(entry) = unit.as_mut_slice().get_mut(k) {
            *entry = T::ONE;
        }
        self.compliance(&unit) // symmetric
    }

    /// Right-hand side of the linearised equation
    /// `λ ∘ (V dw + V⁻¹ dx) = goal e - λ ∘ λ - V⁻¹ dx ∘ V dw` with `λ = V w = V⁻¹ x`, solved for `dw + V⁻² dx`:
    /// `V⁻¹ (λ \ (goal e - λ ∘ λ - V⁻¹ dx ∘ V dw))`.
    pub(crate) fn corrected<L: Laws>(
        &self,
        pair: &Pair<T, D, L>,
        step: &Pair<T, D, L>,
        goal: T,
    ) -> SVector<T, D> {
        let inverse = |a: &SVector<T, D>| self.turn(a, -T::ONE);
        let (of_x, of_w) = (inverse(&pair.x), self.turn(&pair.w, T::ONE));
        let second = jordan(&inverse(&step.x), &self.turn(&step.w, T::ONE));
        let mut left = -jordan(&of_x, &of_w) - second;
        add_to_normal(&mut left, goal);
        inverse(&divide(&of_x, &left))
    }
}
