//! The linear step of one ADMM iteration in its two forms, timed for a range of sizes.
//!
//! Velocity space: `H (M + rho HᵀH)⁻¹ Hᵀ x` through the stored Cholesky factor, `N² + 2·N·m`
//! multiplications for `m` contact rows. Contact space: one symmetric matrix, `m²`. Both with
//! nalgebra's products and solves, so that the forms are compared and not two programmers.
//!
//! `cargo run --release -p linear_step`

#![allow(clippy::cast_precision_loss)] // indices are small

use nalgebra::{Cholesky, Const, RealField, SMatrix, SVector};
use std::hint::black_box;
use std::time::Instant;

/// Best of 200 batches of 100 calls, in nanoseconds a call.
fn time(mut call: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..200 {
        let start = Instant::now();
        for _ in 0..100 {
            call();
        }
        best = best.min(start.elapsed().as_secs_f64() * 1e9 / 100.0);
    }
    best
}

/// Times both forms for `N` velocities and `R` contact rows.
fn measure<T: RealField + Copy, const N: usize, const R: usize>() -> (f64, f64) {
    let number = |x: f64| nalgebra::convert::<f64, T>(x);
    let h = SMatrix::<T, R, N>::from_fn(|i, j| number(((3 * i + 7 * j) % 11) as f64 / 11.0 - 0.4));
    let a = SMatrix::<T, N, N>::identity() + h.transpose() * h;
    let factor: Cholesky<T, Const<N>> = Cholesky::new(a).expect("positive definite");
    let g = h * factor.solve(&h.transpose());
    let x = SVector::<T, R>::from_fn(|i, _| number(1.0 / (i + 1) as f64));
    let mut y = x;
    let velocity_space = time(|| {
        let mut v = h.tr_mul(black_box(&x));
        factor.solve_mut(&mut v);
        y.gemv(number(1.0), &h, &v, number(0.0));
        black_box(&y);
    });
    let contact_space = time(|| {
        y.gemv(number(1.0), &g, black_box(&x), number(0.0));
        black_box(&y);
    });
    (velocity_space, contact_space)
}

fn main() {
    println!("linear step, ns (best of 200 batches), velocity space / contact space\n");
    println!("{:>5} {:>5} {:>17} {:>17}", "dofs", "rows", "f64", "f32");
    macro_rules! row {
        ($($n:literal $r:literal),*) => {$(
            let (double, single) = (measure::<f64, $n, $r>(), measure::<f32, $n, $r>());
            println!(
                "{:>5} {:>5} {:>8.0} /{:>7.0} {:>8.0} /{:>7.0}",
                $n, $r, double.0, double.1, single.0, single.1
            );
        )*};
    }
    row!(3 2, 6 3, 6 12, 6 24, 12 12, 12 33, 18 12, 18 24, 18 36, 24 36, 30 12, 30 36);
}
