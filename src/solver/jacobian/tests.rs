//! The Jacobian against finite differences of `E(z)`, for contacts that stick, slip, are open and have no friction.
#![allow(clippy::indexing_slicing)]

extern crate std;

use super::Jacobian;
use crate::linalg::blocks::ContactVector;
use crate::problem::Problem;
use crate::solver::frame::Kind;
use crate::solver::point::Point;
use crate::{Contact, Error, Factor, Model, Scene};
use nalgebra::{SMatrix, SVector};
use proptest::collection::vec;
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Reason, TestRunner};
use std::string::{String, ToString};
use std::vec::Vec;

const N: usize = 13;
const C: usize = 3;

/// A scene with more dofs than rows, so that the system is regular without damping.
fn scene<const D: usize>(numbers: &[f64], mus: &[f64]) -> Result<Scene<f64, N, D, C>, Error> {
    let (root, rows) = numbers.split_at(N * N);
    let root = SMatrix::<f64, N, N>::from_column_slice(root);
    let mut scene = Scene::new();
    scene.set_mass(&(root * root.transpose() + SMatrix::identity()))?;
    for (rows, &mu) in rows.chunks_exact(D * N).zip(mus) {
        scene.push(&Contact {
            jacobian: SMatrix::from_column_slice(rows),
            offset: SVector::zeros(),
            mu,
            key: 0,
        })?;
    }
    Ok(scene)
}

/// `J d = b` is solved for `d`; the derivative of `-E` along `d` has to be `b`. The largest difference, and what the
/// contacts do.
fn difference<const D: usize>(
    problem: &Problem<'_, f64, N, D, C>,
    z: &[SVector<f64, D>; C],
    b: &ContactVector<f64, D, C>,
) -> Option<(f64, Vec<Kind>)> {
    let at = |z: [SVector<f64, D>; C]| {
        let mut point = Point::none();
        point.z = z;
        point.update(problem);
        point
    };
    let point = at(*z);
    let (mut jacobian, mut matrix) = (Jacobian::none(), [[[[0.0; D]; C]; D]; C]);
    jacobian.compute(problem, &point, 0.0, &mut matrix)?;
    let d = jacobian.step(problem, b, &matrix)?;
    let size = d.iter().fold(0.0_f64, |size, d| size.max(d.amax()));
    let h = 1e-6 / size;
    let moved = |h: f64| at(core::array::from_fn(|i| z[i] + d[i] * h));
    let (ahead, behind) = (moved(h), moved(-h));
    // At a kink there is no derivative.
    for point in [&ahead, &behind] {
        if !jacobian.has_same_active_set(problem, point) {
            return None;
        }
    }
    let slopes = ahead
        .residual
        .as_flattened()
        .iter()
        .zip(behind.residual.as_flattened());
    let slopes = slopes.map(|(ahead, behind)| (ahead - behind) / (2.0 * h));
    let differences = slopes
        .zip(b.as_flattened())
        .map(|(slope, b)| (slope + b).abs());
    let largest = differences.fold(0.0, f64::max);
    let kinds = jacobian.frames.iter().map(|frame| frame.kind);
    Some((largest, kinds.collect()))
}

/// Draws scenes and points of `D` rows a contact; how often each of stick, slip, open and frictionless was met.
fn check<const D: usize>(model: Model) -> Result<[usize; 4], String> {
    let mut runner = TestRunner::deterministic();
    let draws = (
        vec(-1.0..1.0, N * N + C * D * N),
        vec(0.1..1.5, C),
        vec(-1.0..1.0, 2 * C * D + N),
    );
    let mut met = [0; 4];
    for round in 0..300 {
        let tree = draws
            .new_tree(&mut runner)
            .map_err(|reason: Reason| reason.to_string())?;
        let (numbers, mut mus, rest) = tree.current();
        mus[round % C] *= f64::from(u8::from(round % 2 == 0));
        let scene = scene::<D>(&numbers, &mus).map_err(|error| error.to_string())?;
        let factor = Factor::new(&scene).map_err(|error| error.to_string())?;
        let (f, rest) = rest.split_at(N);
        let f = SVector::from_column_slice(f);
        let (z, b) = rest.split_at(C * D);
        let z = core::array::from_fn(|i| SVector::from_column_slice(&z[D * i..D * (i + 1)]));
        let b = core::array::from_fn(|i| core::array::from_fn(|k| b[D * i + k]));
        let mut problem = Problem::new(&scene, &factor, &f, model);
        problem.fill(true);
        let Some((difference, kinds)) = difference(&problem, &z, &b) else {
            continue;
        };
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
            assert!(
                met.into_iter().all(|count| count > 40),
                "{model:?}: {met:?}"
            );
        }
        // One row has no tangent: it is open or pushes.
        let met = check::<1>(model)?;
        assert!(met.into_iter().sum::<usize>() > 600, "{met:?}");
    }
    Ok(())
}
