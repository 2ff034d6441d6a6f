//! Sums of products that carry their rounding errors along (T. Ogita, S. M. Rump, S. Oishi, *Accurate Sum and Dot Product*, 2005).

use crate::real::Real;

/// A sum of `n` products, off by `eps / 2` of its value and `(n eps / 2)²` of the sum of the magnitudes of its terms, where
/// nothing overflows and no product is within `1 / eps²` of the least number.
#[derive(Clone, Copy)]
pub(crate) struct Dot2<T> {
    sum: T,
    /// What rounding has taken from it.
    rest: T,
}

impl<T: Real> Dot2<T> {
    /// The sum of one number.
    pub(crate) const fn of(number: T) -> Self {
        Self {
            sum: number,
            rest: T::ZERO,
        }
    }

    /// Adds `x y`: Knuth's sum with its error, and Dekker's product with its error.
    #[inline]
    pub(crate) fn add(&mut self, x: T, y: T) {
        let product = x * y;
        let sum = self.sum + product;
        let added = sum - self.sum;
        let lost = (self.sum - (sum - added)) + (product - added);
        let ((x, x_low), (y, y_low)) = (halves(x), halves(y));
        let rest = ((x * y - product) + x * y_low + x_low * y) + x_low * y_low;
        self.rest += lost + rest;
        self.sum = sum;
    }

    /// Its value.
    pub(crate) fn value(self) -> T {
        self.sum + self.rest
    }
}

/// A number as a sum of two, each with half of its digits, so that their products are exact (Veltkamp).
#[inline]
fn halves<T: Real>(x: T) -> (T, T) {
    let scaled = x * T::splitter();
    let high = scaled - (scaled - x);
    (high, x - high)
}

#[cfg(test)]
mod tests;
