//! One contact: it obeys the convex relaxation whether it opens, sticks or slides.

extern crate std;

use super::solve_local;
use crate::FrictionCone;
use crate::linalg::blocks::{inverse, product};
use crate::sets::ContactSet;
use crate::sets::contact::local::Local;
use nalgebra::{SMatrix, SVector};
use proptest::collection::vec;
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Reason, TestRunner};
use std::vec::Vec;

/// How far off `K ∋ r ⟂ u ∈ K*` is, relative to the velocity that the others leave.
fn complementarity<const D: usize>(own: &[[f64; D]; D], free: &[f64; D], mu: f64, r: &[f64; D]) -> f64 {
    let mut u = *free;
    for (u, row) in u.iter_mut().zip(own) {
        *u += product(row, r);
    }
    let tangential = |x: &[f64; D]| x[1..].iter().map(|x| x * x).sum::<f64>().sqrt();
    let largest = |x: &[f64; D]| x.iter().fold(f64::MIN_POSITIVE, |size, x| size.max(x.abs()));
    let (force, size) = (largest(r), largest(free));
    let outside = (tangential(r) - mu * r[0]).max(-r[0]) / force;
    let penetrates = (mu * tangential(&u) - u[0]).max(-u[0]) / size;
    let work = product(&u, r) / (size * force);
    outside.max(penetrates).max(work.abs())
}

/// What becomes of random contacts in forty sweeps over each alone: none off the law by more than 1e-9. How many open, stick and slide.
fn modes<const D: usize>(count: usize) -> Result<[usize; 3], Reason> {
    let mut runner = TestRunner::deterministic();
    let contacts = (vec(-1.0_f64..1.0, D * D), vec(-1.0_f64..1.0, D), 0.0_f64..3.0);
    let mut modes = [0; 3];
    for _ in 0..count {
        let (entries, free, mu): (Vec<f64>, Vec<f64>, f64) = contacts.new_tree(&mut runner)?.current();
        let root = SMatrix::<f64, D, D>::from_row_slice(&entries);
        let own = (root * root.transpose() + SMatrix::identity() * 0.3).data.0;
        let free = SVector::<f64, D>::from_row_slice(&free);
        let set = ContactSet { cone: FrictionCone::new(mu).ok_or("a cone")?, ..ContactSet::none() };
        let (mass, mut r, mut u) = (inverse(&own), [0.0; D], free.data.0[0]);
        for _ in 0..40 {
            r = solve_local(&Local { set: &set, block: own, mass: &mass, u, r });
            u = free.data.0[0];
            for (u, row) in u.iter_mut().zip(&own) {
                *u += product(row, &r);
            }
        }
        let error = complementarity(&own, &free.data.0[0], mu, &r);
        assert!(error <= 1e-9, "{error:e}: mu {mu}, {own:?}, {free:?}, {r:?}");
        let [open, sticks, slides] = &mut modes;
        *match r[0] {
            0.0 => open,
            _ if product(&u, &u) < 1e-18 => sticks,
            _ => slides,
        } += 1;
    }
    Ok(modes)
}

#[test]
fn a_contact_obeys_the_convex_relaxation() -> Result<(), Reason> {
    for modes in [modes::<2>(4000)?, modes::<3>(4000)?] {
        assert!(modes.iter().all(|&count| count > 20), "{modes:?}");
    }
    Ok(())
}
