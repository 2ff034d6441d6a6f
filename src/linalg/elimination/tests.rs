//! A symmetric matrix is eliminated by half of it, one that is not needs its pivots, with and without joint rows behind the
//! contacts.
#![allow(clippy::indexing_slicing)]

extern crate std;

use super::Elimination;
use crate::linalg::stacked::{Stacked, StackedMatrix};
use nalgebra::{DMatrix, DVector, dmatrix, dvector};
use proptest::prelude::*;
use std::vec;

const D: usize = 3;
const C: usize = 4;
/// Room for joint rows, where there is any.
const R: usize = 5;
const ROWS: usize = D * C + R;

/// How many unknowns contacts and joint rows have.
#[derive(Clone, Copy, Debug)]
struct Unknowns {
    contacts: [usize; C],
    rows: usize,
}

impl Unknowns {
    /// Those of all contacts.
    fn of_contacts(self) -> usize {
        self.contacts.iter().sum()
    }

    fn all(self) -> usize {
        self.of_contacts() + self.rows
    }
}

/// The entry of an unknown.
fn entry<const R: usize>(x: &mut Stacked<f64, D, C, R>, unknowns: Unknowns, place: usize) -> &mut f64 {
    match place.checked_sub(unknowns.of_contacts()) {
        Some(row) => &mut x.rows[row],
        None => &mut x.contacts.as_flattened_mut()[place],
    }
}

/// Zeros for contacts; what joint rows do not use is no number.
fn blank<const R: usize>(unknowns: Unknowns) -> Stacked<f64, D, C, R> {
    let mut blank = Stacked::zero();
    blank.rows[unknowns.rows..].fill(f64::NAN);
    blank
}

/// Writes the leading part of `a` contact by contact, and behind it that of joint rows; of what stands below the diagonal
/// (of that of blocks for contacts) `below` times as much.
fn lay_out<const R: usize>(
    unknowns: Unknowns,
    a: &DMatrix<f64>,
    below: f64,
) -> (Elimination<f64, D, C, R>, StackedMatrix<f64, D, C, R>) {
    let mut elimination = Elimination::none();
    elimination.lay_out(unknowns.contacts.into_iter(), unknowns.rows);
    let mut matrix = StackedMatrix { contacts: [[blank(unknowns); D]; C], rows: [blank(unknowns); R] };
    for row in matrix.rows.iter_mut().skip(unknowns.rows) {
        row.iter_mut().for_each(|entry| *entry = f64::NAN);
    }
    let fill = |target: &mut Stacked<f64, D, C, R>, place: usize, start: usize| {
        for column in 0..unknowns.all() {
            let factor = if column < start { below } else { 1.0 };
            *entry(target, unknowns, column) = factor * a[(place, column)];
        }
    };
    for (i, rows) in matrix.contacts.iter_mut().enumerate() {
        let own = elimination.columns(i);
        for (place, row) in own.clone().zip(rows) {
            fill(row, place, own.start);
        }
    }
    for (place, row) in (unknowns.of_contacts()..unknowns.all()).zip(&mut matrix.rows) {
        fill(row, place, place);
    }
    (elimination, matrix)
}

/// The solution for a right-hand side, if there is one, and how far `a` times that is from it.
fn solve<const R: usize>(
    unknowns: Unknowns,
    a: &DMatrix<f64>,
    b: &DVector<f64>,
    symmetric: bool,
) -> Option<(DVector<f64>, f64)> {
    let below = if symmetric { f64::NAN } else { 1.0 };
    let (mut elimination, mut matrix) = lay_out::<R>(unknowns, &a.transpose(), below);
    elimination.factorise(&mut matrix, symmetric)?;
    assert!(!symmetric || elimination.is_positive());
    // Behind the last unknown there may be anything.
    let size = unknowns.all();
    let mut solution = Stacked::<f64, D, C, R>::zero();
    solution.iter_mut().for_each(|entry| *entry = f64::NAN);
    for place in 0..size {
        *entry(&mut solution, unknowns, place) = b[place];
    }
    elimination.solve(&matrix, &mut solution)?;
    let solution = DVector::from_fn(size, |place, _| *entry(&mut solution, unknowns, place));
    let product = a.view((0, 0), (size, size)) * &solution;
    Some((solution, (product - b.rows(0, size)).norm()))
}

/// Half of a symmetric matrix leads to the same as all of it.
fn halves<const R: usize>(entries: &[f64], right: &[f64], unknowns: Unknowns) -> Result<(), TestCaseError> {
    let rows = D * C + R;
    let root = DMatrix::from_column_slice(rows, rows, &entries[..rows * rows]);
    let a = &root * root.transpose() + DMatrix::identity(rows, rows) * 0.1;
    let b = DVector::from_column_slice(&right[..rows]);
    let regular = || TestCaseError::fail("no pivot");
    let (half, error) = solve::<R>(unknowns, &a, &b, true).ok_or_else(regular)?;
    prop_assert!(error <= 1e-11, "of a half: {error}");
    let (whole, error) = solve::<R>(unknowns, &a, &b, false).ok_or_else(regular)?;
    prop_assert!(error <= 1e-11, "of the whole: {error}");
    let difference = (half - whole).norm();
    prop_assert!(difference <= 1e-11, "apart by {difference}");
    Ok(())
}

