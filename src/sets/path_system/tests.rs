//! Pairs on and off the central path, and that a step does what it is told.
#![allow(clippy::indexing_slicing, clippy::expect_used, clippy::float_cmp)]

extern crate std;

use super::{Pairs, PathSystem};
use crate::linalg::elimination::Elimination;
use crate::linalg::stacked::{Stacked, StackedMatrix};
use crate::problem::{Age, Problem};
use crate::sets::ContactSet;
use crate::sets::contact::pair::{Pair, Part, Scaling, widen};
use crate::{Contact, Error, Factor, FrictionCone, JointRow, Model, Real, RowLaw, Scene, Settings, Surface};
use nalgebra::{SMatrix, SVector, vector};
use std::vec::Vec;

// The sizes of the tests of the Jacobian: each costs seconds of a build.
const N: usize = 16;
const C: usize = 3;
const R: usize = 8;

/// Numbers between -1 and 1, always the same.
fn numbers() -> impl Iterator<Item = f64> {
    let mut state = 1_u32;
    core::iter::repeat_with(move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state) / f64::from(1_u32 << 31) - 1.0
    })
}

fn set<T: Real>(mu: f64, is_coulomb: bool) -> ContactSet<T, 3> {
    let mu = T::literal(mu);
    ContactSet {
        shift_factor: if is_coulomb { mu } else { T::ZERO },
        cone: FrictionCone::new(mu).expect("mu"),
        alpha: T::literal(0.7),
        q: SVector::zeros(),
        base: SVector::zeros(),
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
        let set = set(mu, is_coulomb);
        for gain in [0.1, 1.0, 30.0] {
            let [r, u] = [(); 2].map(|()| SVector::from_fn(|_, _| numbers.next().unwrap_or(0.0)));
            let pair = Pair::centred(&set, &r, &u, 1e-4, gain, 3.0);
            for product in pair.products(3.0).into_iter().flatten() {
                assert!((product - 1e-4).abs() < 1e-12, "{product}");
            }
            if pair.part.is_cone::<3>() {
                assert!(pair.x[0] > 0.0 && det(&pair.x) > 0.0);
                let across = pair.dual * pair.x[0] + pair.x * pair.dual[0];
                assert!(across.fixed_rows::<2>(1).norm() < 1e-12);
            }
        }
    }
    let held = ContactSet { alpha: 0.0, ..set::<f64>(0.5, true) };
    assert_eq!(Part::of(&held), Part::Nothing);
}

#[test]
fn the_scaling_takes_one_of_a_pair_to_the_other() {
    let pair = Pair::<f64, 3> {
        part: Part::Coulomb,
        x: vector![2.0, -1.0, 1.5],
        dual: vector![0.3, 0.1, 0.25],
        normal: 0.2,
    };
    let scaling = Scaling::<f64, 3>::of(&pair);
    assert!((scaling.inverse_square(&pair.x) - pair.dual).norm() < 1e-12);
    // A step of nothing to where it is
    let still = Pair::none();
    let goal = scaling.corrected(&pair, &still, 0.0);
    assert!((goal + pair.dual).norm() < 1e-12);
    let rows: [f64; 2] = [1, 2].map(|k| scaling.column(&pair, k)[3 - k]);
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
                dual: vector![one, tenth, T::ZERO],
                normal: one,
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
                    dual: SVector::from_fn(|_, _| next()) * pair.dual[0],
                    normal: next() * pair.normal,
                };
                let reach = pair.max_step(&step, T::literal(4.0));
                let mut there = pair;
                there.advance(&step, reach * T::literal(0.999));
                assert!(there.x[0] > T::ZERO);
                if part != Part::Cone {
                    assert!(there.normal > T::ZERO);
                }
                if part.is_cone::<3>() {
                    assert!(det(&there.x) > T::ZERO && det(&there.dual) > T::ZERO);
                }
                pair = there;
            }
        }
    }
    check::<f32>();
    check::<f64>();
}

/// A contact of each coefficient on a mass of one, and so many rows of all laws with compliance, one of which keeps its impulse.
fn scene<const D: usize>(mus: &[f64], rows: usize) -> Result<Scene<f64, N, D, C, R, C>, Error> {
    let mut numbers = numbers();
    let mut next = || numbers.next().unwrap_or(0.0);
    let mut scene = Scene::new();
    scene.set_mass(&SMatrix::identity())?;
    for &mu in mus {
        let contact =
            Contact { jacobian: SMatrix::from_fn(|_, _| next()), offset: SVector::zeros(), mu: 0.0, key: 0 };
        // The same for all tangents, of which some turn.
        let surface = Surface { spin: mu, roll: [mu; 2], ..Surface::isotropic(mu) };
        scene.push_on(&contact, &surface)?;
    }
    let boxed = |lower, upper| RowLaw::Box { lower, upper };
    let laws = [RowLaw::Limit, RowLaw::Equality, boxed(0.3, 0.3), boxed(-0.4, 1.0), RowLaw::Limit];
    for (law, key) in laws.into_iter().zip(0..).take(rows) {
        scene.push_row(&JointRow {
            row: SVector::from_fn(|_, _| next()),
            offset: next(),
            law,
            compliance: if key == 4 { 0.3 } else { 0.0 },
            key,
        })?;
    }
    Ok(scene)
}

