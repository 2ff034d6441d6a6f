//! Classes of scenes without bodies: any mass matrix, any Jacobian.

use super::random::{Random, real};
use super::{Candidate, Existence};
use crate::scene_file::SceneFile;
use nalgebra::{DMatrix, DVector};

/// Friction coefficients that differ as much as they can.
const MIXED: [f64; 4] = [0.0, 1e-6, 5.0, 10.0];
/// How far a repeated contact is from its original, relative.
const NEARLY: [f64; 4] = [0.0, 1e-12, 1e-8, 1e-4];

/// Sizes and friction of a scene to come.
struct Shape {
    n_dof: usize,
    dim: usize,
    /// Condition number of the mass matrix.
    condition: f64,
    mu: Vec<f64>,
}

impl Shape {
    fn new(random: &mut Random, n_dof: usize, contacts: usize) -> Self {
        let usual = random.friction();
        let each = random.one_in(4);
        let mu = (0..contacts).map(|_| if each { random.friction() } else { usual });
        Self { mu: mu.collect(), n_dof, dim: random.dimension(), condition: random.log_uniform(1.0, 1e4) }
    }

    /// A matrix with eigenvalues from 1 down to 1 / condition, evenly in the logarithm.
    fn mass(&self, random: &mut Random) -> DMatrix<f64> {
        let n = self.n_dof;
        let basis = DMatrix::from_fn(n, n, |_, _| random.normal()).qr().q();
        let ratio = libm::pow(self.condition, -1.0 / real(n.max(2) - 1));
        let mut eigenvalue = 1.0;
        let eigenvalues = DVector::from_fn(n, |_, _| {
            eigenvalue *= ratio;
            eigenvalue / ratio
        });
        let mass = &basis * DMatrix::from_diagonal(&eigenvalues) * basis.transpose();
        (&mass + mass.transpose()) * 0.5
    }

    /// A point of `K*`, on its boundary now and then.
    fn cone_point(&self, random: &mut Random) -> DVector<f64> {
        let mut point = DVector::zeros(self.dim * self.mu.len());
        for (i, mu) in self.mu.iter().enumerate() {
            let sliding = random.pick(&[0.0, 1.0]);
            let mut tangent = point.rows_mut(i * self.dim + 1, self.dim - 1);
            tangent.iter_mut().for_each(|u| *u = sliding * random.normal());
            let boundary = mu * tangent.norm();
            let inside = random.uniform(0.0, 1.0);
            point[i * self.dim] = boundary + random.pick(&[0.0, inside, inside, inside]);
        }
        point
    }

    /// A scene with a velocity in `K*`: rest and `w = 0`, or some velocity and `w` to suit it.
    fn scene(self, random: &mut Random) -> Candidate {
        let rows = self.dim * self.mu.len();
        let density = random.pick(&[1.0, 1.0, 0.6, 0.3]);
        let h = DMatrix::from_fn(rows, self.n_dof, |_, _| {
            random.normal() * f64::from(u8::from(random.uniform(0.0, 1.0) < density))
        });
        let (mut witness, mut w) = (DVector::zeros(self.n_dof), DVector::zeros(rows));
        if !random.one_in(3) {
            witness = witness.map(|_| random.normal());
            w = self.cone_point(random) - &h * &witness;
        }
        let mass = self.mass(random);
        let free = DVector::from_fn(self.n_dof, |_, _| random.normal());
        let scene = SceneFile {
            name: String::new(),
            n_dof: self.n_dof,
            n_contacts: self.mu.len(),
            dim: self.dim,
            f: -&mass * free,
            mass,
            h,
            w,
            keys: vec![0; self.mu.len()],
            mu: self.mu,
        };
        Candidate { scene, witness }
    }
}

fn any_shape(random: &mut Random) -> Shape {
    let (n_dof, contacts) = (random.count(1, 30), random.count(1, 12));
    Shape::new(random, n_dof, contacts)
}

/// Friction coefficients 0, 1e-6, 5 and 10 in one scene.
pub(super) fn mixed_friction(random: &mut Random) -> Candidate {
    let mut shape = any_shape(random);
    shape.mu.iter_mut().for_each(|mu| *mu = random.pick(&MIXED));
    shape.scene(random)
}

