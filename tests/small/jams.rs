//! Friction that locks what is to be pushed apart: no finite impulses solve it, and the status says so.

use crate::support::pad;
use crate::support::random::{draws, numbers};
use crate::support::sizes::{body, body_rows, point};
use nalgebra::{Matrix6, SMatrix, SVector, Vector3, vector};
use stiction::{Contact, Error, Factor, Model, Real, Scene, Settings, Solution, Solver, Status, Surface};

const WALL: f64 = 0.1; // m/s at which a gap is to open

/// A cube of 1 kg between a floor and a lid that is tilted, to be pushed off both.
pub(crate) fn wedge<T: Real>(mu: f64, tilt: f64) -> Result<(body_rows::Scene<T>, SVector<T, 6>), Error> {
    let mut scene = Scene::new();
    let masses = vector![1.0, 1.0, 1.0, 0.1, 0.1, 0.1];
    scene.set_mass(&Matrix6::from_diagonal(&masses).map(T::literal))?;
    let lid = [
        Vector3::new(-tilt.sin(), 0.0, -tilt.cos()),
        Vector3::new(tilt.cos(), 0.0, -tilt.sin()),
        Vector3::y(),
    ];
    for (height, frame) in [(-0.5, [Vector3::z(), Vector3::x(), Vector3::y()]), (0.5, lid)] {
        for (x, y) in [(-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)] {
            let point = Vector3::new(x, y, height);
            let mut jacobian = SMatrix::<f64, 3, 6>::zeros();
            for (k, direction) in frame.iter().enumerate() {
                let turn = point.cross(direction);
                for i in 0..3 {
                    jacobian[(k, i)] = direction[i];
                    jacobian[(k, i + 3)] = turn[i];
                }
            }
            scene.push(&Contact {
                jacobian: jacobian.map(T::literal),
                offset: vector![-WALL, 0.0, 0.0].map(T::literal),
                mu: T::literal(mu),
                key: 0,
            })?;
        }
    }
    Ok((scene, SVector::ith(2, T::literal(-0.0981))))
}

fn solve<T: Real, const N: usize, const C: usize, const R: usize, const S: usize>(
    scene: &Scene<T, N, 3, C, R, S>,
    push: &SVector<T, N>,
    tolerance: f64,
) -> Result<Solution<T, N, 3, C, R>, Error> {
    let settings = Settings { budget: 1_000, ..Settings::new(T::literal(tolerance)) };
    let mut solver = Solver::new();
    Ok(solver.solve(scene, &Factor::new(scene)?, push, &settings)?.clone())
}

/// Does the certificate prove what it says, recomputed here?
fn is_proof<T: Real, const N: usize, const C: usize, const R: usize, const S: usize>(
    scene: &Scene<T, N, 3, C, R, S>,
    solution: &Solution<T, N, 3, C, R>,
) -> bool {
    let double = |x: T| x.to_subset().unwrap_or(f64::NAN);
    let (mut force, mut approach, mut size) = (SVector::<f64, N>::zeros(), 0.0, 0.0);
    let mut inside = solution.certificate.len() == scene.contacts().len();
    for (contact, d) in scene.contacts().iter().zip(&solution.certificate) {
        let d = d.map(double);
        force += contact.jacobian.map(double).transpose() * d;
        approach -= contact.offset.map(double).dot(&d);
        size += d.norm();
        inside &= d[1].hypot(d[2]) <= double(contact.mu) * d[0] * (1.0 + 1e-12);
    }
    inside && force.norm() <= 64.0 * double(T::EPSILON) * size && approach > 1e-3 * WALL * size
}

