//! Spatial scenes put together from a mass matrix and the rows of their contacts.

use super::Candidate;
use crate::scene_file::SceneFile;
use nalgebra::{DMatrix, DVector, Matrix3, Matrix3x6, Matrix3xX, Matrix6, Vector3};

/// The normal of a contact and two tangents, as rows.
pub(super) fn frame(normal: Vector3<f64>) -> Matrix3<f64> {
    let normal = normal.normalize();
    let other = if normal.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let tangent = normal.cross(&other).normalize();
    let rows = [normal, tangent, normal.cross(&tangent)];
    Matrix3::from_rows(&rows.map(|row| row.transpose()))
}

/// The velocity of a point of a body by that of its origin and its rotation.
pub(super) fn point_rows(point: Vector3<f64>) -> Matrix3x6<f64> {
    let mut rows = Matrix3x6::zeros();
    rows.fixed_columns_mut::<3>(0).copy_from(&Matrix3::identity());
    rows.fixed_columns_mut::<3>(3).copy_from(&-point.cross_matrix());
    rows
}

/// The mass matrix of a box of these side lengths about its centre.
pub(super) fn spatial_inertia(mass: f64, size: Vector3<f64>) -> Matrix6<f64> {
    let square = size.component_mul(&size);
    let rotation = (Vector3::repeat(square.sum()) - square) * (mass / 12.0);
    let mut inertia = Matrix6::identity() * mass;
    inertia.fixed_view_mut::<3, 3>(3, 3).copy_from(&Matrix3::from_diagonal(&rotation));
    inertia
}

/// A mass matrix, forces and contacts.
pub(super) struct Parts {
    pub(super) mass: DMatrix<f64>,
    pub(super) force: DVector<f64>,
    rows: Vec<Matrix3xX<f64>>,
    mu: Vec<f64>,
}

impl Parts {
    pub(super) fn new(n_dof: usize) -> Self {
        Self {
            mass: DMatrix::zeros(n_dof, n_dof),
            force: DVector::zeros(n_dof),
            rows: Vec::new(),
            mu: Vec::new(),
        }
    }

    pub(super) fn contacts(&self) -> usize {
        self.mu.len()
    }

    /// Adds a contact with its three rows of `H`.
    pub(super) fn touch(&mut self, rows: Matrix3xX<f64>, mu: f64) {
        self.rows.push(rows);
        self.mu.push(mu);
    }

    /// The scene of a time step that starts with the velocity `before`, with `w = 0`.
    pub(super) fn scene(self, before: &DVector<f64>, step: f64) -> SceneFile {
        let (n_dof, n_contacts) = (self.force.len(), self.contacts());
        let mass = (&self.mass + self.mass.transpose()) * 0.5;
        let rows = 3 * n_contacts;
        SceneFile {
            name: String::new(),
            n_dof,
            n_contacts,
            dim: 3,
            h: DMatrix::from_fn(rows, n_dof, |i, j| self.rows[i / 3][(i % 3, j)]),
            f: -(&mass * before + self.force * step),
            mass,
            w: DVector::zeros(rows),
            mu: self.mu,
            keys: vec![0; n_contacts],
        }
    }

    /// [`Parts::scene`], of which rest is in `K*`.
    pub(super) fn at_rest(self, before: &DVector<f64>, step: f64) -> Candidate {
        let scene = self.scene(before, step);
        let witness = DVector::zeros(scene.n_dof);
        Candidate { scene, witness }
    }
}
