//! The leak of a proof where rounding is magnified.
#![allow(clippy::expect_used, clippy::indexing_slicing)]

use crate::linalg::stacked::Stacked;
use crate::problem::{Age, Problem};
use crate::{Contact, Factor, Scene, Settings};
use nalgebra::{matrix, vector};
use proptest::array::uniform2;
use proptest::prelude::*;

proptest! {
    /// Two walls that are all but opposite. What remains of their impulses moves the two velocities against each other, which takes hardly any
    /// mass: the norm of `M⁻¹` makes it large.
    #[test]
    fn a_leak_is_that_of_the_scene_where_the_mass_is_nearly_singular(
        exponent in 7..16_i32,
        wall in uniform2(0.5_f32..1.0),
        tilts in uniform2(0..8_i16),
        d in uniform2(0.999_f32..1.0),
    ) {
        let soft = 2_f32.powi(-exponent);
        let tilted = |k: usize| -wall[k] * (1.0 + f32::from(tilts[k]) * f32::EPSILON);
        let walls = [wall, [tilted(0), tilted(1)]];
        let mut scene = Scene::<f32, 2, 1, 2>::new();
        scene.set_mass(&matrix![1.0, 1.0 - soft; 1.0 - soft, 1.0]).expect("symmetric");
        for [x, y] in walls {
            let jacobian = matrix![x, y];
            scene.push(&Contact { jacobian, offset: vector![-0.1], mu: 0.0, key: 0 }).expect("of numbers");
        }
        let factor = Factor::new(&scene).expect("positive definite");
        let push = vector![0.0, 0.0];
        let problem = Problem::new(&scene, &factor, &push, &Settings::default(), Age::New);
        let leak = f64::from(problem.leak(&Stacked { contacts: d.map(|d| [d]), rows: [] }));

        let sum = |k: usize| (0..2).map(|i| f64::from(walls[i][k]) * f64::from(d[i])).sum::<f64>();
        let (x, y, coupling) = (sum(0), sum(1), 1.0 - f64::from(soft));
        let square = (x * x - 2.0 * coupling * x * y + y * y) / (1.0 - coupling * coupling);
        prop_assert!((leak - square.sqrt()).abs() <= 0.01 * square.sqrt(), "{leak:e} {:e}", square.sqrt());
    }
}
