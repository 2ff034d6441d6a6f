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

    #[test]
    fn a_free_contact_errs_by_its_approach_at_most(velocity in uniform3(-1.0..1.0)) {
        let found = error(&[contact(velocity)], 1.0, &[velocity], &[[0.0; 3]], &[], &|| 0.0);
        prop_assert!(found <= (-velocity[0]).max(0.0) + 1e-15, "{found}");
    }
}

/// A contact under Coulomb's law, `mu` = 0.5 and `alpha` = 1 kg.
fn contact(q: [f64; 3]) -> ContactSet<f64, 3> {
    ContactSet {
        shift_factor: 0.5,
        cone: FrictionCone::new(0.5).expect("mu is not negative"),
        alpha: 1.0,
        q: SVector::from(q),
        base: SVector::zeros(),
    }
}

/// A contact that parts faster than rounding can hide has no error; one that may touch has all of it.
#[test]
fn rounding_of_a_far_gap_counts_for_nothing() {
    let set = contact([100.0, 1.0, 0.0]);
    let of = |gap: f64, noise: f64| {
        error(&[set], 1.0, &[[gap, 1.0, 0.0]], &[[0.0; 3]], &[[noise * noise; 2]], &|| 0.0)
    };
    assert!(of(100.0, 1e-3) == 0.0);
    assert!(of(1e-4, 1e-3) >= 1e-3);
}

/// Without an impulse the tangents of a contact may have any velocity: their rounding is no error, that of the normal is.
#[test]
fn rounding_along_a_free_contact_counts_for_nothing() {
    let set = contact([0.0, 1.0, 0.0]);
    let of = |normal: f64| {
        error(
            &[set],
            1.0,
            &[[0.0, 1.0, 0.0]],
            &[[0.0; 3]],
            &[[1e-6 + normal * normal, normal * normal]],
            &|| 0.0,
        )
    };
    assert!(of(0.0) == 0.0);
    assert!(of(1e-4) >= 1e-4 && of(1e-4) < 2e-4);
}
