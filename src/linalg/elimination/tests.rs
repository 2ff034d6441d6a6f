//! A symmetric matrix is eliminated by half of it.

use super::Elimination;
use crate::linalg::blocks::{ContactMatrix, ContactVector};
use nalgebra::{SMatrix, SVector};
use proptest::prelude::*;

const D: usize = 3;
const C: usize = 4;
const ROWS: usize = 12;

/// Writes the leading part of `a` contact by contact; of blocks below the diagonal `below` times as much.
fn lay_out(
    counts: [usize; C],
    a: &SMatrix<f64, ROWS, ROWS>,
    below: f64,
) -> (Elimination<f64, D, C>, ContactMatrix<f64, D, C>) {
    let mut elimination = Elimination::none();
    elimination.lay_out(counts.into_iter());
    let mut matrix = [[[[0.0; D]; C]; D]; C];
    let size = counts.iter().sum();
    for (i, rows) in matrix.iter_mut().enumerate() {
        let own = elimination.columns(i);
        for (place, row) in own.clone().zip(rows) {
            let row = row.as_flattened_mut();
            let entries = a.row(place);
            for (column, (entry, &source)) in row.iter_mut().zip(&entries).enumerate().take(size) {
                let factor = if column < own.start { below } else { 1.0 };
                *entry = factor * source;
            }
        }
    }
    (elimination, matrix)
}

/// The solution for a right-hand side, if there is one, and how far `a` times that is from it.
fn solve(
    counts: [usize; C],
    a: &SMatrix<f64, ROWS, ROWS>,
    b: &SVector<f64, ROWS>,
    symmetric: bool,
) -> Option<(SVector<f64, ROWS>, f64)> {
    let below = if symmetric { f64::NAN } else { 1.0 };
    let (mut elimination, mut matrix) = lay_out(counts, a, below);
    elimination.factorise(&mut matrix, symmetric)?;
    let mut solution: ContactVector<f64, D, C> = [[0.0; D]; C];
    solution.as_flattened_mut().copy_from_slice(b.as_slice());
    elimination.solve(&matrix, solution.as_flattened_mut())?;
    let size = counts.iter().sum();
    let solution = SVector::<f64, ROWS>::from_column_slice(solution.as_flattened());
    let product = a.view((0, 0), (size, size)) * solution.rows(0, size);
    Some((solution, (product - b.rows(0, size)).norm()))
}

proptest! {
    #[test]
    fn half_of_a_symmetric_matrix_is_enough(
        entries in prop::collection::vec(-1.0_f64..1.0, ROWS * ROWS),
        right in prop::collection::vec(-1.0_f64..1.0, ROWS),
        counts in [0_usize..=D, 0..=D, 0..=D, 0..=D],
    ) {
        let root = SMatrix::<f64, ROWS, ROWS>::from_iterator(entries);
        let a = root * root.transpose() + SMatrix::identity() * 0.1;
        let b = SVector::from_iterator(right);
        let regular = || TestCaseError::fail("no pivot");
        let (half, error) = solve(counts, &a, &b, true).ok_or_else(regular)?;
        prop_assert!(error <= 1e-11, "of a half: {error}");
        let (whole, error) = solve(counts, &a, &b, false).ok_or_else(regular)?;
        prop_assert!(error <= 1e-11, "of the whole: {error}");
        let size = counts.iter().sum();
        let difference = (half - whole).rows(0, size).norm();
        prop_assert!(difference <= 1e-11, "apart by {difference}");
    }
}

#[test]
fn a_matrix_that_is_not_symmetric_needs_its_pivots() {
    let counts = [2, 0, 0, 0];
    let swap = nalgebra::matrix![0.0, 2.0; 3.0, 0.0];
    let mut a = SMatrix::<f64, ROWS, ROWS>::zeros();
    a.fixed_view_mut::<2, 2>(0, 0).copy_from(&swap);
    let b = SVector::from_element(6.0);
    let solution = solve(counts, &a, &b, false);
    let solution = solution.map(|(x, error)| (x.fixed_rows::<2>(0).into_owned(), error));
    assert_eq!(solution, Some((nalgebra::vector![2.0, 3.0], 0.0)));
    // On its diagonal there are none.
    assert_eq!(solve(counts, &a, &b, true), None);
}
