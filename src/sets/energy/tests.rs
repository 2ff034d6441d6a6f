//! Impulses whose squares vanish.
#![allow(clippy::expect_used)]

use super::EnergyScale;
use crate::linalg::stacked::{Counts, Stacked};
use crate::sets::{RowSet, Sets};

/// A limit that pushes what moves away has an error of 1, however small its impulse is: none is needed.
#[test]
fn an_impulse_whose_square_vanishes_is_an_error() {
    let mut sets = Sets::<f32, 3, 1, 1>::of(Counts { contacts: 0, rows: 1 });
    *sets.rows_mut().first_mut().expect("a row") = RowSet::of([0.0, f32::INFINITY], 1.0);
    let energy = EnergyScale::new(&sets, 0.0);
    let of = |impulse: f32| {
        let r = Stacked { contacts: [[0.0; 3]], rows: [impulse] };
        energy.larger_error(0.0, &sets, (&Stacked { rows: [1e-30], ..r }, &r), None)
    };
    assert!(of(0.0) <= 0.0 && of(1e-30) >= 1.0);
}
