//! Projected Gauss-Seidel: contact by contact, Coulomb's law solved exactly with the impulses of
//! the other contacts held. Stops when a sweep changes the impulses by no more than the tolerance.

use crate::block::Block;
use crate::contact_space::ContactSpace;
use crate::contestant::{Contestant, Effort};
use nalgebra::SVector;
use stiction::Real;
use testbed::scene_file::SceneFile;

const SWEEPS: usize = 5000;

/// `N` velocities, up to `C` contacts of `D` rows, `R = D·C`.
pub(crate) struct GaussSeidel<T: Real, const N: usize, const D: usize, const C: usize, const R: usize> {
    pub(crate) space: ContactSpace<T, N, R>,
    pub(crate) mu: Vec<T>,
    blocks: [Block<T, D>; C],
    /// Where the search for a slipping impulse ended last.
    lambda: [T; C],
    pub(crate) r: SVector<T, R>,
    /// `u = W r + q`, kept up to date.
    pub(crate) u: SVector<T, R>,
}

/// Squares of how far a sweep moved the impulses, and of their length.
pub(crate) struct Change<T> {
    pub(crate) step: T,
    pub(crate) size: T,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize> GaussSeidel<T, N, D, C, R> {
    /// `None` where `M` is not positive definite in this number type.
    pub(crate) fn new(file: &SceneFile) -> Option<Self> {
        Some(Self {
            space: ContactSpace::new(file)?,
            mu: file.mu.iter().copied().map(T::literal).collect(),
            blocks: [Block::NONE; C],
            lambda: [T::ZERO; C],
            r: SVector::zeros(),
            u: SVector::zeros(),
        })
    }

    /// `r = 0`
    pub(crate) fn begin(&mut self) {
        self.space.begin();
        self.r = SVector::zeros();
        self.u = self.space.q;
        self.lambda = [T::ZERO; C];
    }

    pub(crate) fn sweep(&mut self) -> Change<T> {
        let mut change = Change { step: T::ZERO, size: T::ZERO };
        let contacts = self.blocks.iter().zip(&mut self.lambda);
        for (i, (block, lambda)) in contacts.take(self.mu.len()).enumerate() {
            let first = i * D;
            let old: SVector<T, D> = self.r.fixed_rows::<D>(first).into();
            let mut left: SVector<T, D> = self.u.fixed_rows::<D>(first).into();
            let own = self.space.delassus.fixed_view::<D, D>(first, first);
            left -= own * old;
            let next = block.solve(&left, lambda);
            let step = next - old;
            let moved = step.norm_squared();
            change.size += next.norm_squared();
            if moved > T::ZERO {
                change.step += moved;
                self.r.fixed_rows_mut::<D>(first).copy_from(&next);
                self.space.add(&mut self.u, first, &step);
            }
        }
        change
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize> Contestant
    for GaussSeidel<T, N, D, C, R>
{
    fn prepare(&mut self) {
        self.space.prepare();
        let delassus = &self.space.delassus;
        for (i, (block, &mu)) in self.blocks.iter_mut().zip(&self.mu).enumerate() {
            *block = Block::new(mu, |a, b| delassus[(i * D + a, i * D + b)]);
        }
    }

    fn solve(&mut self, tolerance: f64) -> Effort {
        let tolerance = T::literal(tolerance);
        self.begin();
        let mut effort = Effort { iterations: 0, newton_steps: 0, finished: false };
        while !effort.finished && effort.iterations < SWEEPS {
            let Change { step, size } = self.sweep();
            effort.iterations += 1;
            effort.finished = step <= tolerance * tolerance * size;
        }
        self.space.finish(&self.r);
        effort
    }

    fn answer(&self) -> (Vec<f64>, Vec<f64>) {
        self.space.answer(&self.r)
    }
}
