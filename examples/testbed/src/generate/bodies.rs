//! Rigid bodies and the contacts between them, in space or in the plane (x, z).

use super::Candidate;
use super::random::Random;
use crate::scene_file::SceneFile;
use nalgebra::{DMatrix, DVector, Vector3};

/// Length of a time step, s.
pub(super) const STEP: f64 = 1e-2;
/// Acceleration of gravity, m/s².
pub(super) const GRAVITY: f64 = 9.81;
pub(super) const DOWN: Vector3<f64> = Vector3::new(0.0, 0.0, -GRAVITY);

/// Dofs of a body: three translations and three rotations; those that stay in the plane.
const SPATIAL: [usize; 6] = [0, 1, 2, 3, 4, 5];
const PLANAR: [usize; 3] = [0, 2, 4];

struct Body {
    mass: f64,
    inertia: Vector3<f64>,
    center: Vector3<f64>,
}

struct Touch {
    body: usize,
    /// The other body, or the ground.
    other: Option<usize>,
    point: Vector3<f64>,
    /// Normal, out of the other body, and two tangents.
    frame: [Vector3<f64>; 3],
    mu: f64,
}

/// Bodies, their contacts, and how they move before the step.
///
/// Motions have six entries a body, also in the plane.
pub(super) struct Assembly {
    pub(super) dim: usize,
    bodies: Vec<Body>,
    touches: Vec<Touch>,
    /// Velocity before the step.
    pub(super) before: DVector<f64>,
    /// Impulse of the other forces during the step.
    pub(super) impulse: DVector<f64>,
}

impl Assembly {
    pub(super) fn new(dim: usize) -> Self {
        Self {
            dim,
            bodies: Vec::new(),
            touches: Vec::new(),
            before: DVector::zeros(0),
            impulse: DVector::zeros(0),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.bodies.len()
    }

    /// A body at rest under gravity `g`.
    pub(super) fn push(
        &mut self,
        mass: f64,
        inertia: Vector3<f64>,
        center: Vector3<f64>,
        g: Vector3<f64>,
    ) -> usize {
        let body = self.bodies.len();
        self.bodies.push(Body { mass, inertia, center });
        self.before.resize_vertically_mut(6 * self.len(), 0.0);
        self.impulse.resize_vertically_mut(6 * self.len(), 0.0);
        self.push_with(body, g * mass * STEP);
        body
    }

    /// A box of half lengths `half` at rest under gravity `g`.
    pub(super) fn push_box(
        &mut self,
        mass: f64,
        half: Vector3<f64>,
        center: Vector3<f64>,
        g: Vector3<f64>,
    ) -> usize {
        let square = half.component_mul(&half);
        let inertia = (Vector3::repeat(square.sum()) - square) * (mass / 3.0);
        self.push(mass, inertia, center, g)
    }

    /// Adds an impulse at the centre of a body.
    pub(super) fn push_with(&mut self, body: usize, impulse: Vector3<f64>) {
        let mut entries = self.impulse.fixed_rows_mut::<3>(6 * body);
        entries += impulse;
    }

    /// A contact; `yaw` turns the tangents of a spatial one.
    pub(super) fn touch(
        &mut self,
        (body, other): (usize, Option<usize>),
        point: Vector3<f64>,
        normal: Vector3<f64>,
        mu: f64,
        yaw: f64,
    ) {
        let normal = normal.normalize();
        let side = if self.dim == 2 {
            Vector3::y()
        } else if normal.x.abs() > 0.9 {
            normal.cross(&Vector3::y()).normalize()
        } else {
            normal.cross(&Vector3::x()).normalize()
        };
        let along = side.cross(&normal);
        let (sin, cos) = libm::sincos(yaw);
        let frame = [normal, along * cos + side * sin, side * cos - along * sin];
        self.touches.push(Touch {
            body,
            other,
            point,
            frame: if self.dim == 2 { [normal, along, side] } else { frame },
            mu,
        });
    }

    /// The dofs that are there of a motion or impulse.
    pub(super) fn dofs(&self, motion: &DVector<f64>) -> DVector<f64> {
        let kept = if self.dim == 2 { &PLANAR[..] } else { &SPATIAL[..] };
        let bodies = 0..self.len();
        let entries = bodies.flat_map(|body| kept.iter().map(move |k| motion[6 * body + k]));
        let n = kept.len() * self.len();
        DVector::from_iterator(n, entries)
    }

    fn row(&self, touch: &Touch, direction: &Vector3<f64>) -> DVector<f64> {
        let mut row = DVector::zeros(6 * self.len());
        let sides = [(Some(touch.body), 1.0), (touch.other, -1.0)];
        for (body, sign) in sides {
            if let Some(body) = body {
                let arm = touch.point - self.bodies[body].center;
                row.fixed_rows_mut::<3>(6 * body).copy_from(&(direction * sign));
                row.fixed_rows_mut::<3>(6 * body + 3).copy_from(&(arm.cross(direction) * sign));
            }
        }
        self.dofs(&row)
    }

    /// The scene, with `w = 0`.
    pub(super) fn scene(&self) -> SceneFile {
        let inertia = DVector::from_iterator(
            6 * self.len(),
            self.bodies.iter().flat_map(|body| {
                let rotation = body.inertia.iter().copied();
                [body.mass; 3].into_iter().chain(rotation)
            }),
        );
        let momentum = inertia.component_mul(&self.before) + &self.impulse;
        let rows: Vec<_> = self
            .touches
            .iter()
            .flat_map(|touch| touch.frame[..self.dim].iter().map(|d| self.row(touch, d)))
            .map(|row| row.transpose())
            .collect();
        let mass = self.dofs(&inertia);
        SceneFile {
            name: String::new(),
            n_dof: mass.len(),
            n_contacts: self.touches.len(),
            dim: self.dim,
            mass: DMatrix::from_diagonal(&mass),
            w: DVector::zeros(rows.len()),
            h: DMatrix::from_rows(&rows),
            f: -self.dofs(&momentum),
            mu: self.touches.iter().map(|touch| touch.mu).collect(),
            keys: vec![0; self.touches.len()],
        }
    }
}

/// `w = 0`: rest is in `K*`.
pub(super) fn at_rest(bodies: &Assembly) -> Candidate {
    let scene = bodies.scene();
    let witness = DVector::zeros(scene.n_dof);
    Candidate { scene, witness }
}

/// The corners of a rectangle, or the ends of a segment in the plane.
pub(super) fn corners(dim: usize, x: f64, y: f64) -> Vec<Vector3<f64>> {
    if dim == 2 {
        return [-x, x].map(|x| Vector3::new(x, 0.0, 0.0)).to_vec();
    }
    [(-x, -y), (-x, y), (x, -y), (x, y)].map(|(x, y)| Vector3::new(x, y, 0.0)).to_vec()
}

/// A unit vector at an angle around the vertical, or in the vertical plane.
pub(super) fn around(dim: usize, angle: f64, lift: f64) -> Vector3<f64> {
    let (sin, cos) = libm::sincos(angle);
    if dim == 2 { Vector3::new(cos, 0.0, sin) } else { Vector3::new(cos, sin, lift).normalize() }
}

/// Rest, any motion, sliding or spinning.
pub(super) fn set_in_motion(bodies: &mut Assembly, random: &mut Random) {
    let dofs: &[usize] = random.pick(&[&[][..], &[0, 1, 2, 3, 4, 5], &[0, 1], &[5]]);
    for body in 0..bodies.len() {
        for dof in dofs {
            bodies.before[6 * body + dof] = random.normal();
        }
    }
}
