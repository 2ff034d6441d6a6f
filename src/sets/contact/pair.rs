//! One contact on the central path ([`crate::guide::method`]): its impulse, its velocity and their scaling.
//!
//! With `Λ = diag(1, mu, ..., mu)`, `r = Λ x` and `y = Λ u` the friction cone is the Lorentz cone `x_N >= |x_T|`. `∘` and `det` are
//! those of [`super::lorentz`], `J = diag(1, -1, ..., -1)`, and `Q(a) b = 2 a (a·b) - det(a) J b`.

use crate::cone::{add_to_normal, split};
use crate::linalg::vector::{norm, zeros};
use crate::real::Real;
use crate::sets::ContactSet;
use crate::sets::contact::lorentz::{
    divide, first, joined, jordan, keep_inside, max_step, size, tangential_product,
};
use nalgebra::SVector;

/// The rows of a contact that have an equation on the central path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// No row: nothing moves the contact.
    Nothing,
    /// The normal row: the contact has no friction.
    Normal,
    /// All rows, with an equation for the normal row and one for the cone: Coulomb's law.
    Coulomb,
    /// All rows, with one equation for the cone: the convex relaxation.
    Cone,
}

impl Part {
    /// The part of a contact.
    pub(crate) fn of<T: Real, const D: usize>(set: &ContactSet<T, D>) -> Self {
        if set.alpha <= T::ZERO {
            Self::Nothing
        } else if set.pushing_rows() == 1 {
            Self::Normal
        } else if set.shift_factor > T::ZERO {
            Self::Coulomb
        } else {
            Self::Cone
        }
    }

    /// Is there an equation for the cone?
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

/// A contact on the central path, or a step of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair<T: Real, const D: usize> {
    pub(crate) part: Part,
    /// `x = Λ⁻¹ r`
    pub(crate) x: SVector<T, D>,
    /// `(s, y_T)`: an extra unknown `s >= |y_T|`, and the tangential velocity. In the convex relaxation `s` is `y_N`.
    pub(crate) dual: SVector<T, D>,
    /// `y_N`; unused in the convex relaxation, where `dual[0]` is `y_N`.
    pub(crate) normal: T,
}

/// `Λ v`
pub(crate) fn widen<T: Real, const D: usize>(set: &ContactSet<T, D>, v: &SVector<T, D>) -> SVector<T, D> {
    let mut wide = *v;
    for wide in wide.iter_mut().skip(1) {
        *wide *= set.cone.friction();
    }
    wide
}

/// `Λ_kk`
pub(crate) fn width<T: Real, const D: usize>(set: &ContactSet<T, D>, k: usize) -> T {
    if k == 0 { T::ONE } else { set.cone.friction() }
}

/// `Λ⁻¹ v`
fn narrow<T: Real, const D: usize>(set: &ContactSet<T, D>, v: &SVector<T, D>) -> SVector<T, D> {
    joined(first(v), v / set.cone.friction())
}

impl<T: Real, const D: usize> Pair<T, D> {
    /// The pair of an unused contact.
    pub(crate) const fn none() -> Self {
        Self { part: Part::Nothing, x: zeros(), dual: zeros(), normal: T::ZERO }
    }

    /// Number of unknowns.
    pub(crate) fn count(&self) -> usize {
        self.part.count::<D>()
    }

    /// The pair with the parameter `tau` near the impulse `r` and the augmented velocity `u`, smoothed after Chen, Harker, Kanzow
    /// and Smale. With `w = (s, y_T)`, `gain w / beta - x / (gain alpha) = gain Λ u - Λ⁻¹ r / (gain alpha)`.
    pub(crate) fn centred(
        set: &ContactSet<T, D>,
        r: &SVector<T, D>,
        u: &SVector<T, D>,
        tau: T,
        gain: T,
        beta: T,
    ) -> Self {
        let part = Part::of(set);
        let mass = gain * set.alpha;
        let z = match part {
            Part::Nothing => return Self::none(),
            Part::Normal => joined(first(u) * gain - first(r) / mass, zeros()),
            _ => widen(set, u) * gain - narrow(set, r) / mass,
        };
        let (two, square) = (T::literal(2.0), tau / set.alpha);
        let smooth = |l: T| smoothed(l, square);
        let (normal, tangent) = split(&z);
        let length = norm(tangent);
        let direction = if length > T::ZERO { z / length } else { z };
        let vector = |low: T, high: T| joined((low + high) / two, direction * ((high - low) / two));
        let dual = vector(smooth(normal - length), smooth(normal + length));
        let x = vector(smooth(length - normal), smooth(-normal - length)) * mass;
        Self { part, x, dual: dual * (beta / gain), normal: tau / first(&x) }
    }

    /// The products `y_N x_N` and `x · (s, y_T) / beta`, which are `tau` on the central path; `None` for an equation that is missing.
    pub(crate) fn products(&self, beta: T) -> [Option<T>; 2] {
        let normal = first(&self.x) * self.normal;
        let cone = self.x.dot(&self.dual) / beta;
        match self.part {
            Part::Nothing => [None; 2],
            Part::Normal => [Some(normal), None],
            Part::Cone => [Some(cone), None],
            Part::Coulomb => [Some(normal), Some(cone)],
        }
    }

