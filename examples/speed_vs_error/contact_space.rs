//! A scene as methods in contact space see it: `u = W r + q`.
//!
//! With `M = L Lᵀ` and `X = L⁻¹ Hᵀ`: `W = XᵀX`, `q = w - Xᵀ L⁻¹ f`, `v = L⁻ᵀ (X r - L⁻¹ f)`.

use nalgebra::{Cholesky, Const, SMatrix, SVector};
use stiction::Real;
use testbed::scene_file::SceneFile;

/// `N` velocities, up to `R` contact rows.
pub(crate) struct ContactSpace<T: Real, const N: usize, const R: usize> {
    /// Rows in use.
    rows: usize,
    n_dof: usize,
    mass: SMatrix<T, N, N>,
    jacobian: SMatrix<T, R, N>,
    offset: SVector<T, R>,
    f: SVector<T, N>,
    cholesky: Cholesky<T, Const<N>>,
    /// `X`
    whitened: SMatrix<T, N, R>,
    /// `W`
    pub(crate) delassus: SMatrix<T, R, R>,
    /// `L⁻¹ f`
    free: SVector<T, N>,
    pub(crate) q: SVector<T, R>,
    velocity: SVector<T, N>,
}

impl<T: Real, const N: usize, const R: usize> ContactSpace<T, N, R> {
    /// Pads with decoupled velocities of unit mass (a scene of the kernel has as many as it needs); `None` where `M` is not
    /// positive definite in this number type.
    pub(crate) fn new(file: &SceneFile) -> Option<Self> {
        let mass = SMatrix::from_fn(|i, j| {
            let unit = if i == j { 1.0 } else { 0.0 };
            T::literal(*file.mass.get((i, j)).unwrap_or(&unit))
        });
        Some(Self {
            rows: file.dim * file.n_contacts,
            n_dof: file.n_dof,
            mass,
            jacobian: SMatrix::from_fn(|i, j| T::literal(*file.h.get((i, j)).unwrap_or(&0.0))),
            offset: SVector::from_fn(|i, _| T::literal(*file.w.get(i).unwrap_or(&0.0))),
            f: -file.free_impulse::<T, N>(),
            cholesky: mass.cholesky()?,
            whitened: SMatrix::zeros(),
            delassus: SMatrix::zeros(),
            free: SVector::zeros(),
            q: SVector::zeros(),
            velocity: SVector::zeros(),
        })
    }

    /// `X` and `W`, for the rows in use.
    pub(crate) fn prepare(&mut self) {
        self.cholesky = self.mass.cholesky().expect("M is positive definite");
        let factor = self.cholesky.l_dirty();
        for j in 0..self.rows {
            let mut column: SVector<T, N> = self.jacobian.row(j).transpose();
            factor.solve_lower_triangular_mut(&mut column);
            self.whitened.set_column(j, &column);
            for i in 0..=j {
                let entry = self.whitened.column(i).dot(&column);
                self.delassus[(i, j)] = entry;
                self.delassus[(j, i)] = entry;
            }
        }
    }

    /// `q`, from `f`.
    pub(crate) fn begin(&mut self) {
        self.free = self.f;
        let factor = self.cholesky.l_dirty();
        factor.solve_lower_triangular_mut(&mut self.free);
        self.q = self.offset;
        for (q, column) in self.q.iter_mut().zip(self.whitened.column_iter()).take(self.rows) {
            *q -= column.dot(&self.free);
        }
    }

    /// `v`, from `r`.
    pub(crate) fn finish(&mut self, r: &SVector<T, R>) {
        self.velocity = -self.free;
        for (&r, column) in r.iter().zip(self.whitened.column_iter()).take(self.rows) {
            if r != T::ZERO {
                self.velocity.axpy(r, &column, T::ONE);
            }
        }
        let factor = self.cholesky.l_dirty();
        factor.tr_solve_lower_triangular_mut(&mut self.velocity);
    }

    /// `u += W[:, first..first + D] step`
    pub(crate) fn add<const D: usize>(&self, u: &mut SVector<T, R>, first: usize, step: &SVector<T, D>) {
        let u = &mut u.as_mut_slice()[..self.rows];
        let column = |k: usize| &self.delassus.as_slice()[(first + k) * R..][..self.rows];
        if D == 3 {
            let columns = column(0).iter().zip(column(1)).zip(column(2));
            for (u, ((&a, &b), &c)) in u.iter_mut().zip(columns) {
                *u += a * step[0] + b * step[1] + c * step[2];
            }
            return;
        }
        for (k, &step) in step.iter().enumerate() {
            for (u, &w) in u.iter_mut().zip(column(k)) {
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
