//! The error of the dynamics in any unit.
#![allow(clippy::expect_used)]

use crate::Scene;
use crate::linalg::stacked::Stacked;
use nalgebra::SMatrix;
use proptest::array::uniform3;
use proptest::prelude::*;

proptest! {
    /// Where squares overflow or vanish a unit is found in which they do not.
    #[test]
    fn the_error_of_the_dynamics_has_no_unit(
        mass in uniform3(uniform3(-1.0_f32..1.0)),
        (f, v) in (uniform3(-1.0_f32..1.0), uniform3(-1.0_f32..1.0)),
        exponent in -90..90,
    ) {
        let scaled = |x: [f32; 3]| x.map(|x| x * 2_f32.powi(exponent));
        let (mut scene, half) = (Scene::<_, 3, 1, 1>::new(), SMatrix::<f32, 3, 3>::from(mass));
        scene.set_mass(&(half + half.transpose())).expect("symmetric");
        let r = Stacked::zero();
        let dynamics = |f, v| scene.dynamics(&f, &v, &r);
        let error = |f, v| dynamics(f, v).plain.error(0.0);
        prop_assert_eq!(error(f, v).to_bits(), error(scaled(f), scaled(v)).to_bits());
    }
}
