//! One contact: the shortcut where it sticks against the way that it is short for, and the law where it slides.

use super::{push, stick};
use crate::linalg::blocks::{inverse, product};
use crate::sets::ContactSet;
use crate::sets::contact::local::Local;
use nalgebra::Matrix3;
use proptest::array::{uniform3, uniform9};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Reason, TestRunner};

proptest! {
    #[test]
    fn a_contact_holds_where_it_would_be_pushed_to_stick(
        entries in uniform9(-1.0_f64..1.0),
        free in uniform3(-1.0_f64..1.0),
        old in uniform3(-1.0_f64..1.0),
        mu in 0.0_f64..3.0,
    ) {
        let root = Matrix3::from_row_slice(&entries);
        let block = (root * root.transpose() + Matrix3::identity() * 0.3).data.0;
        let mut u = free;
        for (u, row) in u.iter_mut().zip(&block) {
            *u += product(row, &old);
        }
        let local = Local {
            set: &ContactSet::none(),
            block,
            mass: &inverse(&block),
            u,
            r: old,
        };
        let held = stick(&local, mu);
        let mut lambda = 0.0;
        let pushed = push(&block, &free, mu, &mut lambda);
        // A contact that slides has a `λ`.
        let sticks = pushed.filter(|r| lambda == 0.0 && r[1..] != [0.0; 2]);
        prop_assert_eq!(held.is_some(), sticks.is_some());
        for (held, pushed) in held.iter().flatten().zip(sticks.iter().flatten()) {
            prop_assert!((held - pushed).abs() <= 1e-12, "{held} {pushed}");
        }
    }
}

/// `r` in the cone, `û` in its dual, the two orthogonal: how far off that is, relative to velocities of this size.
fn complementarity(own: &[[f64; 3]; 3], free: &[f64; 3], mu: f64, r: &[f64; 3]) -> f64 {
    let mut u = *free;
    for (u, row) in u.iter_mut().zip(own) {
        *u += product(row, r);
    }
    let shifted = u[0] + mu * u[1].hypot(u[2]);
    let size = free.iter().fold(0.0_f64, |size, u| size.max(u.abs()));
    let force = r.iter().fold(f64::MIN_POSITIVE, |size, r| size.max(r.abs()));
    let outside = (r[1].hypot(r[2]) - mu * r[0]).max(-r[0]) / force;
    let penetration = -u[0] / size;
    let work = (shifted * r[0] + u[1] * r[1] + u[2] * r[2]) / (size * force);
    outside.max(penetration).max(work.abs())
}

/// From the fifth call on nothing of `λ` is left to be found. None of these contacts is so coupled that it wedges.
#[test]
fn a_contact_obeys_the_law_whether_it_opens_sticks_or_slides() -> Result<(), Reason> {
    let mut runner = TestRunner::deterministic();
    let contacts = (uniform9(-1.0_f64..1.0), uniform3(-1.0_f64..1.0), 0.01_f64..3.0);
    let [mut open, mut sticks, mut slides] = [0; 3];
    for _ in 0..10_000 {
        let tree = contacts.new_tree(&mut runner)?;
        let (entries, free, mu) = tree.current();
        let root = Matrix3::from_row_slice(&entries);
        let own = (root * root.transpose() + Matrix3::identity() * 0.3).data.0;
        let (mut lambda, mut impulse) = (0.0, None);
        for _ in 0..6 {
            impulse = push(&own, &free, mu, &mut lambda);
        }
        let Some(r) = impulse else {
            open += 1;
            assert!(free[0] >= 0.0, "{free:?}");
            continue;
        };
        assert!(free[0] < 0.0 && r[0] > 0.0, "{free:?}, {r:?}");
        *(if lambda == 0.0 { &mut sticks } else { &mut slides }) += 1;
        let error = complementarity(&own, &free, mu, &r);
        assert!(error <= 1e-9, "{error:e}: mu {mu}, {own:?}, {free:?}, {r:?}");
    }
    assert!(open.min(sticks).min(slides) > 1_900, "{open}, {sticks}, {slides}");
    Ok(())
}
