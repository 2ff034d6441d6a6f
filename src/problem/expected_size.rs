//! The size of impulses that is expected, `|r0|` or the larger of `|r0|` and `|stop|` ([`crate::guide::error`]), and what is far above it.

use crate::linalg::stacked::Stacked;
use crate::problem::Problem;
use crate::real::Real;
use crate::sets::contact::expected;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Problem<'_, T, N, D, C, R, S>
{
    /// Computes `|stop|`, and includes it in the expected impulse.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn count_stopping(&mut self) {
        let mut free = [T::ZERO; N];
        self.factor.velocity(&self.whitened, &Stacked::zero(), &mut free);
        let stopping = self.scene.stopping_impulse(self.sets.contacts(), &free);
        self.expected_size = self.r0_norm.max(stopping);
        self.counts_stopping = true;
    }

    /// Is an impulse needed that is so close to the least normal number that it loses digits or vanishes?
    pub(super) fn loses_digits(&self) -> bool {
        self.expected_size * T::EPSILON < T::least_normal() && self.needs_impulses()
    }

    /// Does the free motion violate the law of any contact?
    #[cfg_attr(target_os = "none", inline(never))]
    fn needs_impulses(&self) -> bool {
        let mut contacts = self.sets.contacts().iter();
        contacts.any(|set| set.is_violated(&set.q))
    }

    /// May this error come within the tolerance once `|stop|` counts in its denominator? `|stop|` costs as much as a sweep, so it is
    /// computed late. Without it an error is too large, unless there is [an unexpected impulse](Self::has_unexpected_impulse).
    ///
    /// The estimate of `|stop|` uses `|H_i v|² <= trace(W_ii) v·M v` of the free motion. `stop` has `abs(H_i) abs(v)` instead,
    /// which may be larger; a factor of 4 allows for it. If that is too little, `|stop|` counts only at the end of the call.
    pub(crate) fn may_be_within(&self, error: T, tolerance: T) -> bool {
        let four = T::literal(4.0 * expected::SHARE);
        let residual = error * self.expected_size;
        !self.counts_stopping
            && residual * residual <= self.stopping_bound * (four * tolerance) * (four * tolerance)
    }

    /// Is there an impulse although `|r0|` is 0 and `|stop|` does not count yet? Its error would be relative to itself alone.
    pub(crate) fn has_unexpected_impulse(&self, r: &Stacked<T, D, C, R>) -> bool {
        self.r0_norm == T::ZERO && !self.counts_stopping && !self.sets.are_least(r)
    }

    /// Are impulses more than `times` times as large as expected?
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn exceeds(&self, r: &Stacked<T, D, C, R>, times: T) -> bool {
        if self.scene.is_mixed() {
            return self.energy.ratio(&self.sets, r) > times;
        }
        let bound = self.expected_size * times;
        self.sets.contact_square(r) > bound * bound
    }

    /// Are impulses more than `times` times as large as others?
    pub(crate) fn exceeds_others(
        &self,
        r: &Stacked<T, D, C, R>,
        others: &Stacked<T, D, C, R>,
        times: T,
    ) -> bool {
        if self.scene.is_mixed() {
            return self.energy.ratio(&self.sets, r) > times * self.energy.ratio(&self.sets, others);
        }
        self.sets.contact_square(r) > times * times * self.sets.contact_square(others)
    }
}
