//! Pairs on and off the central path, and that a step does what it is told.
#![allow(clippy::indexing_slicing, clippy::expect_used)]

extern crate std;

use super::direction::System;
use super::pair::{Pair, Part, Scaling, widen};
use crate::laws::Room;
use crate::linalg::elimination::Elimination;
use crate::problem::{ContactLaw, Problem};
use crate::{Contact, Error, Factor, FrictionCone, Model, Real, Scene};
use core::array::from_fn;
use nalgebra::{SMatrix, SVector, vector};
use std::vec::Vec;

const N: usize = 7;
const C: usize = 3;

/// Numbers between -1 and 1, always the same.
fn numbers() -> impl Iterator<Item = f64> {
    let mut state = 1_u32;
    core::iter::repeat_with(move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state) / f64::from(1_u32 << 31) - 1.0
    })
}

fn law<T: Real>(mu: f64, is_coulomb: bool) -> ContactLaw<T, 3> {
    let mu = T::literal(mu);
    ContactLaw {
        shift_factor: if is_coulomb { mu } else { T::ZERO },
        cone: FrictionCone::new(mu).expect("mu"),
        alpha: T::literal(0.7),
        q: SVector::zeros(),
        base: SVector::zeros(),
        rows: Room::EMPTY,
    }
}

/// `x_N² - |x_T|²`
fn det<T: Real>(x: &SVector<T, 3>) -> T {
    x[0] * x[0] - x[1] * x[1] - x[2] * x[2]
}

#[test]
fn a_pair_is_entered_on_the_path() {
    let mut numbers = numbers();
    for (mu, is_coulomb) in [(0.5, true), (10.0, true), (0.5, false), (0.0, true)] {
        let law = law(mu, is_coulomb);
        for gain in [0.1, 1.0, 30.0] {
            let [r, u] = [(); 2].map(|()| SVector::from_fn(|_, _| numbers.next().unwrap_or(0.0)));
            let pair = Pair::centred(&law, &r, &u, 1e-4, gain, 3.0);
            for product in pair.products(3.0).into_iter().flatten() {
                assert!((product - 1e-4).abs() < 1e-12, "{product}");
            }
            if pair.part.is_cone::<3>() {
                assert!(pair.x[0] > 0.0 && det(&pair.x) > 0.0);
                let across = pair.w * pair.x[0] + pair.x * pair.w[0];
                assert!(across.fixed_rows::<2>(1).norm() < 1e-12);
            }
        }
    }
    let held = ContactLaw {
        alpha: 0.0,
        ..law::<f64>(0.5, true)
    };
    assert_eq!(Part::of(&held), Part::Nothing);
}

#[test]
fn the_scaling_takes_one_of_a_pair_to_the_other() {
    let pair = Pair::<f64, 3> {
        part: Part::Coulomb,
        x: vector![2.0, -1.0, 1.5],
        w: vector![0.3, 0.1, 0.25],
        normal: 0.2,
        rows: Room::EMPTY,
    };
    let scaling = Scaling::<f64, 3>::of(&pair);
    assert!((scaling.compliance(&pair.x) - pair.w).norm() < 1e-12);
    // A step of nothing to where it is
    let still = Pair::none();
    let goal = scaling.corrected(&pair, &still, 0.0);
    assert!((goal + pair.w).norm() < 1e-12);
    let rows: [f64; 2] = [1, 2].map(|k| scaling.row(&pair, k)[3 - k]);
    assert!((rows[0] - rows[1]).abs() < 1e-12);
}

/// Up to the boundary, in both number types, and not out of it by rounding.
#[test]
fn a_pair_stays_inside() {
    fn check<T: Real>() {
        let mut numbers = numbers();
        for part in [Part::Coulomb, Part::Cone, Part::Normal] {
            let (one, tenth) = (T::ONE, T::literal(0.1));
            let first = Pair::<T, 3> {
                part,
                x: vector![one, T::ZERO, tenth],
                w: vector![one, tenth, T::ZERO],
                normal: one,
                rows: Room::EMPTY,
            };
            let mut pair = first;
            for k in 0..400 {
                if k % 8 == 0 {
                    pair = first;
                }
                let mut next = || T::literal(numbers.next().unwrap_or(0.0));
                let step = Pair {
                    part,
                    x: SVector::from_fn(|_, _| next()) * pair.x[0],
                    w: SVector::from_fn(|_, _| next()) * pair.w[0],
                    normal: next() * pair.normal,
                    rows: Room::EMPTY,
                };
                let reach = pair.reach(&step, T::literal(4.0));
                let mut there = pair;
                there.go(&step, reach * T::literal(0.999));
                assert!(there.x[0] > T::ZERO);
                if part != Part::Cone {
                    assert!(there.normal > T::ZERO);
                }
                if part.is_cone::<3>() {
                    assert!(det(&there.x) > T::ZERO && det(&there.w) > T::ZERO);
                }
                pair = there;
            }
        }
    }
    check::<f32>();
    check::<f64>();
}

