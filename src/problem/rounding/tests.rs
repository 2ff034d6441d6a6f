//! The cheap bounds against the sums that they bound.
#![allow(clippy::expect_used)]

use super::{bound, count};
use crate::problem::Problem;
use crate::problem::dynamics;
use crate::{Contact, Factor, Model, Scene};
use nalgebra::{SMatrix, SVector};
use proptest::array::{uniform2, uniform4};
use proptest::prelude::*;

const N: usize = 4;
const D: usize = 3;

fn numbers() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), -1.0..1.0, -1e3..1e3, -1e-3..1e-3]
}

proptest! {
    #[test]
    fn no_sum_is_larger_than_its_bound(
        root in uniform4(uniform4(-1.0..1.0)),
        masses in uniform4(-3_i32..4),
        jacobians in uniform2(uniform4([numbers(), numbers(), numbers()])),
        offset in numbers(),
        (f, v) in (uniform4(numbers()), uniform4(numbers())),
        r in uniform2([numbers(), numbers(), numbers()]),
    ) {
        let root = SMatrix::<f64, N, N>::from(root) + SMatrix::identity();
        let units = SMatrix::from_diagonal(&SVector::from(masses.map(|e| 10_f64.powi(e))));
        let mass = units * (root * root.transpose() + SMatrix::identity() * 1e-3) * units;
        let mut scene = Scene::<f64, N, D, 2>::new();
        scene.set_mass(&((mass + mass.transpose()) * 0.5)).expect("positive definite");
        for columns in jacobians {
            let (jacobian, offset) = (SMatrix::from(columns), SVector::repeat(offset));
            scene.push(&Contact { jacobian, offset, mu: 0.5, key: 0 }).expect("room for two");
        }
        let factor = Factor::new(&scene).expect("positive definite");
        let push = SVector::from(f);
        let mut problem = Problem::new(&scene, &factor, &push, Model::Coulomb);
        problem.fill();
        let mut u = [[0.0; D]; 2];
        let momentum = dynamics::momentum(&scene, &f, &v, &r, &mut u);
        let cheap = bound(&problem, &v, &r, &momentum);
        let sums = count(&problem, &v, &r, &momentum);
        let more = 1.0 + 1e-9;
        prop_assert!(sums.momentum <= cheap.momentum * more);
        for (sum, cheap) in sums.velocities.iter().zip(cheap.velocities) {
            prop_assert!(*sum <= cheap * more);
        }
    }
}

#[test]
fn velocities_of_which_squares_vanish_are_bounded() {
    let mut scene = Scene::<f32, 2, 1, 1>::new();
    let mass = SMatrix::from([[1e-10, 0.999e-10], [0.999e-10, 1e-10]]);
    scene.set_mass(&mass).expect("positive definite");
    let factor = Factor::new(&scene).expect("positive definite");
    let v = [1e-18_f32, -1e-18];
    let f = mass * SVector::from(v);
    let mut problem = Problem::new(&scene, &factor, &f, Model::Coulomb);
    problem.fill();
    let [f] = f.data.0;
    let momentum = dynamics::momentum(&scene, &f, &v, &[], &mut []);
    let cheap = bound(&problem, &v, &[], &momentum);
    let sums = count(&problem, &v, &[], &momentum);
    assert!(sums.momentum > 0.0 && sums.momentum <= cheap.momentum);
}
