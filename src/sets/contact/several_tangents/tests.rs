//! One contact with torsional and rolling friction obeys the law.
#![allow(clippy::indexing_slicing)]

use super::push;
use nalgebra::{SMatrix, SVector};
use proptest::collection::vec;
use proptest::prelude::*;

/// `r` in the cone, `û` in its dual, the two orthogonal: how far off that is, relative to velocities of this size.
fn complementarity<const D: usize>(
    own: &SMatrix<f64, D, D>,
    free: &SVector<f64, D>,
    mu: f64,
    r: &SVector<f64, D>,
) -> f64 {
    let mut u = own * r + free;
    let slip = u.rows(1, D - 1).norm();
    u[0] += mu * slip;
    let outside = (r.rows(1, D - 1).norm() - mu * r[0]).max(0.0) / r[0];
    let parting = (mu * u.rows(1, D - 1).norm() - u[0]).max(0.0) / free.norm();
    outside.max(parting).max(u.dot(r).abs() / (free.norm() * r.norm()))
}

/// Blocks whose rows are spread over orders of magnitude, as lengths make them.
fn check<const D: usize>(entries: &[f64], free: &[f64], mu: f64) -> Result<(), TestCaseError> {
    let root = SMatrix::<f64, D, D>::from_row_slice(&entries[..D * D]);
    let mut scales = SVector::<f64, D>::from_element(1.0);
    for (k, scale) in scales.iter_mut().enumerate().skip(3) {
        *scale = if k == 3 { 0.02 } else { 0.005 };
    }
    let scales = SMatrix::from_diagonal(&scales);
    let own = scales * (root * root.transpose() * 0.1 + SMatrix::identity()) * scales;
    let mut free = scales * SVector::<f64, D>::from_row_slice(&free[..D]);
    free[0] = -free[0].abs() - 0.05;
    let mut lambda = 0.0;
    let (blocks, given) = (own.data.0, free.data.0[0]);
    // A second call goes on where the first one ended.
    let first = push(&blocks, &given, mu, &mut lambda);
    let impulse = first.and_then(|_| push(&blocks, &given, mu, &mut lambda));
    let impulse = SVector::from(impulse.ok_or_else(|| TestCaseError::fail("no impulse"))?);
    let off = complementarity(&own, &free, mu, &impulse);
    prop_assert!(off < 1e-3, "{off}, {impulse}");
    Ok(())
}

proptest! {
    #[test]
    fn a_contact_with_spin_and_roll_obeys_the_law(
        entries in vec(-1.0_f64..1.0, 36),
        free in vec(-1.0_f64..1.0, 6),
        mu in 0.05_f64..1.0,
    ) {
        check::<4>(&entries, &free, mu)?;
        check::<6>(&entries, &free, mu)?;
    }
}
