//! The bounds against what rounding has done.
#![allow(clippy::expect_used)]

use crate::linalg::stacked::Stacked;
use crate::problem::judge::rounding::Rounding;
use crate::problem::{Age, Problem};
use crate::{Contact, Factor, Scene, Settings};
use nalgebra::{SMatrix, SVector};
use proptest::array::{uniform2, uniform4};
use proptest::prelude::*;

const N: usize = 4;
const D: usize = 3;

fn numbers() -> impl Strategy<Value = f32> {
    prop_oneof![Just(0.0_f32), -1.0..1.0_f32, -1e3..1e3_f32, -1e-3..1e-3_f32]
}

proptest! {
    #[test]
    fn no_sum_is_off_by_more_than_its_bound(
        root in uniform4(uniform4(-1.0..1.0_f32)),
        masses in uniform4(-3_i32..4),
        jacobians in uniform2(uniform4([numbers(), numbers(), numbers()])),
        offset in numbers(),
        (f, v) in (uniform4(numbers()), uniform4(numbers())),
        r in uniform2([numbers(), numbers(), numbers()]),
    ) {
        let root = SMatrix::<f32, N, N>::from(root) + SMatrix::identity();
        let units = SMatrix::from_diagonal(&SVector::from(masses.map(|e| 10_f32.powi(e))));
        let mass = units * (root * root.transpose() + SMatrix::identity() * 1e-2) * units;
        let mass = (mass + mass.transpose()) * 0.5;
        let mut scene = Scene::<f32, N, D, 2>::new();
        scene.set_mass(&mass).expect("symmetric");
        for columns in jacobians {
            let (jacobian, offset) = (SMatrix::from(columns), SVector::repeat(offset));
            scene.push(&Contact { jacobian, offset, mu: 0.5, key: 0 }).expect("room for two");
        }
        let factor = Factor::new(&scene);
        prop_assume!(factor.is_ok());
        let factor = factor.expect("positive definite");
        let push = SVector::from(f);
        let mut problem = Problem::new(&scene, &factor, &push, &Settings::default(), Age::New);
        problem.fill(true);
        // In f64 no product is rounded, and sums hardly.
        let [wide_v, wide_f] = [v, f].map(|x| SVector::from(x.map(f64::from)));
        let mut gap = mass.map(f64::from) * wide_v - wide_f;
        let mut exact = [[0.0; D]; 2];
        for ((columns, r), exact) in jacobians.iter().zip(r).zip(&mut exact) {
            let jacobian = SMatrix::<f32, D, N>::from(*columns).map(f64::from);
            gap -= jacobian.transpose() * SVector::from(r.map(f64::from));
            *exact = (jacobian * wide_v).add_scalar(f64::from(offset)).into();
        }
        let r = Stacked { contacts: r, rows: [] };
        let mut u = Stacked::zero();
        let mut sizes = u;
        scene.velocities_and_sizes(&v, &mut u, &mut sizes);
        let (mut dynamics, mut bounds) = (scene.dynamics(&f, &v, &r), Rounding::unset());
        problem.velocity_rounding(&r, &sizes, &mut bounds.velocities);
        problem.momentum_rounding(&mut dynamics, &mut bounds);
        for _ in 0..2 {
            let pairs = u.contacts.iter().zip(&exact);
            for ((u, exact), bound) in pairs.zip(bounds.velocities.contacts) {
                let off = SVector::from(u.map(f64::from)) - SVector::from(*exact);
                let [all, normal] = bound.map(|bound| f64::from(bound).sqrt() * (1.0 + 1e-5));
                prop_assert!(off.norm() <= all && off.x.abs() <= normal);
            }
            let unit = f64::from(dynamics.plain.unit);
            let off = (f64::from(dynamics.plain.residual()).sqrt() - unit * gap.norm()).abs();
            prop_assert!(off <= f64::from(bounds.momentum).sqrt() + 1e-6 * unit * gap.norm());
            let sums = (&mut u, &mut dynamics);
            problem.sum_exactly(&v, &r, sums, &mut bounds);
        }
    }
}

#[test]
fn momenta_of_which_squares_vanish_are_bounded() {
    let mut scene = Scene::<f32, 2, 1, 1>::new();
    let mass = SMatrix::from([[1e-10, 0.999e-10], [0.999e-10, 1e-10]]);
    scene.set_mass(&mass).expect("symmetric");
    let factor = Factor::new(&scene).expect("positive definite");
    let v = [1e-18_f32, -1e-18];
    let f = mass * SVector::from(v);
    let mut problem = Problem::new(&scene, &factor, &f, &Settings::default(), Age::New);
    problem.fill(true);
    let [f] = f.data.0;
    let (mut dynamics, mut bounds) = (scene.dynamics(&f, &v, &Stacked::zero()), Rounding::unset());
    problem.momentum_rounding(&mut dynamics, &mut bounds);
    assert!(bounds.momentum > 0.0);
}