/// The derivative of each product along a step is what was asked for, and velocities go on to follow from impulses.
fn check<const D: usize>(mus: &[f64], rows: usize, model: Model) -> Result<(), Error> {
    let scene = scene::<D>(mus, rows)?;
    let factor = Factor::new(&scene)?;
    let f = SVector::from_iterator(numbers().take(N));
    let mut problem = Problem::new(&scene, &factor, &f, &Settings { model, ..Settings::default() }, Age::New);
    problem.fill(true);
    let sets = &problem.sets;
    let (tau, beta) = (0.1, 3.0);
    let mut q = Stacked::zero();
    for (q, set) in q.contacts.iter_mut().zip(sets.contacts()) {
        *q = set.q.into();
    }
    for (q, set) in q.rows.iter_mut().zip(sets.rows()) {
        *q = set.q;
    }
    let (mut pairs, mut r) = (Pairs::<f64, D, C, R>::none(), Stacked::zero());
    sets.project(&mut r);
    pairs.enter(sets, (&r, &q), tau, 2.0, beta);
    let velocities = |step: &Pairs<f64, D, C, R>, length: f64| {
        let (mut r, mut u) = (Stacked::zero(), Stacked::zero());
        for (i, r) in r.contacts.iter_mut().enumerate().take(mus.len()) {
            let x = pairs.contacts[i].x + step.contacts[i].x * length;
            *r = widen(&sets.contacts()[i], &x).into();
        }
        for (j, r) in r.rows.iter_mut().enumerate().take(rows) {
            *r = pairs.rows[j].impulse + step.rows[j].impulse * length;
        }
        problem.velocities_and_estimate(&r, &mut u);
        u
    };
    let still = Pairs::none();
    let (mut matrix, mut elimination) = (StackedMatrix::zero(), Elimination::none());
    let u = velocities(&still, 0.0);
    let mut system = PathSystem::new(&problem.sets, &pairs, &u, &mut matrix, &mut elimination);
    let factorised = system.factorise(&problem.sets, problem.factor.delassus());
    factorised.expect("a regular matrix");
    let mut step = Pairs::none();
    system.correct(&still, (0.01, beta), &mut step).expect("a step");
    let there = velocities(&step, 1.0);
    let follows_goal = |products: [[Option<f64>; 2]; 3]| {
        let [here, ahead, behind] = products;
        let slopes = ahead.iter().zip(&behind).zip(&here);
        for ((ahead, behind), here) in slopes.filter_map(|((a, b), h)| Some((((*a)?, (*b)?), (*h)?))) {
            let slope = (ahead - behind) / 2e-4;
            assert!((slope - (0.01 - here)).abs() < 1e-7, "{D} rows: {slope}");
        }
    };
    let lengths = [0.0, 1e-4, -1e-4];
    for (i, (pair, step)) in pairs.contacts.iter().zip(&step.contacts).enumerate().take(mus.len()) {
        follows_goal(lengths.map(|h: f64| {
            let mut moved = *pair;
            moved.advance(step, h);
            moved.products(beta)
        }));
        let wide = widen(&sets.contacts()[i], &there.contacts[i].into());
        let mut follows = pair.dual + step.dual;
        if pair.part != Part::Cone {
            follows[0] = pair.normal + step.normal;
        }
        let count = pair.part.count::<D>();
        let gaps: Vec<f64> = (0..count).map(|k| (follows[k] - wide[k]).abs()).collect();
        assert!(gaps.iter().all(|&gap| gap < 1e-10), "{D} rows: {gaps:?}");
    }
    for (j, (pair, step)) in pairs.rows.iter().zip(&step.rows).enumerate().take(rows) {
        let at = |h: f64| {
            let mut moved = *pair;
            moved.advance(step, h);
            moved
        };
        follows_goal(lengths.map(|h| at(h).products()));
        if pair.is_free {
            let gap = (at(1.0).velocity() - there.rows[j]).abs();
            assert!(gap < 1e-10, "{D} rows a contact, joint row {j}: {gap}");
        } else {
            assert!(step.impulse == 0.0 && pair.impulse == 0.3);
        }
    }
    Ok(())
}

#[test]
fn a_step_does_what_it_is_told() -> Result<(), Error> {
    for model in [Model::Coulomb, Model::ConvexRelaxation] {
        for mus in [[0.5, 0.3, 1.0], [0.0, 10.0, 0.2], [0.0; C]] {
            check::<1>(&mus, 0, model)?;
            check::<2>(&mus, 0, model)?;
            check::<3>(&mus, 0, model)?;
            check::<4>(&mus, 0, model)?;
        }
    }
    Ok(())
}

/// Beside contacts, and alone.
#[test]
fn a_step_of_joint_rows_does_what_it_is_told() -> Result<(), Error> {
    for model in [Model::Coulomb, Model::ConvexRelaxation] {
        for mus in [[0.5, 0.3, 1.0], [0.0, 10.0, 0.2], [0.0; C]] {
            check::<1>(&mus, 5, model)?;
            check::<2>(&mus, 5, model)?;
            check::<3>(&mus, 5, model)?;
            check::<4>(&mus, 5, model)?;
        }
        check::<3>(&[], 5, model)?;
    }
    Ok(())
}
