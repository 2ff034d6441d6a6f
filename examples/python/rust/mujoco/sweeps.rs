//! An answer for every question: sweeps over soft contacts and rows, whatever their number.

use nalgebra::{Cholesky, DMatrix, DVector};
use stiction_kernels::problem::{Answer, Friction, Problem};

/// Sweeps that are done.
pub(super) const SWEEPS: usize = 100;

/// One row on the way: what it is, what an impulse along it moves, and how much of that is along itself.
struct Line {
    row: DVector<f64>,
    moved: DVector<f64>,
    stiffness: f64,
    compliance: f64,
    offset: f64,
    impulse: f64,
}

impl Line {
    /// The impulse that would stop it.
    fn wanted(&self, velocity: &DVector<f64>) -> f64 {
        let speed = self.row.dot(velocity) + self.offset + self.compliance * self.impulse;
        if self.stiffness > 0.0 { self.impulse - speed / self.stiffness } else { 0.0 }
    }

    fn set(&mut self, impulse: f64, velocity: &mut DVector<f64>) {
        velocity.axpy(impulse - self.impulse, &self.moved, 1.0);
        self.impulse = impulse;
    }
}

/// Sweeps over a problem whose rows are all compliant: normals first, then tangents within what the normal allows. Nobody is sure
/// that they converge, but compliance bounds each impulse by what it stops.
pub(super) fn sweep(problem: &Problem<'_, f64>) -> Answer<f64> {
    let (n, dim, contacts) = (problem.n, problem.dim, problem.contacts());
    let mut answer = Answer::default();
    answer.out([n, contacts, dim, problem.rows.lower.len()]);
    let Some(factor) = Cholesky::new(DMatrix::from_row_slice(n, n, problem.mass)) else {
        return answer;
    };
    let mut velocity = factor.solve(&DVector::from_row_slice(problem.free_impulse));
    let line = |row: &[f64], offset: f64, compliance: f64| {
        let row = DVector::from_row_slice(row);
        let moved = factor.solve(&row);
        Line { stiffness: row.dot(&moved) + compliance, row, moved, compliance, offset, impulse: 0.0 }
    };
    let mut lines: Vec<Line> = (problem.jacobian.chunks_exact(n).zip(problem.offsets).enumerate())
        .map(|(i, (row, &offset))| {
            let soft = problem.compliance.get(2 * (i / dim) + usize::from(i % dim > 0));
            line(row, offset, soft.copied().unwrap_or(0.0))
        })
        .collect();
    let mut rows: Vec<Line> = (problem.rows.jacobian.chunks_exact(n).zip(problem.rows.offset).enumerate())
        .map(|(j, (row, &offset))| line(row, offset, problem.rows.compliance.get(j).copied().unwrap_or(0.0)))
        .collect();
    for _ in 0..SWEEPS {
        for (i, lines) in lines.chunks_exact_mut(dim).enumerate() {
            let mu = |k: usize| match problem.friction {
                Friction::Round(mu) => mu[i],
                Friction::Shaped(mu) => mu[i * (dim - 1) + k - 1],
            };
            let normal = lines[0].wanted(&velocity).max(0.0);
            lines[0].set(normal, &mut velocity);
            let wanted: Vec<f64> = lines[1..].iter().map(|line| line.wanted(&velocity)).collect();
            let scaled = |(k, wanted): (usize, &f64)| {
                if mu(k + 1) > 0.0 { (wanted / mu(k + 1)).powi(2) } else { 0.0 }
            };
            let length = wanted.iter().enumerate().map(scaled).sum::<f64>().sqrt();
            let share = if length > normal { normal / length } else { 1.0 };
            for (k, wanted) in wanted.into_iter().enumerate() {
                let impulse = if mu(k + 1) > 0.0 { wanted * share } else { 0.0 };
                lines[k + 1].set(impulse, &mut velocity);
            }
        }
        for (j, line) in rows.iter_mut().enumerate() {
            // `clamp` panics at a bound that is no number.
            let wanted = line.wanted(&velocity).min(problem.rows.upper[j]).max(problem.rows.lower[j]);
            line.set(wanted, &mut velocity);
        }
    }
    answer.v.copy_from_slice(velocity.as_slice());
    answer.r.iter_mut().zip(&lines).for_each(|(r, line)| *r = line.impulse);
    answer.rows[0].iter_mut().zip(&rows).for_each(|(r, line)| *r = line.impulse);
    answer
}
