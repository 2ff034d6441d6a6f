//! The shortcut for a contact that sticks, against the way that it is short for.

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
        let mut drag = 0.0;
        let mut end = None;
        for _ in 0..5 {
            // From the last `λ` on, and in one go as near as the first way is long.
            end = push(&own, &free, mu, &mut drag);
            if let Some([normal, tangents @ ..]) = end.filter(|_| drag != 0.0) {
                let [x, y] = tangents;
                prop_assert!((x.hypot(y) - mu * normal).abs() <= 1e-9 * mu * normal, "{x} {y} {normal}");
            }
        }
        if let Some(r) = end.filter(|_| drag != 0.0) {
            let mut u = free;
            for (u, row) in u.iter_mut().zip(&own) {
                *u += product(row, &r);
            }
            let speed = u[1].hypot(u[2]);
            let size = free.iter().fold(0.0_f64, |size, u| size.max(u.abs()));
            prop_assert!(u[0].abs() <= 1e-9 * size, "{u:?}");
            prop_assert!(u[1] * r[1] + u[2] * r[2] <= -(1.0 - 1e-9) * speed * mu * r[0] + 1e-9 * size * r[0], "{u:?} {r:?}");
        }
    }
}
