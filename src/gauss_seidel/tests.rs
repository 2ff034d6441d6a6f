//! One contact: the shortcut where it sticks against the way that it is short for, and the law where it slides.

use super::{hold, push};
use crate::contact_space::{inverse, product};
use nalgebra::Matrix3;
use proptest::array::{uniform3, uniform9};
use proptest::prelude::*;

proptest! {
    #[test]
    fn a_contact_holds_where_it_would_be_pushed_to_stick(
        entries in uniform9(-1.0_f64..1.0),
        free in uniform3(-1.0_f64..1.0),
        old in uniform3(-1.0_f64..1.0),
        mu in 0.0_f64..3.0,
    ) {
        let root = Matrix3::from_row_slice(&entries);
        let own = (root * root.transpose() + Matrix3::identity() * 0.3).data.0;
        let mut u = free;
        for (u, row) in u.iter_mut().zip(&own) {
            *u += product(row, &old);
        }
        let held = hold(&own, &inverse(&own), &u, &old, mu);
        let mut drag = 0.0;
        let pushed = push(&own, &free, mu, &mut drag);
        // A contact that slides has a `λ`.
        let sticks = pushed.filter(|r| drag == 0.0 && r[1..] != [0.0; 2]);
        prop_assert_eq!(held.is_some(), sticks.is_some());
        for (held, pushed) in held.iter().flatten().zip(sticks.iter().flatten()) {
            prop_assert!((held - pushed).abs() <= 1e-12, "{held} {pushed}");
        }
    }
}

proptest! {
    #[test]
    fn a_contact_that_slides_lies_on_its_cone_and_opposes_its_velocity(
        entries in uniform9(-1.0_f64..1.0),
        free in uniform3(-1.0_f64..1.0),
        mu in 0.01_f64..3.0,
    ) {
        let root = Matrix3::from_row_slice(&entries);
        let own = (root * root.transpose() + Matrix3::identity() * 0.3).data.0;
        let size = free.iter().fold(0.0_f64, |size, u| size.max(u.abs()));
        let mut drag = 0.0;
        // A first guess may be far off; from the fifth step on nothing is left to be found.
        for exact in [1e9, 1e9, 1e9, 1e9, 1e-9, 1e-9] {
            let r = push(&own, &free, mu, &mut drag);
            // What sticks has no `λ`, and what is wedged no tangential impulse.
            let Some(r) = r.filter(|r| drag != 0.0 && r[1..] != [0.0; 2]) else {
                continue;
            };
            let mut u = free;
            for (u, row) in u.iter_mut().zip(&own) {
                *u += product(row, &r);
            }
            let friction = mu * r[0];
            prop_assert!((r[1].hypot(r[2]) - friction).abs() <= 1e-9 * friction, "{r:?}");
            prop_assert!(u[0].abs() <= exact * size, "{u:?}");
            prop_assert!((u[1] * r[2] - u[2] * r[1]).abs() <= exact * size * friction, "{u:?} {r:?}");
            prop_assert!(u[1] * r[1] + u[2] * r[2] <= exact * size * friction, "{u:?} {r:?}");
        }
    }
}