fn scene<const D: usize>(mus: [f64; C]) -> Result<Scene<f64, N, D, C>, Error> {
    let mut numbers = numbers();
    let mut scene = Scene::new();
    scene.set_mass(&SMatrix::identity())?;
    for mu in mus {
        scene.push(&Contact {
            jacobian: SMatrix::from_fn(|_, _| numbers.next().unwrap_or(0.0)),
            offset: SVector::zeros(),
            mu,
            key: 0,
        })?;
    }
    Ok(scene)
}

/// The derivative of each product along a step is what was asked for, and velocities go on to follow from impulses.
fn check<const D: usize>(mus: [f64; C], model: Model) -> Result<(), Error> {
    let scene = scene::<D>(mus)?;
    let factor = Factor::new(&scene)?;
    let f = SVector::from_iterator(numbers().take(N));
    let mut problem = Problem::new(&scene, &factor, &f, model);
    problem.fill(true);
    let laws = problem.laws();
    let (tau, beta) = (0.1, 3.0);
    let pairs: [Pair<f64, D>; C] =
        from_fn(|i| Pair::centred(&laws[i], &SVector::zeros(), &laws[i].q, tau, 2.0, beta));
    let velocities = |step: &[Pair<f64, D>; C], length: f64| {
        let r = from_fn(|i| widen(&laws[i], &(pairs[i].x + step[i].x * length)).into());
        let mut u = [[0.0; D]; C];
        problem.natural_map(&r, &mut u);
        u
    };
    let still = [const { Pair::none() }; C];
    let (mut matrix, mut elimination) = ([[[[0.0; D]; C]; D]; C], Elimination::none());
    let u = velocities(&still, 0.0);
    let system = System::new(&problem, &pairs, &u, &mut matrix, &mut elimination);
    let system = system.expect("a regular matrix");
    let step = system.correct(&still, 0.01, beta).expect("a step");
    let there = velocities(&step, 1.0);
    for (i, (pair, step)) in pairs.iter().zip(&step).enumerate() {
        let at = |h: f64| {
            let mut moved = *pair;
            moved.go(step, h);
            moved.products(beta)
        };
        let [here, ahead, behind] = [0.0, 1e-4, -1e-4].map(at);
        let slopes = ahead.iter().zip(&behind).zip(&here);
        for ((ahead, behind), here) in
            slopes.filter_map(|((a, b), h)| Some((((*a)?, (*b)?), (*h)?)))
        {
            let slope = (ahead - behind) / 2e-4;
            assert!((slope - (0.01 - here)).abs() < 1e-7, "{D} rows: {slope}");
        }
        let wide = widen(&laws[i], &there[i].into());
        let mut follows = pair.w + step.w;
        if pair.part != Part::Cone {
            follows[0] = pair.normal + step.normal;
        }
        let rows = pair.part.count::<D>();
        let gaps: Vec<f64> = (0..rows).map(|k| (follows[k] - wide[k]).abs()).collect();
        assert!(gaps.iter().all(|&gap| gap < 1e-10), "{D} rows: {gaps:?}");
    }
    Ok(())
}

#[test]
fn a_step_does_what_it_is_told() -> Result<(), Error> {
    for model in [Model::Coulomb, Model::ConvexRelaxation] {
        for mus in [[0.5, 0.3, 1.0], [0.0, 10.0, 0.2], [0.0; C]] {
            check::<1>(mus, model)?;
            check::<2>(mus, model)?;
            check::<3>(mus, model)?;
            check::<4>(mus, model)?;
        }
    }
    Ok(())
}
