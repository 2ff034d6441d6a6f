//! A joint row on the central path: the distances of its impulse to each bound, and what pushes back there.
//!
//! A row with the bounds `l` and `u` has `s = p - n`, `(λ - l) p = tau` and `(u - λ) n = tau`; where a bound is infinite its
//! part is left out, so that a limit has one product and an equality none. Where the bounds coincide nothing is unknown.

use crate::real::Real;
use crate::sets::RowSet;
use crate::sets::contact::pair::smoothed;

/// A joint row on the central path, or how it moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowPair<T> {
    /// `λ`
    pub(crate) impulse: T,
    /// `λ - l` and `u - λ`
    gaps: [T; 2],
    /// `p` and `n`
    duals: [T; 2],
    /// Is there a bound on this side, which is not the other one as well?
    is_bounded: [bool; 2],
    /// Is the impulse an unknown?
    pub(crate) is_free: bool,
}

impl<T: Real> RowPair<T> {
    /// A place that is not used.
    pub(crate) const fn none() -> Self {
        Self {
            impulse: T::ZERO,
            gaps: [T::ZERO; 2],
            duals: [T::ZERO; 2],
            is_bounded: [false; 2],
            is_free: false,
        }
    }

    /// The pair near an impulse, which it moves into the interior, and a velocity: with the smoothing of Chen, Harker, Kanzow
    /// and Smale at one bound; from two it stays away.
    pub(crate) fn centred(set: &RowSet<T>, r: T, u: T, tau: T, gain: T) -> Self {
        let ([lower, upper], alpha) = (set.bounds, set.alpha);
        let mut pair = Self {
            impulse: r,
            is_free: set.is_free(),
            ..Self::none()
        };
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

    /// Gap, dual and whether there is a bound, of each side.
    fn sides(&self) -> impl Iterator<Item = (T, T, bool)> {
        let pairs = self.gaps.into_iter().zip(self.duals);
        pairs
            .zip(self.is_bounded)
            .map(|((gap, dual), bound)| (gap, dual, bound))
    }

    /// Its products that are to become `tau`.
    pub(crate) fn products(&self) -> [Option<T>; 2] {
        let mut sides = self.sides();
        [(); 2].map(|()| {
            let (gap, dual, is_bounded) = sides.next()?;
            is_bounded.then_some(gap * dual)
        })
    }

    /// `p - n`, what its velocity is to be.
    pub(crate) fn velocity(&self) -> T {
        let [p, n] = self.duals;
        p - n
    }

    /// How its velocity answers to an impulse while its products stay. A row that nothing bounds is regularised.
    pub(crate) fn response(&self, alpha: T) -> T {
        let regularisation = T::EPSILON * T::literal(64.0) / alpha;
        let bounded = self.sides().filter(|&(_, _, is_bounded)| is_bounded);
        bounded.fold(regularisation, |sum, (gap, dual, _)| sum + dual / gap)
    }

    /// What `p` and `n` have to change by, but for what the impulse changes, so that products become `tau` with those of another
    /// step taken into account.
    pub(crate) fn goals(&self, step: Option<&Self>, tau: T) -> [T; 2] {
        let mut goals = [T::ZERO; 2];
        let second = |side: usize| {
            let other = step.and_then(|step| step.gaps.get(side).zip(step.duals.get(side)));
            other.map_or(T::ZERO, |(&gap, &dual)| gap * dual)
        };
        for ((side, goal), (gap, dual, is_bounded)) in
            goals.iter_mut().enumerate().zip(self.sides())
        {
            if is_bounded {
                *goal = (tau - second(side)) / gap - dual;
            }
        }
        goals
    }

    /// The step with this change of the impulse, and of `p` and `n` without it.
    pub(crate) fn step(&self, moved: T, goals: &[T; 2]) -> Self {
        let mut step = Self {
            impulse: moved,
            gaps: [moved, -moved],
            ..*self
        };
        let changes = step.duals.iter_mut().zip(goals).zip(step.gaps);
        for (((dual, &goal), change), (gap, own, is_bounded)) in changes.zip(self.sides()) {
            *dual = if is_bounded {
                goal - own / gap * change
            } else {
                T::ZERO
            };
        }
        step
    }

    /// The greatest length up to a limit with which it may move.
    pub(crate) fn max_step(&self, step: &Self, mut limit: T) -> T {
        for ((gap, dual, is_bounded), (gap_step, dual_step, _)) in self.sides().zip(step.sides()) {
            for (value, step) in [(gap, gap_step), (dual, dual_step)] {
                if is_bounded && step < T::ZERO {
                    limit = limit.min(-value / step);
                }
            }
        }
        limit
    }

    /// Moves it.
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
