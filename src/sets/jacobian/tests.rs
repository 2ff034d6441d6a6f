//! The Jacobian against finite differences of `E(z)`, for contacts that stick, slip, are open and have no friction.
#![allow(clippy::indexing_slicing)]

extern crate std;

use super::Jacobian;
use crate::linalg::stacked::{Stacked, StackedMatrix};
use crate::problem::{Age, Problem};
use crate::sets::point::NewtonPoint;
use crate::{Contact, Error, Factor, Model, Scene, Settings, Surface};
use nalgebra::{SMatrix, SVector};
use proptest::collection::vec;
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Reason, TestRunner};
use std::string::{String, ToString};

mod rows;

/// Velocities, capacity for contacts, and for joint rows, one of which is unused.
const N: usize = 16;
const C: usize = 3;
const R: usize = 8;

/// A scene with more dofs than rows, so that the system is regular without damping.
fn scene<const D: usize>(numbers: &[f64], mus: &[f64]) -> Result<Scene<f64, N, D, C, R, C>, Error> {
    let (root, rows) = numbers.split_at(N * N);
    let root = SMatrix::<f64, N, N>::from_column_slice(root);
    let mut scene = Scene::new();
    scene.set_mass(&(root * root.transpose() + SMatrix::identity()))?;
    for (rows, &mu) in rows.chunks_exact(D * N).zip(mus) {
        let contact =
            Contact { jacobian: SMatrix::from_column_slice(rows), offset: SVector::zeros(), mu: 0.0, key: 0 };
        // The same for all tangents, of which some turn.
        let surface = Surface { spin: mu, roll: [mu; 2], ..Surface::isotropic(mu) };
        scene.push_on(&contact, &surface)?;
    }
    Ok(scene)
}

/// A point of a problem, and what follows from it.
fn point_at<const D: usize>(
    problem: &Problem<'_, f64, N, D, C, R, C>,
    z: &Stacked<f64, D, C, R>,
) -> NewtonPoint<f64, D, C, R> {
    let mut point = NewtonPoint::none();
    point.z = *z;
    problem.evaluate_point(&mut point);
    point
}

/// `J d = b` is solved for `d`; the derivative of `-E` along `d` has to be `b`. The differences, at a Jacobian; `None` if it is
/// singular, or there is no derivative.
fn differences<const D: usize>(
    problem: &Problem<'_, f64, N, D, C, R, C>,
    point: &NewtonPoint<f64, D, C, R>,
    b: &Stacked<f64, D, C, R>,
) -> Option<(Stacked<f64, D, C, R>, Jacobian<f64, D, C, R>)> {
    let (mut jacobian, mut matrix) = (Jacobian::none(), StackedMatrix::zero());
    // There are as many equations of joint rows as hold: behind them nothing is read, and nothing written.
    for row in &mut matrix.rows {
        row.iter_mut().for_each(|entry| *entry = f64::NAN);
    }
    jacobian.compute(&problem.sets, problem.factor.delassus(), point, 0.0, &mut matrix)?;
    let holding = jacobian.holding_rows().count();
    for (place, row) in matrix.rows.iter().enumerate() {
        let untouched = row.iter().all(|entry| entry.is_nan());
        assert!(untouched == (place >= holding), "{place} of {holding}");
    }
    let d = jacobian.step(&problem.sets, problem.factor.delassus(), b, &matrix)?;
    let counts = problem.sets.counts();
    let size = d.in_use(counts).fold(0.0_f64, |size, d| size.max(d.abs()));
    let h = 1e-6 / size;
    let [ahead, behind] = [h, -h].map(|h| point_at(problem, &Stacked::along(&point.z, &d, h)));
    // At a kink there is no derivative.
    for point in [&ahead, &behind] {
        if !jacobian.has_same_active_set(&problem.sets, point) {
            return None;
        }
    }
    let mut differences = Stacked::zero();
    let slopes = ahead.residual.iter().zip(behind.residual.iter());
    let slopes = slopes.map(|(ahead, behind)| (ahead - behind) / (2.0 * h));
    let pairs = differences.iter_mut().zip(slopes.zip(b.iter()));
    for (difference, (slope, b)) in pairs {
        *difference = (slope + b).abs();
    }
    Some((differences, jacobian))
}

/// Draws scenes and points of `D` rows a contact; how often each of stick, slip, open and frictionless was met.
fn check<const D: usize>(model: Model) -> Result<[usize; 4], String> {
    let mut runner = TestRunner::deterministic();
    let draws = (vec(-1.0..1.0, N * N + C * D * N), vec(0.1..1.5, C), vec(-1.0..1.0, 2 * C * D + N));
    let mut met = [0; 4];
    for round in 0..400 {
        let tree = draws.new_tree(&mut runner).map_err(|reason: Reason| reason.to_string())?;
        let (numbers, mut mus, rest) = tree.current();
        mus[round % C] *= f64::from(u8::from(round % 2 == 0));
        let scene = scene::<D>(&numbers, &mus).map_err(|error| error.to_string())?;
        let factor = Factor::new(&scene).map_err(|error| error.to_string())?;
        let (f, rest) = rest.split_at(N);
        let f = SVector::from_column_slice(f);
        let (z, b) = rest.split_at(C * D);
        let [z, b] = [z, b].map(|numbers| Stacked {
            contacts: core::array::from_fn(|i| core::array::from_fn(|k| numbers[D * i + k])),
            rows: [0.0; R],
        });
        let mut problem =
            Problem::new(&scene, &factor, &f, &Settings { model, ..Settings::default() }, Age::New);
        problem.fill(true);
        let point = point_at(&problem, &z);
        let Some((differences, jacobian)) = differences(&problem, &point, &b) else {
            continue;
        };
        let kinds = jacobian.frames.map(|frame| frame.kind);
        let difference = differences.iter().copied().fold(0.0, f64::max);
        assert!(difference < 1e-6, "{D} rows, {kinds:?}: {difference:e}");
        for kind in kinds {
            met[kind as usize] += 1;
        }
    }
    Ok(met)
}

#[test]
fn the_jacobian_is_the_derivative_of_the_residual() -> Result<(), String> {
    for model in [Model::Coulomb, Model::ConvexRelaxation] {
        for met in [check::<2>(model)?, check::<3>(model)?, check::<4>(model)?] {
            assert!(met.into_iter().all(|count| count > 40), "{model:?}: {met:?}");
        }
        // One row has no tangent: it is open or pushes.
        let met = check::<1>(model)?;
        assert!(met.into_iter().sum::<usize>() > 600, "{met:?}");
    }
    Ok(())
}
