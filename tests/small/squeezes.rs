//! Bodies that walls squeeze: a relative error that large impulses make small is no solution, and a squeeze gives no energy.

use crate::support::random::{draws, numbers};
use crate::support::sizes::{body_rows, point};
use nalgebra::{Matrix3, Matrix6, SMatrix, SVector, Vector3, vector};
use stiction::{Contact, Error, Factor, Scene, Settings, Solver, Status};

/// A plate between two walls that both overlap with it, with four contacts on each side, turned by an angle about the normals.
fn gripped_plate(mass: f64, inertia: f64, angle: f64) -> Result<body_rows::Scene<f64>, Error> {
    let mut scene = Scene::new();
    scene.set_mass(&Matrix6::from_diagonal(&vector![mass, mass, mass, inertia, inertia, inertia]))?;
    for side in [-1.0, 1.0] {
        let frame = [Vector3::z() * -side, Vector3::x(), Vector3::y()];
        for corner in 0..4 {
            // A corner that is not the one on the other side.
            let (sine, cosine) =
                (f64::from(corner).mul_add(core::f64::consts::FRAC_PI_2, angle * side)).sin_cos();
            let point = Vector3::new(0.02 * cosine, 0.02 * sine, 0.019 * side);
            let mut jacobian = SMatrix::<f64, 3, 6>::zeros();
            for (k, direction) in frame.iter().enumerate() {
                jacobian.fixed_view_mut::<1, 3>(k, 0).copy_from(&direction.transpose());
                jacobian.fixed_view_mut::<1, 3>(k, 3).copy_from(&point.cross(direction).transpose());
            }
            scene.push(&Contact { jacobian, offset: SVector::zeros(), mu: 1.0, key: 0 })?;
        }
    }
    Ok(scene)
}

/// What a solution may not do: `[the energy that it adds, the fastest approach]`, as shares of those of the free motion.
fn excess(
    scene: &body_rows::Scene<f64>,
    push: &SVector<f64, 6>,
    solution: &body_rows::Solution<f64>,
) -> [f64; 2] {
    let free = SVector::<f64, 6>::from_fn(|k, _| push[k] / scene.mass()[(k, k)]);
    let energy = |v: &SVector<f64, 6>| v.dot(&(scene.mass() * v));
    let approach = |v: &SVector<f64, 6>| {
        scene.contacts().iter().map(|contact| -(contact.jacobian * v)[0]).fold(0.0, f64::max)
    };
    [energy(&solution.velocity) / energy(&free) - 1.0, approach(&solution.velocity) / approach(&free)]
}

/// A light plate with a large inertia: its turning is stopped by impulses of 1e8 times its momentum, beside which each violation is small.
#[test]
fn a_squeeze_gives_no_energy() -> Result<(), Error> {
    let (mut solved, mut wrong) = (0, Vec::new());
    for x in draws(numbers(7), 12) {
        let scene = gripped_plate(0.01, 1e5, 0.3 * x[6])?;
        let factor = Factor::new(&scene)?;
        let free = vector![0.5 * x[0], 0.5 * x[1], 0.05 * x[2], x[3], x[4], x[5]];
        let push = scene.mass() * free;
        for tolerance in [1e-2, 1e-3, 1e-4, 1e-6, 1e-8] {
            for budget in [30, 3_000] {
                let mut solver = Solver::new();
                let settings = Settings { budget, ..Settings::new(tolerance) };
                let solution = solver.solve(&scene, &factor, &push, &settings)?;
                let [gain, approach] = excess(&scene, &push, solution);
                let is_wrong = gain > 1e-3 || approach > 1.01;
                solved += usize::from(solution.is_solved());
                if is_wrong && (solution.is_solved() || solution.is_usable(1e-2)) {
                    wrong.push((tolerance, budget, solution.status, solution.error, gain, approach));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {solved} solved: {:?}", wrong.len(), wrong.first());
    assert!(solved > 20, "{solved}");
    Ok(())
}

/// Two fingers of 1 kg close on a part of 1 g along a line, by a motor each; both overlap with it a little.
fn grip(contacts: [[f64; 3]; 2]) -> Result<point::Scene<f64>, Error> {
    let mut scene = point::Scene::new();
    scene.set_mass(&Matrix3::from_diagonal(&vector![1.0, 0.001, 1.0]))?;
    for (key, row) in (0..).zip(contacts) {
        let mut jacobian = Matrix3::zeros();
        jacobian.set_row(0, &row.into());
        scene.push(&Contact { jacobian, offset: vector![-0.001, 0.0, 0.0], mu: 0.0, key })?;
    }
    Ok(scene)
}

/// Its impulses are 500 times the momentum of the part. Only the first tick asks whether they are those of walls that close; these are found out at once.
#[test]
fn a_grip_is_doubted_once() -> Result<(), Error> {
    let scene = grip([[-1.0, 1.0, 0.0], [0.0, -1.0, 1.0]])?;
    let factor = Factor::new(&scene)?;
    let mut solver = Solver::new();
    for (tick, searches) in (0..5).zip([1, 0, 0, 0, 0]) {
        let push = vector![1.0 + 0.01 * f64::from(tick), 0.0, -1.0];
        let solution = solver.solve(&scene, &factor, &push, &Settings::new(1e-6))?;
        assert!(solution.is_solved() && solution.contacts[0].impulse[0] > 0.9, "{tick}");
        assert_eq!(solution.work.proof_searches, searches, "{tick}");
    }
    // Twice as hard it is doubted anew.
    let solution = solver.solve(&scene, &factor, &vector![3.0, 0.0, -3.0], &Settings::new(1e-6))?;
    assert!(solution.is_solved() && solution.work.proof_searches == 1);
    let walls = grip([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])?;
    let solution =
        solver.solve(&walls, &Factor::new(&walls)?, &vector![3.0, 0.0, -3.0], &Settings::new(1e-6))?;
    assert_eq!(solution.status, Status::Infeasible);
    Ok(())
}
