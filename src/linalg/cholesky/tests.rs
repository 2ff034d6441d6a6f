//! `Lᵀ D⁻¹ L` against its definition, one degenerate matrix a test.
#![allow(clippy::indexing_slicing, clippy::expect_used, clippy::float_cmp)]

extern crate std;

use super::factorise;
use crate::linalg::substitution::{solve_lower, solve_upper};
use nalgebra::{DMatrix, DVector};
use proptest::collection::vec;
use proptest::prelude::*;

/// A random `n × n` matrix, positive definite by construction, and a right-hand side.
fn systems() -> impl Strategy<Value = (DMatrix<f64>, DVector<f64>)> {
    (1_usize..=13).prop_flat_map(|n| {
        (vec(-1.0..1.0, n * n), vec(-1.0..1.0, n)).prop_map(move |(root, b)| {
            let root = DMatrix::from_vec(n, n, root);
            let a = &root * root.transpose() + DMatrix::identity(n, n) * 0.1;
            (a, DVector::from_vec(b))
        })
    })
}

/// The factor, whose upper triangle is no part of it, or the row of the first pivot that is none.
fn factor<const N: usize>(a: &[[f64; N]; N], floor: f64) -> Result<[[f64; N]; N], usize> {
    let mut l = [[f64::NAN; N]; N];
    factorise((a, N), floor, &mut l, &mut [0; N]).map(|()| l)
}

/// The same and a solve, for a matrix of any size.
fn factor_and_solve(a: &DMatrix<f64>, b: &DVector<f64>) -> Result<(DMatrix<f64>, DVector<f64>), usize> {
    macro_rules! sizes {
        ($($n:literal),*) => {
            match a.nrows() {
                $($n => {
                    let rows = core::array::from_fn(|i| core::array::from_fn(|j| a[(i, j)]));
                    let l = factor::<$n>(&rows, 0.0)?;
                    let mut x = core::array::from_fn(|i| b[i]);
                    solve_upper(&l, &mut x, $n);
                    solve_lower(&l, &mut x, $n);
                    Ok((DMatrix::from_fn($n, $n, |i, j| l[i][j]), DVector::from_column_slice(&x)))
                })*
                n => unreachable!("{n} rows"),
            }
        };
    }
    sizes!(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13)
}

proptest! {
    #[test]
    fn the_factors_multiply_to_the_matrix((a, b) in systems()) {
        let n = a.nrows();
        let (factor, _) = factor_and_solve(&a, &b).expect("positive definite");
        let l = DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
            core::cmp::Ordering::Less => 0.0,
            core::cmp::Ordering::Equal => 1.0 / factor[(i, i)],
            core::cmp::Ordering::Greater => factor[(i, j)],
        });
        let reciprocals = DMatrix::from_diagonal(&factor.diagonal());
        prop_assert!((l.transpose() * reciprocals * &l - &a).norm() <= 1e-14 * a.norm());
    }

    #[test]
    fn the_solves_solve_the_system((a, b) in systems()) {
        let (_, x) = factor_and_solve(&a, &b).expect("positive definite");
        prop_assert!((&a * &x - &b).norm() <= 1e-13 * (a.norm() * x.norm() + b.norm()));
    }

    #[test]
    fn a_change_of_units_by_powers_of_two_changes_exponents_only(
        (a, b) in systems(),
        exponents in vec(-20_i32..20, 13),
    ) {
        let n = a.nrows();
        let unit = |i: usize| 2_f64.powi(exponents[i]);
        let scaled = DMatrix::from_fn(n, n, |i, j| a[(i, j)] * unit(i) * unit(j));
        let (a, _) = factor_and_solve(&a, &b).expect("positive definite");
        let (scaled, _) = factor_and_solve(&scaled, &b).expect("positive definite");
        for i in 0..n {
            for j in 0..i {
                prop_assert_eq!(scaled[(i, j)], a[(i, j)] * unit(i) * unit(j));
            }
            prop_assert_eq!(scaled[(i, i)], a[(i, i)] / unit(i) / unit(i));
        }
    }

    #[test]
    fn a_negative_direction_is_reported_at_its_row((a, b) in systems(), row in 0_usize..13) {
        let row = row % a.nrows();
        let mut a = a;
        a[(row, row)] = -a[(row, row)];
        prop_assert_eq!(factor_and_solve(&a, &b).err(), Some(row));
    }
}

#[test]
fn a_singleton_is_its_own_pivot() {
    assert_eq!(factor(&[[4.0]], 0.0), Ok([[0.25]]));
    assert_eq!(factor(&[[-4.0]], 0.0), Err(0));
}

#[test]
fn no_rows_need_no_pivot() {
    assert_eq!(factor(&[], 0.0), Ok([]));
}

#[test]
fn a_zero_on_the_diagonal_is_no_pivot() {
    assert_eq!(factor(&[[0.0]], 0.0), Err(0));
    assert_eq!(factor(&[[1.0, 0.0], [0.0, 0.0]], 0.0), Err(1));
    assert_eq!(factor(&[[0.0, 1.0], [1.0, 0.0]], 0.0), Err(1));
}

#[test]
fn a_rank_deficient_matrix_fails_at_the_dependent_row() {
    let rows = [[2.0, 1.0, 3.0], [1.0, 2.0, 3.0], [3.0, 3.0, 6.0]];
    assert_eq!(factor(&rows, 6.0 * f64::EPSILON), Err(0));
}

#[test]
fn a_pivot_below_the_threshold_is_rounding() {
    let rows = [[1.0 + f64::EPSILON, 1.0], [1.0, 1.0]];
    assert_eq!(factor(&rows, f64::EPSILON), Err(0));
    assert!(factor(&rows, 0.0).is_ok());
}

#[test]
fn a_nan_is_no_pivot() {
    assert_eq!(factor(&[[f64::NAN]], 0.0), Err(0));
    assert_eq!(factor(&[[1.0, 0.0], [f64::NAN, 1.0]], 0.0), Err(0));
}
