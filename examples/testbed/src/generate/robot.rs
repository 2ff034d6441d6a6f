//! Robots with a floating base and two to five limbs of three joints.

use super::Candidate;
use super::bodies::GRAVITY;
use super::parts::{Parts, frame, point_rows, spatial_inertia};
use super::random::Random;
use nalgebra::{Matrix3xX, Matrix6xX, Vector3};

/// Joints of a limb.
const JOINTS: usize = 3;
const BASE: Vector3<f64> = Vector3::new(0.5, 0.3, 0.2);
const LINK: Vector3<f64> = Vector3::new(0.05, 0.05, 0.2);

/// A limb: its first velocity, and its joints from the hip to the foot.
struct Limb {
    first: usize,
    points: [Vector3<f64>; JOINTS + 1],
}

impl Limb {
    fn new(random: &mut Random, first: usize) -> Self {
        let mut points = [random.vector() * 0.3; JOINTS + 1];
        for j in 0..JOINTS {
            points[j + 1] = points[j] + random.vector() * 0.1 - Vector3::z() * 0.2;
        }
        Self { first, points }
    }

    /// A hip turns about x, the other joints about y.
    fn axis(joint: usize) -> Vector3<f64> {
        if joint == 0 { Vector3::x() } else { Vector3::y() }
    }

    /// Three rows for the velocity of a point that the first `joints` joints move.
    fn point(&self, n_dof: usize, point: Vector3<f64>, joints: usize) -> Matrix3xX<f64> {
        let mut rows = Matrix3xX::zeros(n_dof);
        rows.fixed_columns_mut::<6>(0).copy_from(&point_rows(point));
        for joint in 0..joints {
            let turn = Self::axis(joint).cross(&(point - self.points[joint]));
            rows.set_column(self.first + joint, &turn);
        }
        rows
    }

    /// Six rows for the velocity of the centre of the link behind a joint and for its rotation.
    fn link(&self, n_dof: usize, joint: usize) -> Matrix6xX<f64> {
        let center = (self.points[joint] + self.points[joint + 1]) * 0.5;
        let mut rows = Matrix6xX::zeros(n_dof);
        rows.rows_mut(0, 3).copy_from(&self.point(n_dof, center, joint + 1));
        rows.view_mut((3, 3), (3, 3)).fill_with_identity();
        for moved_by in 0..=joint {
            rows.fixed_view_mut::<3, 1>(3, self.first + moved_by).copy_from(&Self::axis(moved_by));
        }
        rows
    }
}

/// A robot on none to two contacts a foot, level or tilted, some with a gap.
pub(super) fn robot(random: &mut Random) -> Candidate {
    let limbs = random.count(2, 5);
    let n_dof = 6 + JOINTS * limbs;
    let mut parts = Parts::new(n_dof);
    let mass = random.exp(0.0, 4.0);
    let mut base = parts.mass.fixed_view_mut::<6, 6>(0, 0);
    base.copy_from(&spatial_inertia(mass, BASE));
    for limb in 0..limbs {
        let limb = Limb::new(random, 6 + JOINTS * limb);
        for joint in 0..JOINTS {
            let inertia = spatial_inertia(mass * random.uniform(0.01, 0.1), LINK);
            let rows = limb.link(n_dof, joint);
            parts.mass += rows.transpose() * inertia * &rows;
            let dof = limb.first + joint;
            parts.mass[(dof, dof)] += 0.005 * mass.sqrt();
        }
        for _ in 0..random.count(0, 2) {
            let point = limb.points[JOINTS] + random.vector() * 0.02;
            let tilt = random.vector() * random.pick(&[0.0, 0.3]);
            let rows = frame(Vector3::z() + tilt) * limb.point(n_dof, point, JOINTS);
            parts.touch(rows, random.uniform(0.1, 1.3));
        }
    }
    if parts.contacts() == 0 {
        let mut rows = Matrix3xX::zeros(n_dof);
        let under = frame(Vector3::z()) * point_rows(Vector3::new(0.1, 0.1, -0.5));
        rows.fixed_columns_mut::<6>(0).copy_from(&under);
        parts.touch(rows, random.uniform(0.1, 1.3));
    }
    let torque = mass * random.pick(&[0.0, 1.0]);
    parts.force.apply(|force| *force = torque * random.normal());
    parts.force.rows_mut(0, 6).fill(0.0);
    parts.force[2] = -1.3 * GRAVITY * mass;
    let before = random.normals(n_dof) * random.pick(&[0.0, 0.1, 1.0]);
    let mut candidate = parts.at_rest(&before, random.power_of_ten(-3.5, -2.0));
    for w in candidate.scene.w.iter_mut().step_by(3) {
        *w = random.pick(&[0.0, 0.0, 0.02, 1.0]);
    }
    candidate
}
