//! Shortcuts against what they are short for.
#![allow(clippy::expect_used)]

use super::{error, r0_norm};
use crate::FrictionCone;
use crate::sets::ContactSet;
use nalgebra::SVector;
use proptest::array::{uniform2, uniform3};
use proptest::prelude::*;

proptest! {
    #[test]
    fn the_natural_map_at_rest_is_that_without_impulses(
        velocities in uniform2(uniform3(-1.0..1.0)),
        frictions in uniform2(prop_oneof![Just(0.0), 0.0..2.0]),
        relaxed in any::<bool>(),
    ) {
        let set = |free: [f64; 3], mu: f64| ContactSet::<f64, 3> {
            shift_factor: if relaxed { 0.0 } else { mu },
            cone: FrictionCone::new(mu).expect("mu is not negative"),
            alpha: 0.5,
            q: SVector::from(free),
            base: SVector::zeros(),
        };
        let sets = [set(velocities[0], frictions[0]), set(velocities[1], frictions[1])];
        let (size, rest) = (3.0, [[0.0; 3]; 2]);
        let wanted = error(&sets, size, &velocities, &rest, &[], &|| 0.0);
        let found = r0_norm(&sets) / size;
        prop_assert!((found - wanted).abs() <= 1e-14, "{found} {wanted}");
    }
}

/// A contact that parts faster than rounding can hide has no error; one that may touch has all of it.
#[test]
fn rounding_of_a_far_gap_counts_for_nothing() {
    let set = ContactSet::<f64, 3> {
        shift_factor: 0.5,
        cone: FrictionCone::new(0.5).expect("mu is not negative"),
        alpha: 1.0,
        q: SVector::from([100.0, 1.0, 0.0]),
        base: SVector::zeros(),
    };
    let of = |gap: f64, noise: f64| {
        error(&[set], 1.0, &[[gap, 1.0, 0.0]], &[[0.0; 3]], &[[noise * noise; 2]], &|| 0.0)
    };
    assert!(of(100.0, 1e-3) == 0.0);
    assert!(of(1e-4, 1e-3) >= 1e-3);
}