/// No free impulse.
pub(super) fn unloaded(random: &mut Random) -> Candidate {
    let mut candidate = any_shape(random).scene(random);
    candidate.scene.f.fill(0.0);
    candidate
}

/// The free velocity opens all contacts.
pub(super) fn open(random: &mut Random) -> Candidate {
    let shape = any_shape(random);
    let mut away = shape.cone_point(random);
    let normals = away.iter_mut().step_by(shape.dim);
    normals.for_each(|u| *u += random.uniform(0.01, 1.0));
    let Candidate { mut scene, witness } = shape.scene(random);
    scene.w = away - &scene.h * &witness;
    scene.f = -&scene.mass * &witness;
    Candidate { scene, witness }
}

/// One velocity, up to four contacts.
pub(super) fn one_dof(random: &mut Random) -> Candidate {
    let contacts = random.count(1, 4);
    Shape::new(random, 1, contacts).scene(random)
}

/// A mass matrix of condition up to 1e10, for velocities of size 1.
pub(super) fn near_singular(random: &mut Random) -> Candidate {
    let n_dof = random.count(2, 30);
    let contacts = random.count(1, 12);
    let any = random.log_uniform(1e4, 1e10);
    let mut shape = Shape::new(random, n_dof, contacts);
    shape.condition = random.pick(&[any, 1e10]);
    shape.scene(random)
}

/// Contacts that are multiples of others, exactly or nearly 1.
pub(super) fn repeated(random: &mut Random) -> Candidate {
    let Candidate { mut scene, witness } = any_shape(random).scene(random);
    let dim = scene.dim;
    for i in 1..scene.n_contacts {
        if random.one_in(2) {
            let original = random.count(0, i - 1);
            let factor = 1.0 + random.pick(&NEARLY);
            let (from, to) = (original * dim, i * dim);
            let rows = scene.h.rows(from, dim) * factor;
            scene.h.rows_mut(to, dim).copy_from(&rows);
            let offset = scene.w.rows(from, dim) * factor;
            scene.w.rows_mut(to, dim).copy_from(&offset);
            scene.mu[i] = scene.mu[original];
        }
    }
    Candidate { scene, witness }
}

/// Two or three contacts whose normals add up to nothing, `sum d_i H_Ni = 0`, and other contacts.
///
/// They leave room of the relative size `room`, or want as much too much if it is negative. All
/// numbers in that sum are short, so that it is exactly zero in f32 as well.
fn between_walls(random: &mut Random, room: f64) -> Candidate {
    let (n_dof, walls) = (random.count(2, 12), random.count(2, 3));
    let contacts = walls + random.count(0, 4);
    let shape = Shape::new(random, n_dof, contacts);
    let dim = shape.dim;
    let away = shape.cone_point(random);
    let Candidate { mut scene, witness } = shape.scene(random);
    let short = |x: f64, unit: f64| (x / unit).round() * unit;
    let witness = witness.map(|_| short(random.uniform(-2.0, 2.0), 0.0625));
    scene.h.apply(|h| *h = short(*h, 1.0 / 256.0));
    let last = (walls - 1) * dim;
    scene.h.row_mut(last).fill(0.0);
    for wall in 0..walls - 1 {
        let row = scene.h.row(wall * dim) * random.pick(&[1.0, 2.0, 3.0]);
        let mut sum = scene.h.row_mut(last);
        sum -= row;
    }
    let velocity = &scene.h * &witness;
    scene.w = away - &velocity;
    let normals = || (0..walls).map(|wall| wall * dim);
    let size = normals().map(|row| velocity[row].abs()).fold(0.0, f64::max);
    for row in normals() {
        scene.w.rows_mut(row, dim).copy_from(&-velocity.rows(row, dim));
        scene.w[row] += room * if size > 0.0 { size } else { 1.0 };
    }
    Candidate { scene, witness }
}

/// Walls that close on a body: no velocity keeps clear of all of them.
pub(super) fn squeeze(random: &mut Random) -> (SceneFile, Existence) {
    let overlap = random.pick(&[1e-3, 1e-1, 1.0]);
    let candidate = between_walls(random, -overlap);
    (candidate.scene, Existence::Infeasible)
}

/// Walls that leave a millionth of their speed between them.
pub(super) fn narrow(random: &mut Random) -> Candidate {
    between_walls(random, 1e-6)
}
