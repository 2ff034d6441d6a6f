//! A direction in which all data of a scene file move, in the file and in what the derivative takes.

use nalgebra::{SMatrix, SVector};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};
use stiction::{Inputs, Scene, Solution};
use testbed::mixed::{Friction, MixedFile};

/// What moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum What {
    /// All data.
    All,
    /// Free impulse, mass matrix and friction: whatever contacts are redundant can follow.
    Momentum,
    /// The same without friction, with which normal velocities of the relaxed law change.
    Impulse,
}

/// Draws numbers between -1 and 1.
pub(crate) struct Draws(Pcg64);

impl Draws {
    pub(crate) fn new(seed: u64) -> Self {
        Self(Pcg64::seed_from_u64(seed))
    }

    pub(crate) fn next(&mut self) -> f64 {
        f64::from(self.0.next_u32()) / f64::from(1_u32 << 31) - 1.0
    }
}

/// The file moved along a direction by `h`: the direction is drawn by its seed, each number by a share of its size.
pub(crate) fn moved(file: &MixedFile, seed: u64, what: What, h: f64) -> MixedFile {
    let (mut draws, mut moved) = (Draws::new(seed), file.clone());
    let size = |x: &[f64]| x.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
    let share = size(&file.f).max(1e-3 * file.mass[0][0]);
    for f in &mut moved.f {
        *f += h * share * draws.next();
    }
    let smallness = file.mass.iter().fold(1.0, |sum: f64, _| sum + 1.0).recip();
    for i in 0..file.n_dof {
        for j in 0..=i {
            // Diagonally dominant, so that it stays what it is.
            let both = (file.mass[i][i] * file.mass[j][j]).sqrt() * smallness;
            let zero = file.mass[i][j] == 0.0;
            let change = if zero { 0.0 } else { h * both * draws.next() };
            moved.mass[i][j] += change;
            if i != j {
                moved.mass[j][i] = moved.mass[i][j];
            }
        }
    }
    let rubs = if what == What::Impulse { 0.0 } else { h };
    for mu in &mut moved.mu {
        let change = rubs * draws.next();
        match mu {
            Friction::Isotropic(mu) => *mu *= 1.0 + change,
            Friction::Rows(rows) => rows.iter_mut().for_each(|mu| *mu *= 1.0 + change),
        }
    }
    for joint in &mut moved.joints {
        if joint.lower == joint.upper {
            continue; // they would get out of order
        }
        let bounds = [&mut joint.lower, &mut joint.upper];
        for bound in bounds.into_iter().flatten() {
            *bound += h * (bound.abs() + 1e-3 * share) * draws.next();
        }
    }
    if what != What::All {
        return moved;
    }
    let speed = 0.1 * size(&file.w) + 1e-3;
    for w in &mut moved.w {
        *w += h * speed * draws.next();
    }
    for row in &mut moved.h {
        for entry in row {
            *entry *= 1.0 + h * draws.next();
        }
    }
    for soft in moved.compliance.iter_mut().flatten() {
        *soft *= 1.0 + h * draws.next();
    }
    for joint in &mut moved.joints {
        joint.offset += h * speed * draws.next();
        joint.row.iter_mut().for_each(|entry| *entry *= 1.0 + h * draws.next());
        joint.compliance *= 1.0 + h * draws.next();
    }
    moved
}

/// The same direction as the derivative takes it, from the scene, the scene moved to `h = 1`, and the solution.
pub(crate) fn inputs<const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>(
    (file, scene): (&MixedFile, &Scene<f64, N, D, C, R, S>),
    (moved_file, moved): (&MixedFile, &Scene<f64, N, D, C, R, S>),
    solution: &Solution<f64, N, D, C, R>,
) -> Inputs<f64, N, D, C, R> {
    let mut inputs = Inputs::zero();
    let v = &solution.velocity;
    let push: SVector<f64, N> = file.free_impulse();
    let moved_push: SVector<f64, N> = moved_file.free_impulse();
    inputs.free_impulse = moved_push - push - (moved.mass() - scene.mass()) * v;
    for (i, (contact, other)) in scene.contacts().iter().zip(moved.contacts()).enumerate() {
        let change: SMatrix<f64, D, N> = other.jacobian - contact.jacobian;
        let r = solution.contacts[i].impulse;
        inputs.free_impulse += change.transpose() * r;
        inputs.offsets[i] = other.offset - contact.offset + change * v;
        inputs.friction[i] = other.mu - contact.mu;
        if let (Some([n, t]), Some([n_moved, t_moved])) =
            (file.compliance.get(i), moved_file.compliance.get(i))
        {
            for k in 0..D {
                let change = if k == 0 { n_moved - n } else { t_moved - t };
                // Of spins and rolls over the square of their lengths.
                let length = match &file.mu[i] {
                    Friction::Rows(mu) if k > 2 && mu[k - 1] > 0.0 => mu[k - 1] / contact.mu,
                    _ => 1.0,
                };
                inputs.offsets[i][k] += change * r[k] / (length * length);
            }
        }
    }
    for (j, (row, other)) in scene.rows().iter().zip(moved.rows()).enumerate() {
        let change = other.row - row.row;
        let impulse = solution.rows[j].impulse;
        inputs.free_impulse += change * impulse;
        inputs.row_offsets[j] =
            other.offset - row.offset + change.dot(v) + (other.compliance - row.compliance) * impulse;
        if let (
            stiction::RowLaw::Box { lower, upper },
            stiction::RowLaw::Box { lower: lower_moved, upper: upper_moved },
        ) = (row.law, other.law)
        {
            inputs.bounds[j] = [lower_moved - lower, upper_moved - upper];
        }
    }
    inputs
}