/// What has its large entries anywhere within the equations of a contact, and anywhere within those of joint rows, is solved
/// as by elimination with all pivots.
fn pivots<const R: usize>(
    entries: &[f64],
    right: &[f64],
    unknowns: Unknowns,
    turn: usize,
) -> Result<(), TestCaseError> {
    let size = unknowns.all();
    let mut a = DMatrix::from_column_slice(size, size, &entries[..size * size]);
    let mut start = 0;
    for count in unknowns.contacts.into_iter().chain([unknowns.rows]) {
        for k in 0..count {
            a[(start + (k + turn) % count, start + k)] += 20.0;
        }
        start += count;
    }
    let b = DVector::from_column_slice(&right[..size]);
    let regular = || TestCaseError::fail("no pivot");
    let (found, error) = solve::<R>(unknowns, &a, &b, false).ok_or_else(regular)?;
    prop_assert!(error <= 1e-12, "{error}");
    if size == 0 {
        return Ok(()); // of which nalgebra's solve makes none
    }
    let wanted = a.lu().solve(&b).ok_or_else(regular)?;
    let difference = (found - wanted).norm();
    prop_assert!(difference <= 1e-12, "apart by {difference}");
    Ok(())
}

proptest! {
    #[test]
    fn half_of_a_symmetric_matrix_is_enough(
        entries in prop::collection::vec(-1.0_f64..1.0, ROWS * ROWS),
        right in prop::collection::vec(-1.0_f64..1.0, ROWS),
        contacts in [0_usize..=D, 0..=D, 0..=D, 0..=D],
        rows in 0..=R,
    ) {
        halves::<0>(&entries, &right, Unknowns { contacts, rows: 0 })?;
        halves::<R>(&entries, &right, Unknowns { contacts, rows })?;
    }

    #[test]
    fn pivots_are_sought_within_a_contact_and_among_joint_rows(
        entries in prop::collection::vec(-1.0_f64..1.0, ROWS * ROWS),
        right in prop::collection::vec(-1.0_f64..1.0, ROWS),
        contacts in [0_usize..=D, 0..=D, 0..=D, 0..=D],
        rows in 0..=R,
        turn in 0..R,
    ) {
        pivots::<0>(&entries, &right, Unknowns { contacts, rows: 0 }, turn)?;
        pivots::<R>(&entries, &right, Unknowns { contacts, rows }, turn)?;
    }
}

#[test]
fn a_matrix_that_is_not_symmetric_needs_its_pivots() {
    fn check<const R: usize>(unknowns: Unknowns) {
        let swap = dmatrix![0.0, 2.0; 3.0, 0.0];
        let b = DVector::from_element(2, 6.0);
        let solution = solve::<R>(unknowns, &swap, &b, false);
        assert_eq!(solution, Some((dvector![2.0, 3.0], 0.0)));
        // On its diagonal there are none.
        assert_eq!(solve::<R>(unknowns, &swap, &b, true), None);
    }
    let contacts = [2, 0, 0, 0];
    check::<0>(Unknowns { contacts, rows: 0 });
    check::<R>(Unknowns { contacts, rows: 0 });
    let contacts = [0; C];
    check::<2>(Unknowns { contacts, rows: 2 });
    check::<R>(Unknowns { contacts, rows: 2 });
}

/// Three joint rows go round, behind a contact that is coupled to them: each pivot stands in another equation, and multipliers
/// change places with their equations.
#[test]
fn joint_rows_change_places_behind_a_contact() {
    let a = dmatrix![
        1.0, 1.0, 2.0, 0.0;
        1.0, 1.0, 2.0, 4.0;
        2.0, 4.0, 4.0, 0.0;
        3.0, 3.0, 14.0, 0.0];
    let b = dvector![4.0, 8.0, 10.0, 20.0];
    for contacts in [[1, 0, 0, 0], [0, 0, 1, 0]] {
        let unknowns = Unknowns { contacts, rows: 3 };
        let solution = solve::<3>(unknowns, &a, &b, false);
        assert_eq!(solution, Some((dvector![1.0, 1.0, 1.0, 1.0], 0.0)));
        // Nothing is left on the diagonal of the first of them.
        assert_eq!(solve::<3>(unknowns, &a, &b, true), None);
    }
}

#[test]
fn joint_rows_that_depend_on_each_other_have_no_pivot() {
    let a = dmatrix![
        2.0, 1.0, 1.0;
        1.0, 2.0, 2.0;
        1.0, 2.0, 2.0];
    let (contacts, rows) = ([0, 1, 0, 0], 2);
    let b = dvector![1.0, 1.0, 1.0];
    for symmetric in [false, true] {
        let unknowns = Unknowns { contacts, rows };
        assert_eq!(solve::<2>(unknowns, &a, &b, symmetric), None);
    }
}

/// What is not positive definite may be factorised, and is told.
#[test]
fn a_negative_pivot_is_told() {
    for (contacts, rows) in [([2, 0, 0, 0], 0), ([1, 0, 0, 0], 1), ([0; C], 2)] {
        let unknowns = Unknowns { contacts, rows };
        for (last, positive) in [(2.0, true), (0.5, false)] {
            let a = dmatrix![1.0, 1.0; 1.0, last];
            let (mut elimination, mut matrix) = lay_out::<2>(unknowns, &a, f64::NAN);
            assert_eq!(elimination.factorise(&mut matrix, true), Some(()));
            assert_eq!(elimination.is_positive(), positive, "{unknowns:?}");
        }
    }
}
