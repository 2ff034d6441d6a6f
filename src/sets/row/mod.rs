//! The set of one joint row: the interval of its impulse. The file `pair` has its equations on the central path.

use crate::real::Real;
use crate::scene::JointRow;
use crate::solution::RowMode;

pub(super) mod pair;

/// The interval of one joint row, with its effective mass and its velocity without impulses.
///
/// A limit has the bounds `0` and infinity, an equality has infinite bounds. A row that nothing moves has the impulse nearest to 0,
/// which is both of its bounds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowSet<T> {
    /// The least and the largest impulse.
    pub(crate) bounds: [T; 2],
    /// Effective mass `alpha_j = 1 / W_jj`, the step of the natural map; 0 if nothing moves the row.
    pub(crate) alpha: T,
    /// `q_j = row · v_free + offset`.
    pub(crate) q: T,
    /// The constant term of its velocity, as in [`super::ContactSet`].
    pub(crate) base: T,
    /// Does nothing move the row, although its law is violated?
    pub(crate) is_immovable_and_violated: bool,
}

impl<T: Real> RowSet<T> {
    /// The set of an unused row.
    pub(super) const fn none() -> Self {
        Self {
            bounds: [T::ZERO; 2],
            alpha: T::ZERO,
            q: T::ZERO,
            base: T::ZERO,
            is_immovable_and_violated: false,
        }
    }

    /// The set of a joint row with the effective mass `alpha_j` and the velocity `q_j` without impulses.
    pub(crate) fn new<const N: usize>(row: &JointRow<T, N>, alpha: T, q: T) -> Self {
        let [lower, upper] = row.law.bounds();
        let mut set = Self { bounds: [lower, upper], alpha, q, base: q, is_immovable_and_violated: false };
        if alpha <= T::ZERO {
            set.is_immovable_and_violated =
                q > T::ZERO && !lower.is_finite() || q < T::ZERO && !upper.is_finite();
            set.bounds = [set.project(T::ZERO); 2];
        }
        set
    }

    /// The set of a movable row with these bounds.
    #[cfg(test)]
    pub(crate) fn of(bounds: [T; 2], alpha: T) -> Self {
        Self { bounds, alpha, ..Self::none() }
    }

    /// The nearest impulse within the bounds. NaN stays NaN.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn project(&self, r: T) -> T {
        let [lower, upper] = self.bounds;
        if r < lower {
            lower
        } else if r > upper {
            upper
        } else {
            r
        }
    }

    /// Does the impulse `r` lie between the bounds, so that the row holds (has no velocity)?
    pub(crate) fn holds(&self, r: T) -> bool {
        let [lower, upper] = self.bounds;
        lower < r && r < upper
    }

    /// Is there more than one possible impulse?
    pub(crate) fn is_free(&self) -> bool {
        let [lower, upper] = self.bounds;
        lower < upper
    }

    /// `λ0² / alpha`, twice the energy of the impulse `λ0` of the row if it were alone; 0 for an open stop. `λ0` is multiplied by
    /// `unit`.
    pub(crate) fn alone_energy(&self, unit: T) -> T {
        if self.alpha <= T::ZERO {
            return T::ZERO;
        }
        let alone = self.alone() * unit;
        alone * alone / self.alpha
    }

    /// `λ0`, the impulse of the row if it were alone.
    pub(crate) fn alone(&self) -> T {
        self.project(-self.q * self.alpha)
    }

    /// Part of the row in the duality gap: `r u` minus the least `λ u` of all impulses `λ` within the bounds.
    pub(crate) fn duality_gap(&self, r: T, u: T) -> T {
        let [lower, upper] = self.bounds;
        if u == T::ZERO { T::ZERO } else { u * (r - if u > T::ZERO { lower } else { upper }) }
    }

    /// Residual of the natural map of the row. Where the projection returns its argument, it is `alpha u`, without the rounding of `r`.
    pub(crate) fn residual(&self, r: T, u: T) -> RowResidual<T> {
        let change = u * self.alpha;
        let argument = r - change;
        let nearest = self.project(argument);
        if nearest == argument {
            return RowResidual { value: change, excess: T::ZERO };
        }
        RowResidual { value: r - nearest, excess: (argument - nearest) / self.alpha }
    }

    /// The mode of the row, from the argument of the natural map as for contacts.
    pub(crate) fn mode<const N: usize>(&self, row: &JointRow<T, N>, r: T, u: T) -> RowMode {
        if self.alpha > T::ZERO {
            RowMode::of(r, r - u * self.alpha, self.bounds)
        } else {
            RowMode::of(r, r, row.law.bounds())
        }
    }

    /// One step of a Gauss-Seidel sweep: the impulse within the bounds that stops the row while the others are held.
    pub(crate) fn solve_local(&self, r: T, u: T) -> T {
        self.project(r - self.alpha * u)
    }
}

/// Residual of the natural map of a joint row.
pub(crate) struct RowResidual<T> {
    /// `r - Π(r - alpha u)`, in the unit of `r`.
    pub(crate) value: T,
    /// Distance of the argument `r - alpha u` beyond the bound, as a velocity.
    pub(crate) excess: T,
}
