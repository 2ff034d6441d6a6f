//! A scene for the tests of this folder: a cube on a floor, which can stick, slide, fly and be hyperstatic.

extern crate std;

use crate::error::Error;
use crate::factor::Factor;
use crate::problem::{Age, Problem};
use crate::scene::{Contact, Scene};
use crate::solution::{Settings, Solution};
use crate::solver::monitor::Monitor;
use crate::solver::phases::AllPhases;
use crate::solver::record::{Call, Record};
use crate::solver::solve::Solve;
use crate::solver::state::State;
use crate::solver::warm_start::WarmStart;
use core::marker::PhantomData;
use nalgebra::{SMatrix, SVector, matrix, vector};

pub(super) const N: usize = 6;
pub(super) const D: usize = 3;
pub(super) const C: usize = 4;

/// A cube of 2 kg on its first `count` lower corners; dofs x, y, z and rotations, z up.
pub(super) fn cube(count: usize, mu: f64) -> Result<Scene<f64, N, D, C>, Error> {
    let mut scene = Scene::new();
    let masses = vector![2.0, 2.0, 2.0, 0.1, 0.1, 0.1];
    scene.set_mass(&SMatrix::from_diagonal(&masses))?;
    let corners = [(0.2, 0.2), (0.2, -0.2), (-0.2, 0.2), (-0.2, -0.2)];
    for (key, (x, y)) in (0..).zip(corners).take(count) {
        scene.push(&Contact {
            jacobian: matrix![
                0.0, 0.0, 1.0, y, -x, 0.0;
                1.0, 0.0, 0.0, 0.0, -0.2, -y;
                0.0, 1.0, 0.0, 0.2, 0.0, x],
            offset: SVector::zeros(),
            mu,
            key,
        })?;
    }
    Ok(scene)
}

/// A free impulse that presses with 1 N·s and pushes sideways.
pub(super) fn pressed(sideways: f64) -> SVector<f64, N> {
    vector![sideways, 0.0, -1.0, 0.0, 0.0, 0.0]
}

/// Calls `work` with the problem of a scene and a free impulse.
pub(super) fn with_problem<O>(
    scene: &Scene<f64, N, D, C>,
    push: &SVector<f64, N>,
    work: impl FnOnce(&mut Problem<'_, f64, N, D, C, 0, 0>) -> O,
) -> Result<O, Error> {
    with_solve(scene, push, |solve| work(solve.monitor.problem))
}

/// Calls `work` with the monitor of a solve that has begun, with a tolerance of 1e-9 and a budget of 100.
pub(super) fn with_monitor<O>(
    scene: &Scene<f64, N, D, C>,
    push: &SVector<f64, N>,
    work: impl FnOnce(&mut Monitor<'_, '_, f64, N, D, C, 0, 0>) -> O,
) -> Result<O, Error> {
    with_solve(scene, push, |solve| work(&mut solve.monitor))
}

/// Calls `work` with a solve that has begun, without a last one.
pub(super) fn with_solve<O>(
    scene: &Scene<f64, N, D, C>,
    push: &SVector<f64, N>,
    work: impl FnOnce(&mut Solve<'_, '_, f64, N, D, C, 0, 0, AllPhases>) -> O,
) -> Result<O, Error> {
    let last = (&mut State::none(), &mut WarmStart::cold());
    with_solve_from(last, Call::Begin, (scene, push), work)
}

/// Calls `work` with a solve that has begun from the state and the warm start of the last one.
pub(super) fn with_solve_from<O, const N: usize, const D: usize, const C: usize, const R: usize>(
    (state, warm_start): (&mut State<f64, D, C, R>, &mut WarmStart<f64, D, C, R>),
    call: Call,
    (scene, push): (&Scene<f64, N, D, C, R>, &SVector<f64, N>),
    work: impl FnOnce(&mut Solve<'_, '_, f64, N, D, C, R, 0, AllPhases>) -> O,
) -> Result<O, Error> {
    let settings = Settings { budget: 100, ..Settings::new(1e-9) };
    let (mut solution, mut record) = (Solution::none(), Record::none());
    record.begin();
    let factor = Factor::new(scene)?;
    let mut problem = Problem::new(scene, &factor, push, &settings, Age::New);
    problem.fill(true);
    let monitor = Monitor::new(&mut problem, &settings, &mut solution, &mut record, call);
    Ok(work(&mut Solve { monitor, state, warm_start, phases: PhantomData }))
}
