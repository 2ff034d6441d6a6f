//! Sums of products in twice the digits: they carry their rounding errors along (T. Ogita, S. M. Rump, S. Oishi, *Accurate Sum and
//! Dot Product*, 2005).

use crate::linalg::sum::Sum;
use crate::real::Real;

/// A sum of `n` products. Its error is at most `eps / 2` of its value plus `γ²` of the sum of the magnitudes of its terms, with
/// `γ = (n eps / 2) / (1 - n eps / 2)` (proposition 5.5 of that paper), if nothing overflows and no product is below `1 / eps²`
/// times the least normal number.
#[derive(Clone, Copy)]
pub(crate) struct Dot2<T> {
    sum: T,
    /// Exact sum minus `sum`, to first order.
    error: T,
}

impl<T: Real> Dot2<T> {
    /// The sum of one number.
    pub(crate) const fn of(number: T) -> Self {
        Self { sum: number, error: T::ZERO }
    }

    /// The sum, corrected by its error and rounded.
    pub(crate) fn value(self) -> T {
        self.sum + self.error
    }
}

impl<T: Real> Sum<T> for Dot2<T> {
    /// Adds `x y`, with the errors of Knuth's sum and of Dekker's product.
    #[inline]
    fn add(&mut self, x: T, y: T) {
        if x == T::ZERO {
            return; // saves the operations: half of the entries of a robot's matrices are zero
        }
        let product = x * y;
        let sum = self.sum + product;
        let added = sum - self.sum;
        let sum_error = (self.sum - (sum - added)) + (product - added);
        let [(x, x_low), (y, y_low)] = [x, y].map(halves);
        let product_error = ((x * y - product) + x * y_low + x_low * y) + x_low * y_low;
        self.error += sum_error + product_error;
        self.sum = sum;
    }
}

/// Two numbers whose sum is `x`, each with half of its digits, so that their products are exact (Veltkamp).
#[inline]
fn halves<T: Real>(x: T) -> (T, T) {
    let scaled = x * T::splitter();
    let high = scaled - (scaled - x);
    (high, x - high)
}

#[cfg(test)]
mod tests;
