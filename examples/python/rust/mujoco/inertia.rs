//! The mass matrix with what is implicit in it, by blocks of trees that it does not couple.

use super::ffi::{Data, EULER, Model};
use super::touch::dot;

/// Velocities that a part of the mass matrix couples.
struct Block {
    /// The last first: with what is farther out eliminated first, zeros of trees stay zeros.
    dofs: Vec<usize>,
    /// Cholesky's factor, column by column.
    lower: Vec<f64>,
}

impl Block {
    fn column(&self, j: usize) -> &[f64] {
        &self.lower[j * self.dofs.len()..][..self.dofs.len()]
    }

    /// `L⁻¹ x`
    fn forward(&self, x: &mut [f64]) {
        for j in 0..x.len() {
            if x[j] == 0.0 {
                continue;
            }
            let column = self.column(j);
            x[j] /= column[j];
            let own = x[j];
            x[j + 1..].iter_mut().zip(&column[j + 1..]).for_each(|(x, l)| *x -= l * own);
        }
    }

    /// `L⁻ᵀ x`
    fn backward(&self, x: &mut [f64]) {
        for j in (0..x.len()).rev() {
            let column = self.column(j);
            x[j] = (x[j] - dot(&column[j + 1..], &x[j + 1..])) / column[j];
        }
    }
}

/// Cholesky's factor of the part of a matrix, column by column, past its zeros; `None` if it is not positive definite.
fn factor(dofs: &[usize], entry: impl Fn(usize, usize) -> f64) -> Option<Vec<f64>> {
    let n = dofs.len();
    let mut lower = vec![0.0; n * n];
    for (j, &dof) in dofs.iter().enumerate() {
        let (before, own) = lower.split_at_mut(j * n);
        let own = &mut own[j..n];
        for (own, &other) in own.iter_mut().zip(&dofs[j..]) {
            *own = entry(other, dof);
        }
        for column in before.chunks_exact(n).filter(|column| column[j] != 0.0) {
            let share = column[j];
            own.iter_mut().zip(&column[j..]).for_each(|(own, l)| *own -= share * l);
        }
        let root = own[0].sqrt();
        if root.is_nan() || root <= 0.0 {
            return None;
        }
        for own in own {
            *own /= root;
        }
    }
    Some(lower)
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
        let n = self.n;
        for (i, j, entry) in data.velocity_derivative(model) {
            let half = 0.5 * h * entry;
            self.matrix[i * n + j] -= half;
            self.matrix[j * n + i] -= half;
        }
    }

    /// Finds the blocks and factorises them; `false` if one is not positive definite.
    fn factor(&mut self, model: &Model) -> bool {
        let (n, trees) = (self.n, model.dof_treeid());
        // Trees that the matrix couples are one block, named by its first velocity.
        let mut first: Vec<usize> =
            (0..n).map(|i| if i > 0 && trees[i] == trees[i - 1] { usize::MAX } else { i }).collect();
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
                        first.iter_mut().filter(|own| **own == from).for_each(|own| *own = to);
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
            let dofs: Vec<_> = (start..n).rev().filter(|&i| first[i] == start).collect();
            let Some(lower) = factor(&dofs, |i, j| self.matrix[i * n + j]) else {
                return false;
            };
            for &dof in &dofs {
                self.block_of[dof] = self.blocks.len();
            }
            self.blocks.push(Block { dofs, lower });
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
            let mut part: Vec<_> = block.dofs.iter().map(|&dof| right[dof]).collect();
            block.forward(&mut part);
            block.backward(&mut part);
            block.dofs.iter().zip(part).for_each(|(&dof, x)| solution[dof] = x);
        }
        solution
    }

    /// Blocks of an island.
    fn blocks_of(&self, dofs: &[usize]) -> impl Iterator<Item = &Block> {
        self.blocks.iter().filter(move |block| dofs.binary_search(&block.dofs[0]).is_ok())
    }

    /// Adds a row in coordinates in which the masses of an island are one: `L⁻¹ row`.
    pub(super) fn to_unit(&self, dofs: &[usize], row: &[f64], out: &mut Vec<f64>) {
        for block in self.blocks_of(dofs) {
            let start = out.len();
            out.extend(block.dofs.iter().map(|&dof| row[dof]));
            block.forward(&mut out[start..]);
        }
    }

    /// Takes a motion from these coordinates to velocities, `L⁻ᵀ motion`, and tells them one by one.
    pub(super) fn back_from_unit(
        &self,
        dofs: &[usize],
        motion: &mut [f64],
        mut tell: impl FnMut(usize, f64),
    ) {
        let mut rest = motion;
        for block in self.blocks_of(dofs) {
            let own = rest.split_off_mut(..block.dofs.len()).unwrap_or_default();
            block.backward(own);
            block.dofs.iter().zip(own).for_each(|(&dof, z)| tell(dof, *z));
        }
    }

    /// How much an impulse along a row moves that row: `H M'⁻¹ Hᵀ`.
    pub(super) fn response(&self, row: &[f64], scratch: &mut Vec<f64>) -> f64 {
        let mut sum = 0.0;
        for block in &self.blocks {
            scratch.clear();
            scratch.extend(block.dofs.iter().map(|&dof| row[dof]));
            block.forward(scratch);
            sum += scratch.iter().map(|x| x * x).sum::<f64>();
        }
        sum
    }
}
