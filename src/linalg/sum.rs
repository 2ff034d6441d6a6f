//! Running sums of products: plain numbers, magnitudes, both, and sums in twice the digits ([`super::dot2`]). The loops of
//! [`super::sparsity`] serve all of them.

use crate::linalg::cholesky::BLOCK;
use crate::linalg::zip::zip3;
use crate::real::Real;

/// Bytes of registers for the sums of a block. The sums of magnitudes take as many, and the terms a quarter of all registers: 128
/// bytes on a Cortex-M4F, 256 on a desktop (16 vectors of 16 bytes). So the sums take three eighths.
const SUMS: usize = if cfg!(target_os = "none") { 48 } else { 96 };

/// A running sum of products.
pub(crate) trait Sum<T>: Copy {
    /// Adds `x y`.
    fn add(&mut self, x: T, y: T);
}

impl<T: Real> Sum<T> for T {
    #[inline]
    fn add(&mut self, x: T, y: T) {
        *self += x * y;
    }
}

/// The sum of the magnitudes of its terms.
#[derive(Clone, Copy)]
pub(crate) struct Size<T>(pub(crate) T);

impl<T: Real> Sum<T> for Size<T> {
    #[inline]
    fn add(&mut self, x: T, y: T) {
        self.0 += (x * y).abs();
    }
}

/// A sum, and the sum of the magnitudes of its terms.
#[derive(Clone, Copy)]
pub(crate) struct SizedSum<T> {
    pub(crate) sum: T,
    pub(crate) size: T,
}

impl<T: Real> SizedSum<T> {
    /// The sum of one number.
    pub(crate) fn of(number: T) -> Self {
        Self { sum: number, size: number.abs() }
    }
}

impl<T: Real> Sum<T> for SizedSum<T> {
    #[inline]
    fn add(&mut self, x: T, y: T) {
        let product = x * y;
        self.sum += product;
        self.size += product.abs();
    }
}

/// Fills `product` with `A v` for the first `n` rows and columns of a symmetric `A`, and begins sums with the sizes of its terms.
#[inline]
pub(crate) fn multiply_sized<T: Real, const N: usize>(
    (matrix, n): (&[[T; N]; N], usize),
    v: &[T; N],
    (product, begun): (&mut [T; N], &mut [SizedSum<T>; N]),
) {
    let matrix = matrix.get(..n).unwrap_or_default();
    if N * size_of::<T>() <= SUMS {
        return multiply_rows::<T, N, N>(matrix, 0, v, (product, begun));
    }
    // The last block repeats some rows, so that all blocks have the same size.
    let (mut first, last) = (0, n.saturating_sub(BLOCK));
    while first < last + BLOCK {
        multiply_rows::<T, N, BLOCK>(matrix, first.min(last), v, (product, begun));
        first += BLOCK;
    }
}

/// `K` entries of [`multiply_sized`] from row `first` on.
#[inline]
fn multiply_rows<T: Real, const N: usize, const K: usize>(
    matrix: &[[T; N]],
    first: usize,
    v: &[T; N],
    (product, begun): (&mut [T; N], &mut [SizedSum<T>; N]),
) {
    let mut sums = [SizedSum::of(T::ZERO); K];
    // A slice, since a loop over the array would be unrolled, with more sums than registers.
    for (column, &v) in matrix.iter().zip(v) {
        let Some(column) = column.get(first..).and_then(<[T]>::first_chunk::<K>) else {
            break;
        };
        for (sum, &entry) in sums.iter_mut().zip(column) {
            sum.add(entry, v);
        }
    }
    let product = product.get_mut(first..).unwrap_or_default();
    let begun = begun.get_mut(first..).unwrap_or_default();
    for (product, begun, SizedSum { sum, size }) in zip3(product, begun, sums) {
        (*product, *begun) = (sum, SizedSum { sum: T::ZERO, size });
    }
}
