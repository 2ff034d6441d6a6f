//! The Clarabel crate on `min ½vᵀMv + fᵀv, Hv + w + mu s e_N ∈ K*`: with `s = 0` the convex
//! relaxation, and in an outer loop `s = |u_T|` Coulomb's law.

use crate::contestant::{Contestant, Effort};
use ::clarabel::algebra::CscMatrix;
use ::clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use testbed::scene_file::SceneFile;

/// Convex problems that the outer loop solves at most.
const PROBLEMS: usize = 50;

pub(crate) struct Clarabel {
    file: SceneFile,
    outer_loop: bool,
    /// Rows of `K*` as rows of Lorentz's cone: tangents times `mu`.
    scale: Vec<f64>,
    solver: DefaultSolver<f64>,
    velocity: Vec<f64>,
    impulse: Vec<f64>,
}

/// Column by column, without zeros.
fn sparse(rows: usize, columns: usize, entry: impl Fn(usize, usize) -> f64) -> CscMatrix {
    let (mut starts, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
    for j in 0..columns {
        for i in 0..rows {
            let value = entry(i, j);
            if value != 0.0 {
                indices.push(i);
                values.push(value);
            }
        }
        starts.push(values.len());
    }
    CscMatrix::new(rows, columns, starts, indices, values)
}

fn settings(tolerance: f64) -> DefaultSettings<f64> {
    DefaultSettings {
        verbose: false,
        max_threads: 1,
        presolve_enable: false, // so that `b` can be changed
        tol_gap_abs: tolerance,
        tol_gap_rel: tolerance,
        tol_feas: tolerance,
        ..DefaultSettings::default()
    }
}

fn solver(file: &SceneFile, scale: &[f64]) -> DefaultSolver<f64> {
    let (n, m) = (file.n_dof, scale.len());
    let upper = |i, j| if i <= j { file.mass[(i, j)] } else { 0.0 };
    let mass = sparse(n, n, upper);
    let rows = sparse(m, n, |i, j| -scale[i] * file.h[(i, j)]);
    let offset: Vec<f64> = scale.iter().zip(file.w.iter()).map(|(d, w)| d * w).collect();
    let cones = vec![SupportedConeT::SecondOrderConeT(file.dim); file.n_contacts];
    DefaultSolver::new(&mass, file.f.as_slice(), &rows, &offset, &cones, settings(1e-8))
        .expect("the sizes agree")
}

impl Clarabel {
    pub(crate) fn new(file: &SceneFile, outer_loop: bool) -> Self {
        let rows = 0..file.dim * file.n_contacts;
        let scale: Vec<f64> = rows
            .map(|row| match row % file.dim {
                0 => 1.0,
                _ => file.mu[row / file.dim],
            })
            .collect();
        Self {
            solver: solver(file, &scale),
            file: file.clone(),
            outer_loop,
            scale,
            velocity: Vec::new(),
            impulse: Vec::new(),
        }
    }

    /// Solves with `s` held; steps, and whether it went well.
    fn convex(&mut self, slip: &[f64]) -> (usize, bool) {
        let dim = self.file.dim;
        let offset: Vec<f64> = (0..self.scale.len())
            .map(|row| match row % dim {
                0 => self.file.w[row] + self.file.mu[row / dim] * slip[row / dim],
                _ => self.scale[row] * self.file.w[row],
            })
            .collect();
        self.solver.update_b(&offset).expect("the size is the same");
        self.solver.solve();
        let solution = &self.solver.solution;
        self.velocity.clone_from(&solution.x);
        let impulse = self.scale.iter().zip(&solution.z).map(|(d, z)| d * z);
        self.impulse = impulse.collect();
        let solved = solution.status == SolverStatus::Solved;
        (solution.iterations as usize, solved)
    }

    /// `|u_T|` of each contact.
    fn slip(&self) -> Vec<f64> {
        let v = nalgebra::DVector::from_row_slice(&self.velocity);
        let u = &self.file.h * v + &self.file.w;
        let contacts = u.as_slice().chunks_exact(self.file.dim);
        contacts.map(|u| u[1..].iter().map(|u| u * u).sum::<f64>().sqrt()).collect()
    }
}

impl Contestant for Clarabel {
    fn prepare(&mut self) {
        self.solver = solver(&self.file, &self.scale);
    }

    fn solve(&mut self, tolerance: f64) -> Effort {
        let inner = if self.outer_loop { 0.1 * tolerance } else { tolerance };
        self.solver.update_settings(settings(inner)).expect("only tolerances change");
        let mut slip = vec![0.0; self.file.n_contacts];
        let (mut newton_steps, solved) = self.convex(&slip);
        let mut finished = solved && !self.outer_loop;
        if !self.outer_loop {
            return Effort { iterations: 0, newton_steps, finished };
        }
        for _ in 1..PROBLEMS {
            let next = self.slip();
            let largest = next.iter().copied().fold(0.0, f64::max);
            let pairs = slip.iter().zip(&next);
            let change = pairs.fold(0.0_f64, |change, (a, b)| change.max((a - b).abs()));
            slip = next;
            if change <= tolerance * largest {
                finished = true;
                break;
            }
            newton_steps += self.convex(&slip).0;
        }
        Effort { iterations: 0, newton_steps, finished }
    }

    fn answer(&self) -> (Vec<f64>, Vec<f64>) {
        (self.velocity.clone(), self.impulse.clone())
    }
}
