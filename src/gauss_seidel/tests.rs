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
