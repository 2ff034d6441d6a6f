//! Every public call of derivatives.

use crate::proof::take;
use core::hint::black_box;
use stiction::{Derivative, Error, Inputs, Outputs, Real};

pub(crate) fn differentiate<
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize,
    const S: usize,
>(
    derivative: Result<Derivative<'_, T, N, D, C, R, S>, Error>,
) {
    if let Ok(derivative) = &derivative {
        black_box(derivative.margin());
        black_box((derivative.has_unique_impulses(), derivative.has_unique_velocity()));
        let (change, weights) = black_box((Inputs::zero(), Outputs::zero()));
        black_box(derivative.forward(&change));
        black_box(derivative.misfit(&change));
        black_box(derivative.adjoint(&weights));
    }
    take(derivative.map(|_| ()));
}