fn wedges<T: Real>(tolerance: f64) -> Result<(), Error> {
    let mut wrong = Vec::new();
    for mu in [0.03, 0.07, 0.13, 0.25, 0.5] {
        for degrees in [2.0, 5.0, 10.0, 20.0, 40.0, 60.0_f64] {
            let tilt = degrees.to_radians();
            let (scene, push) = wedge::<T>(mu, tilt)?;
            let solution = solve(&scene, &push, tolerance)?;
            let locks = (tilt / 2.0).tan() < mu;
            let expected = if locks { Status::Jammed } else { Status::Solved };
            if solution.status != expected || locks != is_proof(&scene, &solution) {
                wrong.push((mu, degrees, solution.status, solution.error));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
    Ok(())
}

#[test]
fn wedges_in_f64() -> Result<(), Error> {
    wedges::<f64>(1e-6)?;
    wedges::<f64>(1e-9)
}

#[test]
fn wedges_in_f32() -> Result<(), Error> {
    wedges::<f32>(1e-4)
}

/// A unit of mass that is no square: the same bits of the proof.
#[test]
fn a_proof_of_a_jam_knows_no_unit_of_mass() -> Result<(), Error> {
    for degrees in [10.0_f64, 20.0] {
        let (scene, push) = wedge::<f32>(0.5, degrees.to_radians())?;
        let plain = solve(&scene, &push, 1e-4)?;
        assert_eq!(plain.status, Status::Jammed);
        let mut heavy = scene.clone();
        heavy.set_mass(&(scene.mass() * 2.0))?;
        let heavy = solve(&heavy, &(push * 2.0), 1e-4)?;
        assert_eq!((heavy.status, heavy.velocity), (plain.status, plain.velocity));
        assert_eq!(heavy.certificate, plain.certificate);
    }
    Ok(())
}

/// A jaw of one joint at 5 degrees that is to be pushed out.
fn jaw<T: Real>(tolerance: f64) -> Result<(), Error> {
    let mut scene = point::Scene::<T>::new();
    scene.set_mass(&SMatrix::identity())?;
    scene.push(&Contact {
        jacobian: pad::jacobian(&vector![0.0873_f64.sin(), 0.0873_f64.cos(), 0.0].map(T::literal)),
        offset: vector![-WALL, 0.0, 0.0].map(T::literal),
        mu: T::ONE,
        key: 0,
    })?;
    let solution = solve(&scene, &SVector::zeros(), tolerance)?;
    assert_eq!(solution.status, Status::Jammed, "{tolerance}");
    assert!(is_proof(&scene, &solution) && !solution.is_usable(T::ONE));
    // It does not throw what would stay.
    assert!(solution.velocity[0].abs() <= T::literal(2.0), "{:?}", solution.velocity);
    Ok(())
}

#[test]
fn a_jaw_jams() -> Result<(), Error> {
    for tolerance in [1e-3, 1e-6, 1e-9] {
        jaw::<f64>(tolerance)?;
    }
    jaw::<f32>(1e-4)
}

/// A normal that moves nothing but rounding is one that nothing moves: what it asks for is proved to be impossible, and nothing is thrown.
#[test]
fn a_normal_of_rounding_is_immovable() -> Result<(), Error> {
    for (normal, tangent) in [(1e-21, 0.1), (3.9e-21, 1.0), (1e-170, 1.0)] {
        let mut scene = point::Scene::<f64>::new();
        scene.set_mass(&SMatrix::identity())?;
        scene.push(&Contact {
            jacobian: pad::jacobian(&vector![normal, tangent, 0.0]),
            offset: vector![-1e-13, 0.0, 0.0],
            mu: 1.0,
            key: 0,
        })?;
        let solution = solve(&scene, &SVector::zeros(), 1e-6)?;
        assert_eq!(solution.status, Status::Infeasible);
        assert_eq!(solution.certificate[0], vector![1.0, 0.0, 0.0]);
        assert!(solution.velocity[0].abs() <= 1e-9 && !solution.is_usable(1e-2));
    }
    Ok(())
}

/// Two walls of a wedge in the plane, at an angle to the vertical, that overlap with a body between them.
fn overlapping_walls(angle: f64, mu: f64, overlaps: [f64; 2]) -> Result<point::Scene<f64>, Error> {
    let (sine, cosine) = angle.sin_cos();
    let mut scene = Scene::new();
    scene.set_mass(&SMatrix::identity())?;
    for (key, (side, overlap)) in (0..).zip([1.0, -1.0].into_iter().zip(overlaps)) {
        let normal = Vector3::new(side * cosine, sine, 0.0);
        let tangent = Vector3::new(-side * sine, cosine, 0.0);
        let jacobian =
            SMatrix::from_rows(&[normal.transpose(), tangent.transpose(), Vector3::z().transpose()]);
        scene.push(&Contact { jacobian, offset: vector![-overlap, 0.0, 0.0], mu, key })?;
    }
    Ok(scene)
}

/// What a budget of 1,000 names is not solved with less, nor usable while a wall closes, in one call or in pieces.
#[test]
fn a_jam_is_solved_with_no_budget() -> Result<(), Error> {
    let (push, mut jams) = (vector![0.01, -0.02, 0.0], 0);
    for x in draws(numbers(4), 40) {
        let angle = (31.0 + 29.0 * x[0]).to_radians();
        let mu = angle.tan() * (1.5 + 0.5 * x[1]);
        let scene = overlapping_walls(angle, mu, [0.5 + 0.4 * x[2], 0.5 + 0.4 * x[3]])?;
        let factor = Factor::new(&scene)?;
        for tolerance in [1e-2, 1e-3, 1e-6] {
            if solve(&scene, &push, tolerance)?.status != Status::Jammed {
                continue;
            }
            jams += 1;
            for budget in [1, 10, 100, 300, 999] {
                let settings = Settings { budget, ..Settings::new(tolerance) };
                let mut solver = Solver::new();
                for _ in 0..(1_000 / budget).min(3) {
                    let solution = solver.resume(&scene, &factor, &push, &settings)?;
                    let closing = solution.contacts.iter().map(|contact| -contact.velocity[0]);
                    let asked = scene.contacts().iter().map(|contact| -contact.offset[0]);
                    let closes = closing.fold(0.0, f64::max) > 0.1 * asked.fold(0.0, f64::max);
                    assert!(!solution.is_solved(), "{budget}: {:e}", solution.error);
                    assert!(!solution.is_usable(1e-2) || !closes, "{budget}: {:e}", solution.error);
                }
            }
        }
    }
    assert!(jams > 60, "{jams}");
    Ok(())
}

/// A block is pressed with 8 N between two walls whose gaps are off by `accuracy`: a compliance of `accuracy / (force step²)` solves each tick, and the
/// error of the gaps adds no more than the push.
fn a_compliance_shares_walls<T: Real>(accuracy: f64, tolerance: f64) -> Result<(), Error> {
    let (step, force) = (1e-3, 8.0);
    let soft = [T::literal(accuracy / (force * step * step)); 2];
    let push = vector![force * step, 0.0, 0.0, 0.0, 0.0, 0.0].map(T::literal);
    let (mut scene, mut solver) = (body_rows::Scene::<T>::new(), body_rows::Solver::<T>::new());
    scene.set_mass(&(SMatrix::identity() * T::literal(2.0)))?;
    for off in draws(numbers(2), 200) {
        scene.clear();
        for (key, (side, off)) in (0..).zip([1.0, -1.0].into_iter().zip(&off)) {
            let offset = vector![off * accuracy / step, 0.0, 0.0].map(T::literal);
            let mut jacobian = SMatrix::identity();
            jacobian[(0, 0)] = T::literal(side);
            let surface = Surface { compliance: soft, ..Surface::isotropic(T::literal(0.6)) };
            scene.push_on(&Contact { jacobian, offset, mu: T::ZERO, key }, &surface)?;
        }
        let settings = Settings::new(T::literal(tolerance));
        let solution = solver.solve(&scene, &Factor::new(&scene)?, &push, &settings)?;
        assert_eq!(solution.status, Status::Solved, "{off:?}");
        let largest = T::literal(2.01 * force * step);
        assert!(solution.contacts.iter().all(|contact| contact.impulse[0] <= largest), "{solution:?}");
    }
    Ok(())
}

#[test]
fn a_compliance_shares_walls_whose_gaps_are_rounded() -> Result<(), Error> {
    a_compliance_shares_walls::<f64>(1e-9, 1e-6)?;
    a_compliance_shares_walls::<f64>(1e-13, 1e-9)?;
    a_compliance_shares_walls::<f32>(1e-6, 1e-4)
}

/// A body gripped by three walls, two of which nearly oppose each other. The scene has a solution, with impulses of 1e5 times its weight; one
/// that lets a wall close as if the body were not there is none, however small its error.
#[test]
fn no_solution_lets_a_wall_close_on_a_gripped_body() -> Result<(), Error> {
    let rows = [
        [[0.523, -0.201, -0.828, -0.006, -0.015, 0.0], [0.0, -0.972, 0.236, 0.087, 0.017, 0.068]],
        [[-0.524, -0.034, 0.851, -0.01, 0.008, -0.006], [0.0, 0.999, 0.04, 0.097, -0.002, 0.051]],
        [[0.634, -0.207, -0.746, 0.002, -0.003, 0.003], [0.0, -0.964, 0.267, 0.071, 0.017, 0.061]],
    ];
    let last = [
        [-0.852, -0.124, -0.508, -0.004, -0.106, 0.032],
        [-0.852, 0.021, -0.523, 0.006, 0.11, -0.005],
        [-0.774, -0.169, -0.611, 0.002, -0.093, 0.023],
    ];
    let mut scene = body_rows::Scene::<f64>::new();
    scene.set_mass(&Matrix6::from_diagonal(&vector![1.094, 1.094, 1.094, 0.006, 0.009, 0.02]))?;
    for (key, (([normal, first], second), overlap)) in
        (0..).zip(rows.into_iter().zip(last).zip([0.04, 0.03, 0.26]))
    {
        let jacobian = SMatrix::from_rows(&[normal, first, second].map(|row| SVector::from(row).transpose()));
        scene.push(&Contact { jacobian, offset: vector![-overlap, 0.0, 0.0], mu: 0.57, key })?;
    }
    let (factor, push) = (Factor::new(&scene)?, SVector::ith(2, -0.005));
    for tolerance in [1e-2, 1e-3, 1e-4, 1e-6, 1e-9] {
        for budget in [1, 10, 100, 999, 1_000, 5_000] {
            let settings = Settings { budget, ..Settings::new(tolerance) };
            let mut solver = Solver::new();
            let solution = solver.solve(&scene, &factor, &push, &settings)?;
            let closing = solution.contacts.iter().map(|contact| -contact.velocity[0]).fold(0.0, f64::max);
            assert!(!solution.is_usable(1e-2) || closing <= 0.026, "{tolerance:e}, {budget}: {closing}");
        }
    }
    Ok(())
}

/// A one-way clutch: a plate of 1 kg is pulled along x by 300 N, a ball of 20 g on it is drawn under a ramp, at `share` of the angle up to
/// which it locks. The plate and the ramp then press it by `F / tan(angle / 2)`, however large the force.
fn clutch(share: f64) -> Result<(body::Scene<f64>, SVector<f64, 6>, f64), Error> {
    let (step, mass, radius, mu): (f64, f64, f64, f64) = (1e-3, 0.02, 0.01, 0.2);
    let angle = share * 2.0 * mu.atan();
    let (sin, cos) = angle.sin_cos();
    // The plate's x; the ball's x, z and turn about y, by which a point p moves at (p_z, -p_x).
    let row = |[plate, x, z, turn]: [f64; 4]| vector![plate, x, z, turn, 0.0, 0.0];
    let masses = row([1.0, mass, mass, 0.4 * mass * radius * radius]);
    let mut scene = body::Scene::new();
    scene.set_velocities(4)?;
    scene.set_mass(&Matrix6::from_diagonal(&masses))?;
    let plate = [row([0.0, 0.0, 1.0, 0.0]), row([-1.0, 1.0, 0.0, -radius])];
    let ramp = [row([0.0, -sin, -cos, 0.0]), row([0.0, cos, -sin, radius])];
    for [normal, tangent] in [plate, ramp] {
        let jacobian = SMatrix::from_rows(&[normal.transpose(), tangent.transpose(), SMatrix::zeros()]);
        scene.push(&Contact { jacobian, offset: Vector3::zeros(), mu, key: 0 })?;
    }
    let load = 300.0 * step;
    Ok((scene, row([load, 0.0, -mass * 9.81 * step, 0.0]), load / (angle / 2.0).tan()))
}

#[test]
fn a_clutch_locks_at_once() -> Result<(), Error> {
    for share in [0.5, 0.65, 0.8, 0.9, 0.95, 0.99] {
        let (scene, push, pressed) = clutch(share)?;
        let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
        let locks = |solution: &Solution<f64, 6, 3, 4, 0>| {
            let presses =
                solution.contacts.iter().all(|contact| (contact.impulse[0] / pressed - 1.0).abs() < 1e-3);
            solution.status == Status::Solved && solution.velocity[0].abs() < 1e-5 && presses
        };
        let law = Settings { budget: 200, ..Settings::new(1e-9) };
        assert!(locks(solver.solve(&scene, &factor, &push, &law)?), "{share}");
        // All can stay, so the relaxation has the same solution.
        solver.reset();
        let relaxation = Settings { model: Model::ConvexRelaxation, ..law };
        assert!(locks(solver.solve(&scene, &factor, &push, &relaxation)?), "{share}");
        let again = solver.solve(&scene, &factor, &push, &Settings { budget: 20, ..law })?;
        assert!(locks(again), "{share}: {again:?}");
    }
    Ok(())
}
