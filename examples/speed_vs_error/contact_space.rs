//! A scene as methods in contact space see it: `u = W r + q`, `v = v_free + M⁻¹ Hᵀ r`.

use crate::support::scene_file::SceneFile;
use nalgebra::{Cholesky, Const, SMatrix, SVector};
use stiction::Real;

/// `N` velocities, up to `R` contact rows.
pub(crate) struct ContactSpace<T: Real, const N: usize, const R: usize> {
    /// Rows in use.
    pub(crate) rows: usize,
    n_dof: usize,
    mass: SMatrix<T, N, N>,
    jacobian: SMatrix<T, R, N>,
    offset: SVector<T, R>,
    f: SVector<T, N>,
    cholesky: Cholesky<T, Const<N>>,
    /// `M⁻¹ Hᵀ`
    response: SMatrix<T, N, R>,
    /// `W = H M⁻¹ Hᵀ`
    pub(crate) delassus: SMatrix<T, R, R>,
    free: SVector<T, N>,
    /// `q = H v_free + w`
    pub(crate) q: SVector<T, R>,
    velocity: SVector<T, N>,
}

impl<T: Real, const N: usize, const R: usize> ContactSpace<T, N, R> {
    /// Pads with decoupled velocities of unit mass, as the kernel's scenes are padded.
    pub(crate) fn new(file: &SceneFile) -> Self {
        let mass = SMatrix::from_fn(|i, j| {
            let unit = if i == j { 1.0 } else { 0.0 };
            T::literal(*file.mass.get((i, j)).unwrap_or(&unit))
        });
        let mut space = Self {
            rows: file.dim * file.n_contacts,
            n_dof: file.n_dof,
            mass,
            jacobian: SMatrix::from_fn(|i, j| T::literal(*file.h.get((i, j)).unwrap_or(&0.0))),
            offset: SVector::from_fn(|i, _| T::literal(*file.w.get(i).unwrap_or(&0.0))),
            f: file.free_impulse(),
            cholesky: mass.cholesky().expect("M is positive definite"),
            response: SMatrix::zeros(),
            delassus: SMatrix::zeros(),
            free: SVector::zeros(),
            q: SVector::zeros(),
            velocity: SVector::zeros(),
        };
        space.prepare();
        space
    }

    /// `M⁻¹ Hᵀ` and `W`, for the rows in use.
    pub(crate) fn prepare(&mut self) {
        self.cholesky = self.mass.cholesky().expect("M is positive definite");
        self.response = self.jacobian.transpose();
        let rows = self.rows;
        for j in 0..rows {
            let mut response = self.response.column_mut(j);
            self.cholesky.solve_mut(&mut response);
            let jacobian = self.jacobian.rows(0, rows);
            let mut column = self.delassus.column_mut(j);
            let mut column = column.rows_mut(0, rows);
            column.gemv(T::ONE, &jacobian, &response, T::ZERO);
        }
    }

    /// `v_free` and `q`.
    pub(crate) fn begin(&mut self) {
        self.free = -self.f;
        self.cholesky.solve_mut(&mut self.free);
        self.q = self.offset + self.jacobian * self.free;
    }

    /// `v` from impulses.
    pub(crate) fn finish(&mut self, r: &SVector<T, R>) {
        self.velocity = self.free;
        let rows = self.rows;
        let response = self.response.columns(0, rows);
        self.velocity
            .gemv(T::ONE, &response, &r.rows(0, rows), T::ONE);
    }

    /// `u += W[:, first..first + D] step`
    pub(crate) fn add<const D: usize>(
        &self,
        u: &mut SVector<T, R>,
        first: usize,
        step: &SVector<T, D>,
    ) {
        let u = &mut u.as_mut_slice()[..self.rows];
        if D == 3 {
            let column = |k: usize| &self.delassus.as_slice()[(first + k) * R..][..self.rows];
            let columns = column(0).iter().zip(column(1)).zip(column(2));
            for (u, ((&a, &b), &c)) in u.iter_mut().zip(columns) {
                *u += a * step[0] + b * step[1] + c * step[2];
            }
            return;
        }
        for (k, &step) in step.iter().enumerate() {
            let column = &self.delassus.as_slice()[(first + k) * R..][..self.rows];
            for (u, &w) in u.iter_mut().zip(column) {
                *u += w * step;
            }
        }
    }

    /// `v` and `r` in f64, without padding.
    pub(crate) fn answer(&self, r: &SVector<T, R>) -> (Vec<f64>, Vec<f64>) {
        let double = |x: &T| x.to_subset().unwrap_or(f64::NAN);
        (
            self.velocity.iter().take(self.n_dof).map(double).collect(),
            r.iter().take(self.rows).map(double).collect(),
        )
    }
}
