//! Joint rows on the central path: products, and steps to first order.
#![allow(clippy::indexing_slicing)]

use super::RowPairs;
use crate::problem::row_laws::RowLaws;
use nalgebra::{SVector, vector};

const INFINITY: f64 = f64::INFINITY;

/// A limit, an equality, a box, and a box that is none.
fn laws() -> RowLaws<f64, 4> {
    RowLaws::of([
        [0.0, INFINITY],
        [-INFINITY, INFINITY],
        [-0.5, 2.0],
        [0.3, 0.3],
    ])
}

#[test]
fn rows_are_centred_between_their_bounds() {
    let mut r = vector![-1.0, 3.0, 5.0, 0.3];
    let u: SVector<f64, 4> = vector![0.4, 0.0, -1.0, 0.0];
    let pairs = RowPairs::centred((&laws(), 1.0), &mut r, &u, 1e-2, 1.0);
    assert!(r[0] > 0.0 && (-0.5..2.0).contains(&r[2]));
    assert_eq!((r[1], r[3]), (3.0, 0.3));
    let mut count = 0;
    for product in pairs.products() {
        assert!((product - 1e-2).abs() < 1e-12, "{product}");
        count += 1;
    }
    assert_eq!(count, 3); // one of the limit, two of the box
    assert!(pairs.answer(0) > 0.0 && pairs.answer(1) < 1e-10 && pairs.answer(3) > 1e20);
}

#[test]
fn a_step_does_what_it_is_told() {
    let mut r = vector![0.7, 3.0, 0.1, 0.3];
    let u: SVector<f64, 4> = vector![0.4, 0.0, -1.0, 0.0];
    let pairs = RowPairs::centred((&laws(), 1.0), &mut r, &u, 1e-1, 1.0);
    let goal = 3e-2;
    let moved = vector![0.01, 0.4, -0.02, 0.0];
    let step = pairs.step(&moved, &pairs.corrected(None, goal));
    // To first order, products become the goal.
    for (h, bound) in [(1e-4, 1e-7), (1e-5, 1e-9)] {
        let mut there = pairs;
        there.go(&step, h);
        for (here, there) in pairs.products().zip(there.products()) {
            let wanted = here + h * (goal - here);
            assert!((there - wanted).abs() < bound, "{there} {wanted}");
        }
    }
    // It reaches the first gap or multiplier that vanishes.
    let far = pairs.step(&vector![-7.0, 0.0, 0.0, 0.0], &[[0.0; 2]; 4]);
    let reach = pairs.reach(&far, 4.0);
    let mut there = pairs;
    there.go(&far, reach * 0.999_999);
    assert!(there.products().all(|product| product > 0.0));
    assert!(reach < 1.0);
}
