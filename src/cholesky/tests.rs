//! `Uᵀ D⁻¹ U` against its definition, one degenerate matrix a test.
#![allow(clippy::indexing_slicing, clippy::expect_used, clippy::float_cmp)]

extern crate std;

use super::factorise;
use crate::substitution::solve;
use nalgebra::{DMatrix, DVector};
use proptest::collection::vec;
use proptest::prelude::*;
use std::vec::Vec;

/// A random `n × n` matrix, positive definite by construction, and a right-hand side.
fn systems() -> impl Strategy<Value = (DMatrix<f64>, DVector<f64>)> {
    (1_usize..=12).prop_flat_map(|n| {
        (vec(-1.0..1.0, n * n), vec(-1.0..1.0, n)).prop_map(move |(root, b)| {
            let root = DMatrix::from_vec(n, n, root);
            let a = &root * root.transpose() + DMatrix::identity(n, n) * 0.1;
            (a, DVector::from_vec(b))
        })
    })
}

/// Row-major storage with `stride - n` columns of padding.
fn store(a: &DMatrix<f64>, stride: usize) -> Vec<f64> {
    let n = a.nrows();
    let mut storage = std::vec![f64::NAN; n * stride];
    for i in 0..n {
        for j in 0..n {
            storage[i * stride + j] = a[(i, j)];
        }
    }
    storage
}

/// The row at which a matrix fails, if it does.
fn failure(rows: &[&[f64]], floor: f64) -> Option<usize> {
    let n = rows.len();
    let mut storage = std::vec![f64::NAN; n * n];
    factorise(&rows.concat(), n, n, floor, &mut storage).err()
}

/// Does a solve with the factor solve the system?
fn solves<const N: usize>(a: &DMatrix<f64>, b: &DVector<f64>) -> Result<(), TestCaseError> {
    let mut factor = [[f64::NAN; N]; N];
    factorise(&store(a, N), N, N, 0.0, factor.as_flattened_mut()).expect("positive definite");
    let mut x = [0.0; N];
    x.copy_from_slice(b.as_slice());
    solve(&factor, &mut x);
    let x = DVector::from_column_slice(&x);
    prop_assert!((a * &x - b).norm() <= 1e-13 * (a.norm() * x.norm() + b.norm()));
    Ok(())
}

proptest! {
    #[test]
    fn the_factors_multiply_to_the_matrix((a, _) in systems(), padding in 0_usize..3) {
        let (n, stride) = (a.nrows(), a.nrows() + padding);
        let mut storage = std::vec![f64::NAN; n * stride];
        factorise(&store(&a, stride), stride, n, 0.0, &mut storage).expect("positive definite");
        let entry = |i: usize, j: usize| storage[i * stride + j];
        let u = DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
            core::cmp::Ordering::Less => 0.0,
            core::cmp::Ordering::Equal => 1.0 / entry(i, i),
            core::cmp::Ordering::Greater => entry(i, j),
        });
        let reciprocals = DMatrix::from_diagonal(&DVector::from_fn(n, |i, _| entry(i, i)));
        prop_assert!((u.transpose() * reciprocals * &u - &a).norm() <= 1e-14 * a.norm());
    }

    #[test]
    fn the_solves_solve_the_system((a, b) in systems()) {
        macro_rules! sizes {
            ($($n:literal),*) => {
                match a.nrows() {
                    $($n => solves::<$n>(&a, &b)?,)*
                    n => unreachable!("{n} rows"),
                }
            };
        }
        sizes!(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12);
    }

    #[test]
    fn a_change_of_units_by_powers_of_two_changes_exponents_only(
        (a, _) in systems(),
        exponents in vec(-20_i32..20, 12),
    ) {
        let n = a.nrows();
        let unit = |i: usize| 2_f64.powi(exponents[i]);
        let scaled = DMatrix::from_fn(n, n, |i, j| a[(i, j)] * unit(i) * unit(j));
        let factor = |a| {
            let mut factor = std::vec![0.0; n * n];
            factorise(&store(a, n), n, n, 0.0, &mut factor).expect("positive definite");
            factor
        };
        let (a, scaled) = (factor(&a), factor(&scaled));
        for i in 0..n {
            for j in 0..i {
                prop_assert_eq!(scaled[i * n + j], a[i * n + j] * unit(i) * unit(j));
            }
            prop_assert_eq!(scaled[i * n + i], a[i * n + i] / unit(i) / unit(i));
        }
    }

    #[test]
    fn a_negative_direction_is_reported_at_its_row((a, _) in systems(), row in 0_usize..12) {
        let (n, row) = (a.nrows(), row % a.nrows());
        let mut a = a;
        a[(row, row)] = -a[(row, row)];
        let mut storage = store(&a, n);
        prop_assert_eq!(factorise(&store(&a, n), n, n, 0.0, &mut storage), Err(row));
    }
}

#[test]
fn a_singleton_is_its_own_pivot() {
    let mut u = [0.0];
    assert_eq!(factorise(&[4.0], 1, 1, 0.0, &mut u), Ok(()));
    assert_eq!(u, [0.25]);
    assert_eq!(failure(&[&[-4.0]], 0.0), Some(0));
}

#[test]
fn no_rows_need_no_pivot() {
    assert_eq!(factorise::<f64>(&[], 3, 0, 0.0, &mut []), Ok(()));
}

#[test]
fn a_zero_on_the_diagonal_is_no_pivot() {
    assert_eq!(failure(&[&[0.0]], 0.0), Some(0));
    assert_eq!(failure(&[&[1.0, 0.0], &[0.0, 0.0]], 0.0), Some(1));
    assert_eq!(failure(&[&[0.0, 1.0], &[1.0, 0.0]], 0.0), Some(1));
}

#[test]
fn a_rank_deficient_matrix_fails_at_the_dependent_row() {
    let rows: [&[f64]; 3] = [&[2.0, 1.0, 3.0], &[1.0, 2.0, 3.0], &[3.0, 3.0, 6.0]];
    assert_eq!(failure(&rows, 6.0 * f64::EPSILON), Some(0));
}

#[test]
fn a_pivot_below_the_threshold_is_rounding() {
    let rows: [&[f64]; 2] = [&[1.0 + f64::EPSILON, 1.0], &[1.0, 1.0]];
    assert_eq!(failure(&rows, f64::EPSILON), Some(0));
    assert_eq!(failure(&rows, 0.0), None);
}

#[test]
fn a_nan_is_no_pivot() {
    assert_eq!(failure(&[&[f64::NAN]], 0.0), Some(0));
    assert_eq!(failure(&[&[1.0, 0.0], &[f64::NAN, 1.0]], 0.0), Some(0));
}
