//! Joint rows on the central path: the distances of their impulses to each bound, and what pushes back there.
//!
//! A row with the bounds `l` and `u` has `s = p - n`, `(λ - l) p = tau` and `(u - λ) n = tau`; where a bound is infinite its
//! part is left out, so that a limit has one product and an equality none.

use crate::Real;
use crate::problem::row_laws::RowLaws;
use crate::solution::zeros;
use nalgebra::SVector;

/// A slot of joint rows on the central path, or how it moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowPairs<T, const D: usize> {
    pub(super) count: usize,
    /// `W_jj`
    rigid: T,
    /// `λ - l` and `u - λ`
    gaps: [[T; 2]; D],
    /// `p` and `n`
    holds: [[T; 2]; D],
}

/// Products of a row that are to vanish: there is none at a bound that is not there, or where the bounds coincide.
fn exists<T: Real>(gaps: &[T; 2], side: usize) -> bool {
    let is_fixed = gaps.iter().all(|&gap| gap == T::ZERO);
    !is_fixed && gaps.get(side).is_some_and(T::is_finite)
}

impl<T: Real, const D: usize> RowPairs<T, D> {
    /// The rows near these impulses, which it moves into the interior, and velocities.
    pub(super) fn centred(
        (laws, alpha): (&RowLaws<T, D>, T),
        r: &mut SVector<T, D>,
        u: &SVector<T, D>,
        tau: T,
        gain: T,
    ) -> Self {
        let mut pairs = Self {
            count: laws.count(),
            rigid: T::ONE / alpha,
            gaps: [[T::ZERO; 2]; D],
            holds: [[T::ZERO; 2]; D],
        };
        let half = T::literal(0.5);
        let rows = r.iter_mut().zip(u.iter()).zip(&laws.bounds);
        let places = pairs.gaps.iter_mut().zip(&mut pairs.holds);
        for (((r, &u), &[lower, upper]), (gaps, holds)) in rows.zip(places) {
            // With the smoothing of Chen, Harker, Kanzow and Smale, of one bound; from two it stays away.
            let push = |z: T| {
                let square = tau / alpha;
                let root = (z * z + T::literal(4.0) * square).square_root();
                if z < T::ZERO {
                    (root - z) * half
                } else {
                    square / ((root + z) * half)
                }
            };
            if lower.is_finite() && !upper.is_finite() {
                let mass = gain * alpha;
                *r = lower + push(u * gain - (*r - lower) / mass) * mass;
            } else if lower < upper && upper.is_finite() {
                let margin = ((upper - lower) * T::literal(0.1)).min((tau * alpha).square_root());
                *r = (*r).max(lower + margin).min(upper - margin);
            }
            *gaps = [*r - lower, upper - *r];
            for (side, hold) in holds.iter_mut().enumerate() {
                if exists(gaps, side) {
                    *hold = gaps.get(side).map_or(T::ZERO, |&gap| tau / gap);
                }
            }
        }
        pairs
    }

    /// Its products that are to vanish.
    pub(super) fn products(&self) -> impl Iterator<Item = T> {
        let rows = self.gaps.iter().zip(&self.holds).take(self.count);
        rows.flat_map(|(gaps, holds)| {
            let sides = gaps.iter().zip(holds).enumerate();
            let there = sides.filter(|&(side, _)| exists(gaps, side));
            there.map(|(_, (&gap, &hold))| gap * hold)
        })
    }

    /// `p - n`, what velocities are to be.
    pub(super) fn velocity(&self) -> SVector<T, D> {
        let mut velocity: SVector<T, D> = zeros();
        for (velocity, [p, n]) in velocity.iter_mut().zip(self.holds) {
            *velocity = p - n;
        }
        velocity
    }

    /// How row `k` answers to an impulse while its products stay. A row that nothing bounds is regularised, one that cannot
    /// move is as good as rigid.
    pub(super) fn answer(&self, k: usize) -> T {
        let Some((gaps, holds)) = self.gaps.get(k).zip(self.holds.get(k)) else {
            return T::ZERO;
        };
        if gaps.iter().all(|&gap| gap == T::ZERO) {
            return self.rigid / (T::EPSILON * T::EPSILON);
        }
        let sides = gaps.iter().zip(holds).enumerate();
        sides.fold(
            self.rigid * T::EPSILON * T::literal(64.0),
            |sum, (side, (&gap, &hold))| {
                if exists(gaps, side) {
                    sum + hold / gap
                } else {
                    sum
                }
            },
        )
    }

    /// What `p` and `n` have to change by, but for what impulses change, so that products become `tau` with those of another
    /// step taken into account.
    pub(super) fn corrected(&self, step: Option<&Self>, tau: T) -> [[T; 2]; D] {
        let mut goals = [[T::ZERO; 2]; D];
        for (k, goals) in goals.iter_mut().enumerate().take(self.count) {
            let own = self.gaps.get(k).zip(self.holds.get(k));
            let Some((gaps, holds)) = own else { break };
            let other = step.and_then(|step| step.gaps.get(k).zip(step.holds.get(k)));
            for (side, goal) in goals.iter_mut().enumerate() {
                if let (true, Some((&gap, &hold))) =
                    (exists(gaps, side), gaps.get(side).zip(holds.get(side)))
                {
                    let second =
                        other.and_then(|(gaps, holds)| gaps.get(side).zip(holds.get(side)));
                    let second = second.map_or(T::ZERO, |(&gap, &hold)| gap * hold);
                    *goal = (tau - second) / gap - hold;
                }
            }
        }
        goals
    }

    /// The step with these changes of impulses, and of `p` and `n` without them.
    pub(super) fn step(&self, moved: &SVector<T, D>, goals: &[[T; 2]; D]) -> Self {
        let mut step = *self;
        let rows = step.gaps.iter_mut().zip(&mut step.holds);
        for (((gaps, holds), &moved), goals) in rows.zip(moved.iter()).zip(goals) {
            let old = *gaps;
            *gaps = [moved, -moved];
            for (side, ((hold, &goal), &moved)) in
                holds.iter_mut().zip(goals).zip(&*gaps).enumerate()
            {
                let gap = old.get(side).copied().unwrap_or(T::ONE);
                *hold = if exists(&old, side) {
                    goal - *hold / gap * moved
                } else {
                    T::ZERO
                };
            }
        }
        step
    }

    /// The greatest length up to a limit with which it may move.
    pub(super) fn reach(&self, step: &Self, limit: T) -> T {
        let mut reach = limit;
        let own = self.gaps.iter().zip(&self.holds).take(self.count);
        for ((gaps, holds), (gap_steps, hold_steps)) in own.zip(step.gaps.iter().zip(&step.holds)) {
            let sides = gaps
                .iter()
                .zip(holds)
                .zip(gap_steps.iter().zip(hold_steps))
                .enumerate();
            for (_, ((&gap, &hold), (&gap_step, &hold_step))) in
                sides.filter(|&(side, _)| exists(gaps, side))
            {
                for (value, step) in [(gap, gap_step), (hold, hold_step)] {
                    if step < T::ZERO {
                        reach = reach.min(-value / step);
                    }
                }
            }
        }
        reach
    }

    /// Moves it.
    pub(super) fn go(&mut self, step: &Self, length: T) {
        let pairs = self.gaps.iter_mut().chain(&mut self.holds);
        for (pair, step) in pairs.zip(step.gaps.iter().chain(&step.holds)) {
            for (value, &step) in pair.iter_mut().zip(step) {
                *value += step * length;
            }
        }
    }
}

#[cfg(test)]
mod tests;
