//! The sum against one in twice the digits.

use super::{Dot2, Sum};
use proptest::collection::vec;
use proptest::prelude::*;

proptest! {
    #[test]
    fn a_sum_in_single_precision_is_rounded_once(
        terms in vec((-1e3_f32..1e3, prop_oneof![-1e3_f32..1e3, -1e-3_f32..1e-3]), 1..40),
        cancels in any::<bool>(),
    ) {
        let mut sum = Dot2::of(0.0_f32);
        let (mut exact, mut sizes, mut count) = (0.0_f64, 0.0_f64, 0.0_f64);
        let back = terms.iter().rev().map(|&(x, y)| (x, -y * 1.000_001)).filter(|_| cancels);
        for (x, y) in terms.iter().copied().chain(back) {
            sum.add(x, y);
            let product = f64::from(x) * f64::from(y);
            (exact, sizes, count) = (exact + product, sizes + product.abs(), count + 1.0);
        }
        let half = f64::from(f32::EPSILON) / 2.0;
        let bound = half * exact.abs() + (count * half).powi(2) * sizes + 1e-15 * sizes;
        prop_assert!((f64::from(sum.value()) - exact).abs() <= bound);
    }
}
