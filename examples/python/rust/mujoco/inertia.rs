//! The mass matrix with what is implicit in it, by blocks of trees that it does not couple.

use super::ffi::{Data, EULER, Model};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Velocities that a part of the mass matrix couples.
struct Block {
    dofs: Vec<usize>,
    factor: Cholesky<f64, Dyn>,
}

/// `M'`, its factors, and the free motion.
#[derive(Default)]
pub(super) struct Inertia {
    n: usize,
    matrix: Vec<f64>,
    blocks: Vec<Block>,
    block_of: Vec<usize>,
    /// The free impulse `M' v + h f`, and the velocities without constraints.
    pub(super) impulse: Vec<f64>,
    pub(super) velocity: Vec<f64>,
}

impl Inertia {
    /// Takes them from MuJoCo.
    ///
    /// # Errors
    /// The mass matrix is not positive definite.
    pub(super) fn update(&mut self, model: &Model, data: &mut Data) -> Result<(), &'static str> {
        self.n = model.sizes.velocities;
        data.mass(model, &mut self.matrix);
        let h = model.step();
        let is_implicit = model.integrator() != EULER;
        let with_damping = |matrix: &mut [f64]| {
            if model.damps() {
                for (i, damping) in model.dof_damping().iter().enumerate() {
                    matrix[i * (model.sizes.velocities + 1)] += h * damping;
                }
            }
        };
        if is_implicit {
            let mass = self.matrix.clone();
            self.add_derivative(model, data, h);
            if !self.factor(model) {
                self.matrix = mass;
                with_damping(&mut self.matrix);
                if !self.factor(model) {
                    return Err("M: not positive definite");
                }
            }
        } else {
            with_damping(&mut self.matrix);
            if !self.factor(model) {
                return Err("M: not positive definite");
            }
        }
        self.impulse.clear();
        for (row, force) in self.matrix.chunks_exact(self.n).zip(data.qfrc_smooth()) {
            let momentum: f64 = row.iter().zip(data.qvel()).map(|(m, v)| m * v).sum();
            self.impulse.push(momentum + h * force);
        }
        self.velocity = self.solve(&self.impulse);
        Ok(())
    }

    /// `M - h D`, made symmetric.
    fn add_derivative(&mut self, model: &Model, data: &mut Data, h: f64) {
        let (n, columns) = (self.n, model.derivative_columns());
        let entries = data.velocity_derivative(model);
        for i in 0..n {
            let [first, count] =
                [model.d_rowadr()[i], model.d_rownnz()[i]].map(|x| x.unsigned_abs() as usize);
            for place in first..first + count {
                let j = columns[place].unsigned_abs() as usize;
                let half = 0.5 * h * entries[place];
                self.matrix[i * n + j] -= half;
                self.matrix[j * n + i] -= half;
            }
        }
    }

    /// Finds the blocks and factorises them; `false` if one is not positive definite.
    fn factor(&mut self, model: &Model) -> bool {
        let (n, trees) = (self.n, model.dof_treeid());
        // Trees that the matrix couples are one block, named by its first velocity.
        let mut first: Vec<usize> = (0..n)
            .map(|i| {
                if i > 0 && trees[i] == trees[i - 1] {
                    usize::MAX
                } else {
                    i
                }
            })
            .collect();
        for i in 0..n {
            if first[i] == usize::MAX {
                first[i] = first[i - 1];
            }
        }
        if first.last().is_some_and(|&last| last > 0) {
            for i in 0..n {
                for j in 0..i {
                    if first[i] != first[j] && self.matrix[i * n + j] != 0.0 {
                        let (from, to) = (first[i].max(first[j]), first[i].min(first[j]));
                        first
                            .iter_mut()
                            .filter(|own| **own == from)
                            .for_each(|own| *own = to);
                    }
                }
            }
        }
        self.blocks.clear();
        self.block_of = vec![0; n];
        for start in 0..n {
            if first[start] != start {
                continue;
            }
            let dofs: Vec<_> = (start..n).filter(|&i| first[i] == start).collect();
            let matrix = if dofs.len() == n {
                DMatrix::from_row_slice(n, n, &self.matrix)
            } else {
                DMatrix::from_fn(dofs.len(), dofs.len(), |i, j| {
                    self.matrix[dofs[i] * n + dofs[j]]
                })
            };
            let Some(factor) = Cholesky::new(matrix) else {
                return false;
            };
            for &dof in &dofs {
                self.block_of[dof] = self.blocks.len();
            }
            self.blocks.push(Block { dofs, factor });
        }
        true
    }

    pub(super) fn blocks(&self) -> usize {
        self.blocks.len()
    }

    pub(super) fn dofs(&self, block: usize) -> &[usize] {
        &self.blocks[block].dofs
    }

    pub(super) fn block_of(&self, dof: usize) -> usize {
        self.block_of[dof]
    }

    pub(super) fn entry(&self, i: usize, j: usize) -> f64 {
        self.matrix[i * self.n + j]
    }

    /// `M'⁻¹ b`.
    pub(super) fn solve(&self, right: &[f64]) -> Vec<f64> {
        let mut solution = vec![0.0; self.n];
        for block in &self.blocks {
            let mut part =
                DVector::from_iterator(block.dofs.len(), block.dofs.iter().map(|&dof| right[dof]));
            block.factor.solve_mut(&mut part);
            block
                .dofs
                .iter()
                .zip(part.iter())
                .for_each(|(&dof, &x)| solution[dof] = x);
        }
        solution
    }

    /// How much an impulse along a row moves that row: `H M'⁻¹ Hᵀ`.
    pub(super) fn response(&self, row: &[f64], scratch: &mut Vec<f64>) -> f64 {
        let mut sum = 0.0;
        for Block { dofs, factor } in &self.blocks {
            scratch.clear();
            scratch.extend(dofs.iter().map(|&dof| row[dof]));
            let Some(first) = scratch.iter().position(|&x| x != 0.0) else {
                continue;
            };
            let lower = factor.l_dirty();
            for j in first..dofs.len() {
                let x = scratch[j] / lower[(j, j)];
                sum += x * x;
                let below = &lower.column(j).data.into_slice()[j + 1..];
                scratch[j + 1..]
                    .iter_mut()
                    .zip(below)
                    .for_each(|(y, l)| *y -= l * x);
            }
        }
        sum
    }
}
