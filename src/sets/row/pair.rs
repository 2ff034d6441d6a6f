//! A joint row on the central path: the distances of its impulse `λ` from its bounds, and the dual unknowns `p` and `n` of the bounds.
//!
//! A row with the bounds `lower` and `upper` has the velocity `s = p - n`, with `(λ - lower) p = tau` and `(upper - λ) n = tau`.
//! An infinite bound has no such equation: a limit has one, an equality none. Where the bounds coincide, the impulse is no
//! unknown.

use crate::linalg::zip::{zip3, zip4};
use crate::real::Real;
use crate::sets::RowSet;
use crate::sets::contact::pair::smoothed;

/// A joint row on the central path, or a step of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowPair<T> {
    /// `λ`
    pub(crate) impulse: T,
    /// `λ - lower` and `upper - λ`
    gaps: [T; 2],
    /// `p` and `n`
    duals: [T; 2],
    /// Are `lower` and `upper` finite? Both are false if the impulse is no unknown.
    is_bounded: [bool; 2],
    /// Is the impulse an unknown?
    pub(crate) is_free: bool,
}

/// One bound of a row.
struct Side<T> {
    gap: T,
    dual: T,
    is_bounded: bool,
}

impl<T: Real> RowPair<T> {
    /// The pair of an unused row.
    pub(crate) const fn none() -> Self {
        Self {
            impulse: T::ZERO,
            gaps: [T::ZERO; 2],
            duals: [T::ZERO; 2],
            is_bounded: [false; 2],
            is_free: false,
        }
    }

    /// The pair with the parameter `tau` near the impulse `r` and the velocity `u`. A row with one bound is smoothed after Chen,
    /// Harker, Kanzow and Smale. Between two bounds the impulse is moved away from both.
    pub(crate) fn centred(set: &RowSet<T>, r: T, u: T, tau: T, gain: T) -> Self {
        let ([lower, upper], alpha) = (set.bounds, set.alpha);
        let mut pair = Self { impulse: r, is_free: set.is_free(), ..Self::none() };
        if !pair.is_free {
            return pair;
        }
        pair.is_bounded = [lower.is_finite(), upper.is_finite()];
        if pair.is_bounded == [true, false] {
            let mass = gain * alpha;
            let argument = (r - lower) / mass - u * gain;
            pair.impulse = lower + smoothed(argument, tau / alpha) * mass;
        } else if pair.is_bounded == [true, true] {
            let margin = ((upper - lower) * T::literal(0.1)).min((tau * alpha).square_root());
            pair.impulse = r.max(lower + margin).min(upper - margin);
        }
        pair.gaps = [pair.impulse - lower, upper - pair.impulse];
        for (dual, &gap) in pair.duals.iter_mut().zip(&pair.gaps) {
            *dual = if gap.is_finite() { tau / gap } else { T::ZERO };
        }
        pair
    }

    /// The lower and the upper bound.
    fn sides(&self) -> impl Iterator<Item = Side<T>> {
        let sides = zip3(self.gaps, self.duals, self.is_bounded);
        sides.map(|(gap, dual, is_bounded)| Side { gap, dual, is_bounded })
    }

    /// The products `(λ - lower) p` and `(upper - λ) n`, which are `tau` on the central path; `None` for an infinite bound.
    pub(crate) fn products(&self) -> [Option<T>; 2] {
        let mut sides = self.sides();
        [(); 2].map(|()| {
            let side = sides.next()?;
            side.is_bounded.then_some(side.gap * side.dual)
        })
    }

    /// `p - n`, the velocity `s` on the central path.
    pub(crate) fn velocity(&self) -> T {
        let [p, n] = self.duals;
        p - n
    }

    /// `-ds/dλ` of `s = p - n` at constant products: the entry of the row on the diagonal. `64 eps / alpha` is added, so that a
    /// row without bounds has an entry, too.
    pub(crate) fn response(&self, alpha: T) -> T {
        let regularisation = T::EPSILON * T::literal(64.0) / alpha;
        let bounded = self.sides().filter(|side| side.is_bounded);
        bounded.fold(regularisation, |sum, side| sum + side.dual / side.gap)
    }

    /// Changes of `p` and `n` at constant impulse that make the products `tau`. The second-order terms are those of `step`.
    pub(crate) fn goals(&self, step: Option<&Self>, tau: T) -> [T; 2] {
        let mut goals = [T::ZERO; 2];
        let second = |side: usize| {
            let other = step.and_then(|step| step.gaps.get(side).zip(step.duals.get(side)));
            other.map_or(T::ZERO, |(&gap, &dual)| gap * dual)
        };
        for (k, goal, side) in zip3(0..2, &mut goals, self.sides()) {
            if side.is_bounded {
                *goal = (tau - second(k)) / side.gap - side.dual;
            }
        }
        goals
    }

    /// The step in which the impulse changes by `change`, and `p` and `n` by `goals` and by the effect of that change.
    pub(crate) fn step(&self, change: T, goals: &[T; 2]) -> Self {
        let mut step = Self { impulse: change, gaps: [change, -change], ..*self };
        for (dual, &goal, change, side) in zip4(&mut step.duals, goals, step.gaps, self.sides()) {
            *dual = if side.is_bounded { goal - side.dual / side.gap * change } else { T::ZERO };
        }
        step
    }

    /// The greatest length of a step, up to `limit`, that keeps gaps and duals positive.
    pub(crate) fn max_step(&self, step: &Self, mut limit: T) -> T {
        for (side, change) in self.sides().zip(step.sides()) {
            for (value, step) in [(side.gap, change.gap), (side.dual, change.dual)] {
                if side.is_bounded && step < T::ZERO {
                    limit = limit.min(-value / step);
                }
            }
        }
        limit
    }

    /// Moves the pair by `step length`.
    pub(crate) fn advance(&mut self, step: &Self, length: T) {
        self.impulse += step.impulse * length;
        let values = self.gaps.iter_mut().chain(&mut self.duals);
        for (value, step) in values.zip(step.gaps.iter().chain(&step.duals)) {
            *value += *step * length;
        }
    }
}

#[cfg(test)]
mod tests;
