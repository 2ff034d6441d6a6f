//! The bounds without sums against what rounding has done, and against the bounds of the sums.
#![allow(clippy::expect_used)]

use crate::linalg::stacked::Stacked;
use crate::problem::judge::rounding::Rounding;
use crate::problem::{Age, Problem};
use crate::real::Real;
use crate::{Contact, Factor, JointRow, RowLaw, Scene, Settings};
use nalgebra::{SMatrix, SVector};
use proptest::array::{uniform2, uniform3, uniform4};
use proptest::prelude::*;

const N: usize = 4;
const D: usize = 3;

/// The impulses of two contacts and a joint row.
type Impulses<T> = Stacked<T, D, 2, 1>;

fn numbers() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), -1.0..1.0_f64, -1e3..1e3_f64, -1e-3..1e-3_f64]
}

/// A scene of two contacts, and of a joint row if `is_mixed`.
fn scene<T: Real>(
    root: [[f64; N]; N],
    masses: [i32; N],
    (jacobians, offset): ([[[f64; D]; N]; 2], f64),
    is_mixed: bool,
) -> Scene<T, N, D, 2, 1> {
    let root = SMatrix::<f64, N, N>::from(root) + SMatrix::identity();
    let units = SMatrix::from_diagonal(&SVector::from(masses.map(|e| 10_f64.powi(e))));
    let mass = units * (root * root.transpose() + SMatrix::identity() * 1e-2) * units;
    let mut scene = Scene::new();
    scene.set_mass(&((mass + mass.transpose()) * 0.5).map(T::literal)).expect("symmetric");
    for columns in jacobians {
        let jacobian = SMatrix::<f64, D, N>::from(columns).map(T::literal);
        let offset = SVector::repeat(T::literal(offset));
        scene.push(&Contact { jacobian, offset, mu: T::literal(0.5), key: 0 }).expect("room for two");
    }
    if is_mixed {
        let row = SVector::from([1.0, -0.5, 0.25, 2.0]).map(T::literal);
        let law = RowLaw::Equality;
        let row = JointRow { row, offset: T::ZERO, compliance: T::ZERO, law, key: 0 };
        scene.push_row(&row).expect("room for one");
    }
    scene
}

proptest! {
    /// In single precision, whose rounding `f64` shows.
    #[test]
    fn no_momentum_is_off_by_more_than_its_bound(
        root in uniform4(uniform4(-1.0..1.0_f64)),
        masses in uniform4(-2_i32..3),
        jacobians in uniform2(uniform4([numbers(), numbers(), numbers()])),
        f in uniform4(numbers()),
        (r, row_r) in (uniform2([numbers(), numbers(), numbers()]), numbers()),
        is_mixed: bool,
    ) {
        let scene = scene::<f32>(root, masses, (jacobians, 0.0), is_mixed);
        let factor = Factor::new(&scene);
        prop_assume!(factor.is_ok());
        let factor = factor.expect("positive definite");
        let push = SVector::from(f).map(f32::literal);
        let mut problem = Problem::new(&scene, &factor, &push, &Settings::default(), Age::New);
        problem.fill(true);
        let row_r = if is_mixed { f32::literal(row_r) } else { 0.0 };
        let r = Impulses { contacts: r.map(|r| r.map(f32::literal)), rows: [row_r] };
        let mut v = [0.0; N];
        factor.velocity(&problem.whitened, &r, &mut v);
        let balance = problem.momentum_balance(&v, &r, 1e3);
        prop_assume!(balance.is_some());
        let [plain, weighted] = balance.expect("far below the tolerance").momentum;
        let wide = |x: f32| f64::from(x);
        let mass = scene.mass().map(wide);
        let mut gap = mass * SVector::from(v.map(wide)) - push.map(wide);
        for (contact, r) in scene.contacts().iter().zip(r.contacts) {
            gap -= contact.jacobian.map(wide).transpose() * SVector::from(r.map(wide));
        }
        for row in scene.rows() {
            gap -= row.row.map(wide) * wide(row_r);
        }
        prop_assert!(gap.norm_squared() <= wide(plain));
        if is_mixed {
            let weights = mass.diagonal().map(f64::recip);
            prop_assert!(gap.component_mul(&gap).dot(&weights) <= wide(weighted));
        }
    }

    #[test]
    fn bounds_from_diagonals_are_above_those_from_magnitudes(
        root in uniform4(uniform4(-1.0..1.0_f64)),
        masses in uniform4(-3_i32..4),
        jacobians in uniform2(uniform4(uniform3(-1e3..1e3_f64))),
        offset in -1e3..1e3_f64,
        (f, v) in (uniform4(-1e3..1e3_f64), uniform4(-1e3..1e3_f64)),
        r in uniform2(uniform3(-1e3..1e3_f64)),
    ) {
        let scene = scene::<f64>(root, masses, (jacobians, offset), false);
        let factor = Factor::new(&scene).expect("positive definite");
        let push = SVector::from(f);
        let mut problem = Problem::new(&scene, &factor, &push, &Settings::default(), Age::New);
        problem.fill(true);
        let r = Impulses { contacts: r, rows: [0.0] };
        let (mut u, mut sizes) = (Stacked::zero(), Stacked::zero());
        scene.velocities_and_sizes(&v, &mut u, &mut sizes);
        let [mut fine, mut crude] = [Rounding::unset(); 2];
        problem.velocity_rounding(&r, &sizes, &mut fine.velocities);
        let balance = problem.momentum_balance(&v, &r, 1.0).expect("far below the tolerance");
        problem.crude_velocity_rounding(balance.moved, &mut crude.velocities);
        let pairs = crude.velocities.contacts.iter().zip(&fine.velocities.contacts);
        for (crude, fine) in pairs {
            prop_assert!(crude.iter().zip(fine).all(|(crude, fine)| crude >= fine));
        }
    }
}

/// A row whose inverse mass counts as rounding leaves no trace in `v`.
#[test]
fn a_dropped_row_is_no_balance() {
    let mut scene = Scene::<f64, 2, 2, 1>::new();
    scene.set_mass(&SMatrix::identity()).expect("symmetric");
    for (tangent, is_kept) in [(1.0, true), (1e-15, false)] {
        let jacobian = SMatrix::from([[0.0, tangent], [1.0, 0.0]]);
        scene.clear_contacts();
        scene.push(&Contact { jacobian, offset: SVector::zeros(), mu: 0.5, key: 0 }).expect("room for one");
        let factor = Factor::new(&scene).expect("positive definite");
        assert_eq!(factor.balances(), is_kept);
    }
}
