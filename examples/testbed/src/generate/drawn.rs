//! Classes that no constant of the method was made for: a box, a pile, a grasp, and any matrices.

use super::Candidate;
use super::bodies::{Assembly, GRAVITY, at_rest};
use super::parts::{Parts, frame, point_rows, spatial_inertia};
use super::random::{Random, real};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix3xX, Vector3};

/// A box whose vertices touch planes of one direction, of nearly one, or of several.
pub(super) fn free_box(random: &mut Random) -> Candidate {
    let mut bodies = Assembly::new(3);
    let half = random.vector_of(|random| 0.5 * random.exp(-2.0, 1.0));
    let mass = random.exp(-4.0, 4.0);
    let body = bodies.push_box(mass, half, Vector3::zeros(), Vector3::zeros());
    let turn = random.matrix().qr().q();
    let direction = random.vector();
    for _ in 0..random.count(1, 8) {
        let vertex = turn * half.component_mul(&random.vector_of(Random::sign));
        let normal = direction + random.vector() * random.pick(&[0.0, 0.01, 1.0]);
        let inward = if normal.dot(&vertex) < 0.0 { normal } else { -normal };
        let mu = random.pick(&[0.0, 0.1, 0.5, 0.8, 1.5, 3.0]);
        bodies.touch((body, None), vertex, inward, mu, 0.0);
    }
    bodies.before = random.normals(6) * random.pick(&[0.0, 0.1, 3.0]);
    let gravity = random.vector() * (GRAVITY / 1.7);
    let step = random.power_of_ten(-4.0, -1.5);
    bodies.push_with(body, gravity * mass * step);
    at_rest(&bodies)
}

/// Two to four bodies on each other, masses up to 1000 apart, with patches of contacts level or tilted.
pub(super) fn column(random: &mut Random) -> Candidate {
    let mut bodies = Assembly::new(3);
    let count = random.count(2, 4);
    let step = random.power_of_ten(-3.5, -2.0);
    let mut below = None;
    let mut height = 0.0;
    for _ in 0..count {
        let mass = random.exp(-3.5, 3.5);
        let half = random.vector_of(|random| 0.5 * random.exp(-1.0, 1.0));
        let center = Vector3::z() * (height + half.z);
        let body = bodies.push_box(mass, half, center, Vector3::zeros());
        let aside = random.pick(&[0.0, 0.3, -0.6]);
        let gravity = (Vector3::x() * aside - Vector3::z()) * GRAVITY;
        bodies.push_with(body, gravity * mass * step);
        let tilt = random.vector() * random.pick(&[0.0, 0.1]);
        for _ in 0..random.count(1, 12 / count) {
            let mut edge = |half: f64| half * random.sign() * random.uniform(0.3, 1.0);
            let point = Vector3::new(edge(half.x), edge(half.y), height);
            let mu = random.pick(&[0.05, 0.3, 0.6, 1.0]);
            bodies.touch((body, below), point, Vector3::z() + tilt, mu, 0.0);
        }
        below = Some(body);
        height += 2.0 * half.z;
    }
    bodies.before = random.normals(6 * count) * random.pick(&[0.0, 0.01, 1.0]);
    at_rest(&bodies)
}

/// An object between two to seven fingers, each with a mass matrix of three joints.
pub(super) fn grasp(random: &mut Random) -> Candidate {
    let fingers = random.count(2, 7);
    let n_dof = 6 + 3 * fingers;
    let mut parts = Parts::new(n_dof);
    let mass = random.exp(-4.0, 2.0);
    let size = random.vector_of(|random| random.exp(-3.0, -1.0));
    let mut object = parts.mass.fixed_view_mut::<6, 6>(0, 0);
    object.copy_from(&spatial_inertia(mass, size));
    parts.force[2] = -mass * GRAVITY;
    let mu = random.uniform(0.1, 1.2);
    for finger in 0..fingers {
        let first = 6 + 3 * finger;
        let any = random.matrix();
        let inertia = any * any.transpose() + Matrix3::identity() * 0.05;
        let mut joints = parts.mass.fixed_view_mut::<3, 3>(first, first);
        joints.copy_from(&(inertia * random.exp(-4.0, 0.0)));
        let normal = random.vector().normalize();
        let (frame, jacobian) = (frame(normal), random.matrix());
        let point = size.component_mul(&normal) * 0.5;
        let mut rows = Matrix3xX::zeros(n_dof);
        rows.fixed_columns_mut::<6>(0).copy_from(&(-frame * point_rows(point)));
        rows.fixed_columns_mut::<3>(first).copy_from(&(frame * jacobian));
        parts.touch(rows, mu);
        let squeeze = jacobian.transpose() * normal * random.uniform(0.0, 20.0);
        parts.force.fixed_rows_mut::<3>(first).copy_from(&-squeeze);
    }
    let before = random.normals(n_dof) * random.pick(&[0.0, 0.05]);
    let step = random.power_of_ten(-3.5, -2.0);
    parts.at_rest(&before, step)
}

/// Dense matrices of any kind, and surfaces that move; a few of these scenes have no solution.
pub(super) fn generic(random: &mut Random) -> Candidate {
    let (n_dof, contacts) = (random.count(2, 24), random.count(1, 8));
    let mut parts = Parts::new(n_dof);
    let any = DMatrix::from_fn(n_dof, n_dof, |_, _| random.normal());
    let least = DMatrix::identity(n_dof, n_dof) * random.power_of_ten(-4.0, 0.0);
    parts.mass = &any * any.transpose() + least;
    let units = DVector::from_fn(n_dof, |_, _| random.power_of_ten(-1.0, 1.0));
    for _ in 0..contacts {
        let rows = Matrix3xX::from_fn(n_dof, |_, j| random.normal() * units[j]);
        parts.touch(rows, random.uniform(0.0, 2.0));
    }
    let before = random.normals(n_dof);
    let mut scene = parts.scene(&before, 0.0);
    let witness = random.normals(n_dof);
    scene.w = -(&scene.h * &witness);
    let (gaps, belts) = (real(random.count(0, 1)), real(random.count(0, 1)));
    for normal in (0..3 * contacts).step_by(3) {
        scene.w[normal] += gaps * random.uniform(0.0, 1.0);
        scene.w[normal + 1] += belts * random.normal();
    }
    Candidate { scene, witness }
}
