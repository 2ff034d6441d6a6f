//! Joint rows on the central path: products, and steps to first order.
#![allow(clippy::indexing_slicing, clippy::float_cmp)]

use super::RowPair;
use crate::sets::RowSet;

const INFINITY: f64 = f64::INFINITY;

/// A limit, an equality, a box, and a box that is none.
fn sets() -> [RowSet<f64>; 4] {
    let bounds = [[0.0, INFINITY], [-INFINITY, INFINITY], [-0.5, 2.0], [0.3, 0.3]];
    bounds.map(|bounds| RowSet::of(bounds, 1.0))
}

/// The rows near these impulses.
fn centred(r: [f64; 4], tau: f64) -> [RowPair<f64>; 4] {
    let (sets, u) = (sets(), [0.4, 0.0, -1.0, 0.0]);
    core::array::from_fn(|j| RowPair::centred(&sets[j], r[j], u[j], tau, 1.0))
}

fn products(pairs: &[RowPair<f64>]) -> impl Iterator<Item = f64> {
    pairs.iter().flat_map(RowPair::products).flatten()
}

#[test]
fn rows_are_centred_between_their_bounds() {
    let pairs = centred([-1.0, 3.0, 5.0, 0.3], 1e-2);
    let r = pairs.map(|pair| pair.impulse);
    assert!(r[0] > 0.0 && (-0.5..2.0).contains(&r[2]));
    assert_eq!((r[1], r[3]), (3.0, 0.3));
    let mut count = 0;
    for product in products(&pairs) {
        assert!((product - 1e-2).abs() < 1e-12, "{product}");
        count += 1;
    }
    assert_eq!(count, 3); // one of the limit, two of the box
    assert!(pairs[0].response(1.0) > 0.0 && pairs[1].response(1.0) < 1e-10);
    // Where the bounds coincide nothing is unknown.
    assert_eq!(pairs.map(|pair| pair.is_free), [true, true, true, false]);
}

#[test]
fn a_step_does_what_it_is_told() {
    let pairs = centred([0.7, 3.0, 0.1, 0.3], 1e-1);
    let goal = 3e-2;
    let moved = [0.01, 0.4, -0.02, 0.0];
    let steps: [_; 4] = core::array::from_fn(|j| pairs[j].step(moved[j], &pairs[j].goals(None, goal)));
    // To first order, products become the goal.
    for (h, bound) in [(1e-4, 1e-7), (1e-5, 1e-9)] {
        let mut there = pairs;
        for ((there, step), (pair, moved)) in there.iter_mut().zip(&steps).zip(pairs.iter().zip(moved)) {
            there.advance(step, h);
            assert_eq!(there.impulse, pair.impulse + moved * h);
        }
        for (here, there) in products(&pairs).zip(products(&there)) {
            let wanted = here + h * (goal - here);
            assert!((there - wanted).abs() < bound, "{there} {wanted}");
        }
    }
    // It reaches the first gap or multiplier that vanishes.
    let far = pairs[0].step(-7.0, &[0.0; 2]);
    let reach = pairs[0].max_step(&far, 4.0);
    let mut there = pairs;
    there[0].advance(&far, reach * 0.999_999);
    assert!(products(&there).all(|product| product > 0.0));
    assert!(reach < 1.0);
}
