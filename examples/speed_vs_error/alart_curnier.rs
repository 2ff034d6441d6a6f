//! Nonsmooth Newton on the function of Alart and Curnier (1991).
//!
//! `F = r - P`, with `y = r - rho u` and `P_N = max(y_N, 0)`, `P_T` the projection of `y_T` onto
//! the disc of radius `mu P_N`. `F' = (I - G) + G rho W` with the derivative `G` of `P`; contacts
//! with `P_N = 0` are taken out of the system. Safeguards: a small multiple of the identity, since
//! `W` may be singular, a line search on `|F|²`, and Gauss-Seidel sweeps where that fails.

use crate::contestant::{Contestant, Effort};
use crate::elimination::Elimination;
use crate::gauss_seidel::GaussSeidel;
use nalgebra::{SMatrix, SVector};
use stiction::Real;
use testbed::scene_file::SceneFile;

const STEPS: usize = 200;
/// Sweeps before the first Newton step, and after one that failed.
const SWEEPS: usize = 3;

/// `N` velocities, up to `C` contacts of `D` rows, `R = D·C`.
pub(crate) struct AlartCurnier<T: Real, const N: usize, const D: usize, const C: usize, const R: usize> {
    relaxed: GaussSeidel<T, N, D, C, R>,
    /// `rho` of the normal and of the tangents, for each contact.
    penalty: [[T; 2]; C],
    system: Elimination<T, R>,
    step: SVector<T, R>,
    velocity_step: SVector<T, R>,
    /// `P` of the last point evaluated, and `G` where it was asked for.
    projection: SVector<T, R>,
    derivative: [SMatrix<T, D, D>; C],
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize> AlartCurnier<T, N, D, C, R> {
    /// `None` where `M` is not positive definite in this number type.
    pub(crate) fn new(file: &SceneFile) -> Option<Self> {
        Some(Self {
            relaxed: GaussSeidel::new(file)?,
            penalty: [[T::ZERO; 2]; C],
            system: Elimination::new(),
            step: SVector::zeros(),
            velocity_step: SVector::zeros(),
            projection: SVector::zeros(),
            derivative: [SMatrix::zeros(); C],
        })
    }

    fn contacts(&self) -> usize {
        self.relaxed.mu.len()
    }

    fn penalty_of(&self, contact: usize, row: usize) -> T {
        self.penalty[contact][row.min(1)]
    }

    /// Sets `P` at `r + length d`; returns `|F|²`.
    fn evaluate(&mut self, length: T) -> T {
        let mut merit = T::ZERO;
        for (i, &mu) in self.relaxed.mu.iter().enumerate() {
            let at = |k: usize| i * D + k;
            let r = |k: usize| self.relaxed.r[at(k)] + length * self.step[at(k)];
            let y: SVector<T, D> = SVector::from_fn(|k, _| {
                let u = self.relaxed.u[at(k)] + length * self.velocity_step[at(k)];
                r(k) - self.penalty_of(i, k) * u
            });
            let normal = y[0].max(T::ZERO);
            let square = (1..D).fold(T::ZERO, |sum, k| sum + y[k] * y[k]);
            let radius = mu * normal;
            let shrink = if square > radius * radius { radius / square.square_root() } else { T::ONE };
            for k in 0..D {
                let p = if k == 0 { normal } else { shrink * y[k] };
                self.projection[at(k)] = p;
                merit += (r(k) - p) * (r(k) - p);
            }
        }
        merit
    }

    /// Sets `G` at `r`; zero for an open contact.
    fn differentiate(&mut self) {
        for (i, &mu) in self.relaxed.mu.iter().enumerate() {
            let y: SVector<T, D> = SVector::from_fn(|k, _| {
                self.relaxed.r[i * D + k] - self.penalty_of(i, k) * self.relaxed.u[i * D + k]
            });
            let derivative = &mut self.derivative[i];
            derivative.fill(T::ZERO);
            if y[0] <= T::ZERO {
                continue;
            }
            let length = (1..D).fold(T::ZERO, |sum, k| sum + y[k] * y[k]).square_root();
            derivative[(0, 0)] = T::ONE;
            let radius = mu * y[0];
            for a in 1..D {
                if length <= radius {
                    derivative[(a, a)] = T::ONE;
                    continue;
                }
                let direction = y[a] / length;
                derivative[(a, 0)] = mu * direction;
                for b in 1..D {
                    let unit = if a == b { T::ONE } else { T::ZERO };
                    derivative[(a, b)] = radius / length * (unit - direction * y[b] / length);
                }
            }
        }
    }

    /// The Newton step `d` with `(F' + regularisation I) d = -F`, and `W d`; `None` if singular.
    fn direction(&mut self, regularisation: T) -> Option<()> {
        let contacts = self.contacts();
        let closed = |g: &SMatrix<T, D, D>| g[(0, 0)] > T::ZERO;
        let space = &self.relaxed.space;
        self.velocity_step.fill(T::ZERO);
        for i in 0..contacts {
            let first = i * D;
            for row in first..first + D {
                self.step[row] = self.projection[row] - self.relaxed.r[row];
            }
            if !closed(&self.derivative[i]) {
                let d: SVector<T, D> = self.step.fixed_rows::<D>(first).into();
                if d.norm_squared() > T::ZERO {
                    space.add(&mut self.velocity_step, first, &d);
                }
            }
        }
        self.system.clear();
        for i in (0..contacts).filter(|&i| closed(&self.derivative[i])) {
            let scaled: SMatrix<T, D, D> =
                SMatrix::from_fn(|a, b| self.derivative[i][(a, b)] * self.penalty_of(i, b));
            let known: SVector<T, D> = scaled * self.velocity_step.fixed_rows::<D>(i * D);
            for a in 0..D {
                let (row, rhs) = self.system.push();
                *rhs = self.step[i * D + a] - known[a];
                let closed = (0..contacts).filter(|&j| closed(&self.derivative[j]));
                for (j, entries) in closed.zip(row.chunks_exact_mut(D)) {
                    for (b, entry) in entries.iter_mut().enumerate() {
                        // W is symmetric: rows i of column j·D + b lie next to each other.
                        let column = &space.delassus.as_slice()[(j * D + b) * R + i * D..][..D];
                        *entry = (0..D).fold(T::ZERO, |sum, k| sum + scaled[(a, k)] * column[k]);
                        if i == j {
                            *entry -= self.derivative[i][(a, b)];
                            if a == b {
                                *entry += T::ONE + regularisation;
                            }
                        }
                    }
                }
            }
        }
        let solution = self.system.solve()?;
        let mut solution = solution.chunks_exact(D);
        for i in (0..contacts).filter(|&i| closed(&self.derivative[i])) {
            let d: SVector<T, D> = SVector::from_column_slice(solution.next()?);
            self.step.fixed_rows_mut::<D>(i * D).copy_from(&d);
            space.add(&mut self.velocity_step, i * D, &d);
        }
        Some(())
    }

    /// Goes the longest of a few lengths that reduces `|F|²`; its new value, or `None`.
    fn search(&mut self, merit: T) -> Option<T> {
        let mut length = T::ONE;
        for _ in 0..6 {
            let trial = self.evaluate(length);
            if trial <= (T::ONE - T::literal(2e-4) * length) * merit {
                self.relaxed.r += self.step * length;
                self.relaxed.u += self.velocity_step * length;
                return Some(trial);
            }
            length *= T::literal(0.5);
        }
        None
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize> Contestant
    for AlartCurnier<T, N, D, C, R>
{
    fn prepare(&mut self) {
        self.relaxed.prepare();
        for i in 0..self.contacts() {
            let entry = |k: usize| self.relaxed.space.delassus[(i * D + k, i * D + k)];
            let tangents = (1..D).fold(T::ZERO, |sum, k| sum + entry(k));
            let inverse = |x: T| if x > T::ZERO { T::ONE / x } else { T::ZERO };
            self.penalty[i] = [inverse(entry(0)), T::count(D - 1) * inverse(tangents)];
        }
    }

    fn solve(&mut self, tolerance: f64) -> Effort {
        let tolerance = T::literal(tolerance);
        self.relaxed.begin();
        self.step.fill(T::ZERO);
        self.velocity_step.fill(T::ZERO);
        let mut expected = T::ZERO;
        for i in 0..self.contacts() {
            for k in 0..D {
                let impulse = self.penalty_of(i, k) * self.relaxed.space.q[i * D + k];
                expected += impulse * impulse;
            }
        }
        let mut effort = Effort { iterations: 0, newton_steps: 0, finished: false };
        let mut sweeps = SWEEPS;
        // Grows when a step fails, and shrinks with the residual.
        let mut caution = T::literal(1e-3);
        let mut merit = T::ZERO;
        while effort.newton_steps < STEPS {
            if sweeps > 0 {
                for _ in 0..sweeps {
                    self.relaxed.sweep();
                }
                effort.iterations += sweeps;
                sweeps = 0;
                merit = self.evaluate(T::ZERO);
            }
            let size = expected.max(self.relaxed.r.norm_squared());
            if merit <= tolerance * tolerance * size {
                effort.finished = true;
                break;
            }
            let residual = (merit / size).square_root();
            let regularisation = (caution * residual).max(T::EPSILON * T::literal(4.0));
            self.differentiate();
            effort.newton_steps += 1;
            let step = self.direction(regularisation);
            if let Some(reduced) = step.and_then(|()| self.search(merit)) {
                merit = reduced;
                caution = (caution * T::literal(0.3)).max(T::literal(1e-6));
            } else {
                caution = (caution * T::literal(10.0)).min(T::ONE);
                sweeps = 10;
            }
        }
        self.relaxed.space.finish(&self.relaxed.r);
        effort
    }

    fn answer(&self) -> (Vec<f64>, Vec<f64>) {
        self.relaxed.space.answer(&self.relaxed.r)
    }
}