    /// The greatest length of a step, up to `limit`, that stays inside the cones.
    pub(crate) fn max_step(&self, step: &Self, mut limit: T) -> T {
        if self.part.is_cone::<D>() {
            limit = max_step(&self.x, &step.x, limit);
            limit = max_step(&self.dual, &step.dual, limit);
        } else if first(&step.x) < T::ZERO {
            limit = limit.min(-first(&self.x) / first(&step.x));
        }
        if step.normal < T::ZERO {
            limit = limit.min(-self.normal / step.normal);
        }
        limit
    }

    /// Moves the pair by `step length`.
    pub(crate) fn advance(&mut self, step: &Self, length: T) {
        self.x += step.x * length;
        self.dual += step.dual * length;
        self.normal += step.normal * length;
        if self.part.is_cone::<D>() {
            keep_inside(&mut self.x);
            keep_inside(&mut self.dual);
        }
    }
}

/// The positive root of `x (x - l) = square`, computed without cancellation.
pub(in crate::sets) fn smoothed<T: Real>(l: T, square: T) -> T {
    let [two, four] = [2.0, 4.0].map(T::literal);
    let root = (l * l + four * square).square_root();
    if l > T::ZERO { (l + root) / two } else { two * square / (root - l) }
}

/// The scaling `V` of a pair after Nesterov and Todd: `V w = V⁻¹ x`, where `w` is the pair's `dual`. `V = V(ω) / sqrt(stretch)`,
/// and `V(ω)` is the symmetric matrix with `V(ω)² = Q(ω)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scaling<T, const D: usize> {
    /// `ω`, of determinant 1.
    omega: SVector<T, D>,
    /// `sqrt(det w / det x)`
    stretch: T,
}

impl<T: Real, const D: usize> Scaling<T, D> {
    /// The scaling of a contact that has none.
    pub(crate) const fn none() -> Self {
        Self { omega: zeros(), stretch: T::ZERO }
    }

    /// The scaling of a pair.
    pub(crate) fn of(pair: &Pair<T, D>) -> Self {
        let (of_x, of_w) = (size(&pair.x), size(&pair.dual));
        let (x, w) = (pair.x * (T::ONE / of_x), pair.dual * (T::ONE / of_w));
        let mirrored = joined(first(&w), -w);
        let half = (T::ONE + x.dot(&w)) * T::literal(0.5);
        Self { omega: (x + mirrored) * (T::literal(0.5) / half.square_root()), stretch: of_w / of_x }
    }

    /// `V(ω) a`, or with the sign -1 `V(ω)⁻¹ a`.
    fn turn(&self, a: &SVector<T, D>, sign: T) -> SVector<T, D> {
        let (normal, product) = (first(&self.omega), tangential_product(&self.omega, a));
        let tilt = sign * first(a) + product / (T::ONE + normal);
        joined(normal * first(a) + sign * product, a + self.omega * tilt)
    }

    /// `V⁻² a = stretch Q(Jω) a`
    pub(crate) fn inverse_square(&self, a: &SVector<T, D>) -> SVector<T, D> {
        let (normal, product) = (first(&self.omega), tangential_product(&self.omega, a));
        let twice = (normal * first(a) - product) * T::literal(2.0);
        joined(normal * twice - first(a), a - self.omega * twice) * self.stretch
    }

    /// Column `k` of `V⁻²`. A normal row with an equation of its own has `y_N / x_N` on the diagonal and zeros beside it.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn column(&self, pair: &Pair<T, D>, k: usize) -> SVector<T, D> {
        let mut unit: SVector<T, D> = zeros();
        if let Some(entry) = unit.as_mut_slice().get_mut(k) {
            *entry = T::ONE;
        }
        let column = if D > 1 && pair.part.is_cone::<D>() { self.inverse_square(&unit) } else { zeros() };
        if pair.part == Part::Cone {
            return column;
        }
        joined(if k == 0 { pair.normal / first(&pair.x) } else { T::ZERO }, column)
    }

    /// `dw + V⁻² dx` of the corrector: `V⁻¹ (σ \ (goal e - σ ∘ σ - V⁻¹ dx ∘ V dw))` with `σ = V w = V⁻¹ x`. It solves the
    /// linearised equation `σ ∘ (V dw + V⁻¹ dx) = goal e - σ ∘ σ - V⁻¹ dx ∘ V dw`, with `dx` and `dw` of the predictor `step` on
    /// the right; `σ \ a` is the `b` of `σ ∘ b = a`. The code uses `V(ω)` for `V`: the factors `sqrt(stretch)` cancel.
    pub(crate) fn corrected(&self, pair: &Pair<T, D>, step: &Pair<T, D>, goal: T) -> SVector<T, D> {
        let inverse = |a: &SVector<T, D>| self.turn(a, -T::ONE);
        let (of_x, of_w) = (inverse(&pair.x), self.turn(&pair.dual, T::ONE));
        let second_order = jordan(&inverse(&step.x), &self.turn(&step.dual, T::ONE));
        let mut residual = -jordan(&of_x, &of_w) - second_order;
        add_to_normal(&mut residual, goal);
        inverse(&divide(&of_x, &residual))
    }
}
