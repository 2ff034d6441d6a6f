//! What a solve asks of a joint row: an interval for its impulse, and in the file beside it the central path.

use crate::real::Real;
use crate::scene::JointRow;
use crate::solution::RowMode;

pub(super) mod pair;

/// One joint row in a solve.
///
/// It is a limit with the bounds `0` and infinity, an equality without bounds. One that nothing moves keeps the impulse
/// nearest to 0, as if both bounds were there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowSet<T> {
    /// The least and the largest impulse.
    pub(crate) bounds: [T; 2],
    /// Step `alpha_j = 1 / W_jj` of the natural map; 0 if nothing moves the row.
    pub(crate) alpha: T,
    /// `q_j = row · v_free + offset`.
    pub(crate) q: T,
    /// The constant term of its velocity, as of [`super::ContactSet`].
    pub(crate) base: T,
    /// Does nothing move it, although it asks for another velocity?
    pub(crate) is_immovable_and_violated: bool,
}

impl<T: Real> RowSet<T> {
    /// A place that is not used.
    pub(super) const fn none() -> Self {
        Self {
            bounds: [T::ZERO; 2],
            alpha: T::ZERO,
            q: T::ZERO,
            base: T::ZERO,
            is_immovable_and_violated: false,
        }
    }

    /// That of a joint row, with the step `alpha_j` and `q_j`.
    pub(crate) fn new<const N: usize>(row: &JointRow<T, N>, alpha: T, q: T) -> Self {
        let [lower, upper] = row.law.bounds();
        let mut set = Self {
            bounds: [lower, upper],
            alpha,
            q,
            base: q,
            is_immovable_and_violated: false,
        };
        if alpha <= T::ZERO {
            set.is_immovable_and_violated =
                q > T::ZERO && !lower.is_finite() || q < T::ZERO && !upper.is_finite();
            set.bounds = [set.project(T::ZERO); 2];
        }
        set
    }

    /// One with these bounds, which something moves.
    #[cfg(test)]
    pub(crate) fn of(bounds: [T; 2], alpha: T) -> Self {
        Self {
            bounds,
            alpha,
            ..Self::none()
        }
    }

    /// The nearest impulse within the bounds, a clamp; what is no number stays so.
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

    /// Is it free to change its impulse, which lies between the bounds?
    pub(crate) fn holds(&self, r: T) -> bool {
        let [lower, upper] = self.bounds;
        lower < r && r < upper
    }

    /// May its impulse be more than one?
    pub(crate) fn is_free(&self) -> bool {
        let [lower, upper] = self.bounds;
        lower < upper
    }

    /// `alpha q²`, with the impulse that it would take alone: open stops do not count.
    pub(crate) fn alone_energy(&self, unit: T) -> T {
        if self.alpha <= T::ZERO {
            return T::ZERO;
        }
        let alone = self.alone() * unit;
        alone * alone / self.alpha
    }

    /// Its impulse if it were alone.
    pub(crate) fn alone(&self) -> T {
        self.project(-self.q * self.alpha)
    }

    /// Its part of the duality gap, `r u` less the least that an impulse within the bounds makes of it.
    pub(crate) fn duality_gap(&self, r: T, u: T) -> T {
        let [lower, upper] = self.bounds;
        if u == T::ZERO {
            T::ZERO
        } else {
            u * (r - if u > T::ZERO { lower } else { upper })
        }
    }

    /// Natural map `r - Π(r - alpha u)`, not rounded as a large impulse would be; and how far the argument lies beyond the
    /// bounds, as a velocity.
    pub(crate) fn natural_map(&self, r: T, u: T) -> (T, T) {
        let answer = u * self.alpha;
        let argument = r - answer;
        let nearest = self.project(argument);
        if nearest == argument {
            return (answer, T::ZERO);
        }
        (r - nearest, (argument - nearest) / self.alpha)
    }

    /// What it does, read off the argument of the natural map as for contacts.
    pub(crate) fn mode<const N: usize>(&self, row: &JointRow<T, N>, r: T, u: T) -> RowMode {
        if self.alpha > T::ZERO {
            RowMode::of(r, r - u * self.alpha, self.bounds)
        } else {
            RowMode::of(r, r, row.law.bounds())
        }
    }

    /// One step of a Gauss-Seidel sweep: the impulse that stops the row while the others are held, within the bounds.
    pub(crate) fn solve_local(&self, r: T, u: T) -> T {
        self.project(r - self.alpha * u)
    }
}
