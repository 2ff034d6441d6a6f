//! Semismooth Newton on the fixed-point map of ADMM, in contact space.
//!
//! With one vector `z` a contact, `P = Π_{K*}(z)` and `r = rho_i (P - z)`, the impulse lies in `K`
//! and is complementary to `P` whatever `z` is; a solution is a root of
//!
//! `E(z) = W r + q + S(P) - P`, `S_i = mu_i |P_Ti| e_N`.
//!
//! `E` needs no resolvent: the penalty is only a scale here, so each contact has its own, its
//! effective mass `rho_i = kappa alpha_i`. A step solves
//! `[rho W (I - DP + λI) + DP - DS + λI] d = E` with the derivatives `DP` and `DS`, where `λ`
//! regularises hyperstatic scenes (singular `W`). A contact in the interior of `K*` has
//! `DP = I`, is coupled to the others by `λ` alone, and is left out of the system.

use crate::Real;
use crate::cholesky::{axpy, dot};
use crate::cone::split;
use crate::contact_space::{ContactMatrix, ContactVector};
use crate::problem::{Law, Problem};
use crate::solution::zeros;
use core::mem;
use heapless::Vec;
use nalgebra::{SMatrix, SVector};

/// A point `z` and what follows from it.
#[derive(Clone, Debug)]
pub(crate) struct Point<T, const D: usize, const C: usize> {
    pub(crate) z: [SVector<T, D>; C],
    /// `P = Π_{K*}(z)`
    pub(crate) velocity: [SVector<T, D>; C],
    /// `r`
    pub(crate) impulse: ContactVector<T, D, C>,
    /// `u = W r + q`
    pub(crate) relative: ContactVector<T, D, C>,
    /// `E(z)`
    residual: ContactVector<T, D, C>,
    /// `Σ alpha_i |E_i|²`, what a step has to reduce. An energy, and not its root, so that units
    /// scaled by powers of two change nothing but exponents.
    pub(crate) energy: T,
    /// First part of the error.
    pub(crate) natural_map: T,
}

impl<T: Real, const D: usize, const C: usize> Point<T, D, C> {
    /// The point `z_i = P_i - r_i / rho_i`, with `rho_i = scale alpha_i`.
    pub(crate) fn of<const N: usize>(
        problem: &Problem<'_, T, N, D, C>,
        scale: T,
        velocity: &[SVector<T, D>; C],
        impulse: &ContactVector<T, D, C>,
    ) -> Self {
        let mut z = *velocity;
        for ((z, &impulse), law) in z.iter_mut().zip(impulse).zip(problem.laws()) {
            if law.step > T::ZERO {
                *z -= SVector::from(impulse) / (scale * law.step);
            }
        }
        Self::at(problem, scale, &z)
    }

    /// Evaluates a point, with `rho_i = scale alpha_i`.
    pub(crate) fn at<const N: usize>(
        problem: &Problem<'_, T, N, D, C>,
        scale: T,
        z: &[SVector<T, D>; C],
    ) -> Self {
        let mut point = Self {
            z: *z,
            velocity: [zeros(); C],
            impulse: [[T::ZERO; D]; C],
            relative: [[T::ZERO; D]; C],
            residual: [[T::ZERO; D]; C],
            energy: T::ZERO,
            natural_map: T::ZERO,
        };
        let laws = problem.laws();
        let pairs = laws.iter().zip(&mut point.velocity).zip(z);
        for (((law, velocity), z), impulse) in pairs.zip(&mut point.impulse) {
            *velocity = law.cone.dual().project(z);
            *impulse = ((*velocity - z) * (scale * law.step)).into();
        }
        point.natural_map = problem.natural_map(&point.impulse, &mut point.relative);
        point.residual = point.relative;
        for ((law, velocity), residual) in laws.iter().zip(&point.velocity).zip(&mut point.residual)
        {
            for (residual, &velocity) in residual.iter_mut().zip(velocity.iter()) {
                *residual -= velocity;
            }
            if let Some(normal) = residual.first_mut() {
                *normal += law.lift(velocity);
            }
            point.energy += law.step * dot(residual, residual);
        }
        point
    }
}

/// The derivatives at a contact, as the system needs them.
#[derive(Clone, Copy)]
struct Block<T, const D: usize> {
    /// `rho_i (I - DP + λI)`, by which `W` is multiplied.
    coupling: SMatrix<T, D, D>,
    /// `DP - DS + λI`
    own: SMatrix<T, D, D>,
    /// In the interior of `K*`: `DP = I`.
    open: bool,
}

impl<T: Real, const D: usize> Block<T, D> {
    fn at(law: &Law<T, D>, z: &SVector<T, D>, scale: T, regularisation: T) -> Self {
        let identity = SMatrix::<T, D, D>::identity();
        let (derivative, direction) = law.cone.dual().derivative(z);
        let mut own = derivative + identity * regularisation;
        // DS = mu e_N (P_T / |P_T|)ᵀ DP
        let slip = direction.tr_mul(&derivative) * law.lift;
        let columns = own.as_mut_slice().chunks_exact_mut(D);
        for (column, &slip) in columns.zip(slip.iter()) {
            if let Some(normal) = column.first_mut() {
                *normal -= slip;
            }
        }
        Self {
            coupling: (identity * (T::ONE + regularisation) - derivative) * (scale * law.step),
            own,
            open: derivative == identity,
        }
    }

    /// The step of an open contact, from what the others leave of its equation.
    fn solve_open(&self, rhs: SVector<T, D>) -> SVector<T, D> {
        // `own` is (1 + λ) I but for its first row.
        let diagonal = self.own.as_slice().last().copied().unwrap_or(T::ONE);
        let mut step = rhs / diagonal;
        let first_row = self.own.as_slice().iter().step_by(D);
        let tangents = first_row.clone().zip(step.iter()).skip(1);
        let (normal, _) = split(&rhs);
        let normal = tangents.fold(normal, |rest, (&own, &step)| rest - own * step);
        if let (Some(step), Some(&own)) =
            (step.as_mut_slice().first_mut(), first_row.take(1).last())
        {
            *step = normal / own;
        }
        step
    }
}

/// The step `d` of a Newton iteration from a point; `None` if the system is singular.
pub(crate) fn direction<T: Real, const N: usize, const D: usize, const C: usize>(
    problem: &Problem<'_, T, N, D, C>,
    point: &Point<T, D, C>,
    scale: T,
    regularisation: T,
    workspace: &mut ContactMatrix<T, D, C>,
) -> Option<[SVector<T, D>; C]> {
    let laws = problem.laws();
    let mut blocks = [Block {
        coupling: SMatrix::zeros(),
        own: SMatrix::zeros(),
        open: true,
    }; C];
    let mut coupled = Vec::<usize, C>::new();
    for (i, ((block, law), z)) in blocks.iter_mut().zip(laws).zip(&point.z).enumerate() {
        *block = Block::at(law, z, scale, regularisation);
        if !block.open {
            coupled.push(i).ok()?;
        }
    }

    // The rows and columns of the contacts that are not open, close together.
    let delassus = problem.factor.delassus();
    let mut rhs = [[T::ZERO; D]; C];
    let targets = workspace.iter_mut().zip(&mut rhs).zip(&coupled);
    for (k, ((rows, rhs), &i)) in targets.enumerate() {
        *rhs = *point.residual.get(i)?;
        let own = blocks.get(i)?.own;
        for ((row, source), own) in rows.iter_mut().zip(delassus.get(i)?).zip(own.row_iter()) {
            for (entries, &j) in row.iter_mut().zip(&coupled) {
                let (w, coupling) = (source.get(j)?, blocks.get(j)?.coupling);
                for (entry, column) in entries.iter_mut().zip(coupling.as_slice().chunks_exact(D)) {
                    *entry = dot(w, column);
                }
            }
            for (entry, &own) in row.get_mut(k)?.iter_mut().zip(own.iter()) {
                *entry += own;
            }
        }
    }
    let rows = workspace.as_flattened_mut().get_mut(..coupled.len() * D)?;
    eliminate(rows, rhs.as_flattened_mut())?;

    // Back to all contacts; the open ones follow from the impulses of the others.
    let mut step = [zeros(); C];
    let mut push = [[T::ZERO; D]; C];
    for (rhs, &i) in rhs.iter().zip(&coupled) {
        let solved = SVector::from(*rhs);
        *step.get_mut(i)? = solved;
        *push.get_mut(i)? = (blocks.get(i)?.coupling * solved).into();
    }
    if coupled.len() < laws.len() {
        let mut moved = [[T::ZERO; D]; C];
        problem.factor.delassus_times(&push, &mut moved);
        let rhs = point.residual.iter().zip(moved);
        let targets = step.iter_mut().zip(&blocks).zip(rhs).take(laws.len());
        for ((step, block), (&residual, moved)) in targets.filter(|((_, block), _)| block.open) {
            *step = block.solve_open(SVector::from(residual) - SVector::from(moved));
        }
    }
    let finite = step.iter().flatten().all(T::is_finite);
    finite.then_some(step)
}

/// Gaussian elimination, pivots sought within the rows of a contact; the solution replaces `b`.
fn eliminate<T: Real, const D: usize, const C: usize>(
    rows: &mut [ContactVector<T, D, C>],
    b: &mut [T],
) -> Option<()> {
    let n = rows.len();
    for k in 0..n {
        let mut pivot = (T::ZERO, k);
        for (i, row) in rows.iter().enumerate().skip(k).take(D - k % D) {
            let size = row.as_flattened().get(k)?.abs();
            if size > pivot.0 {
                pivot = (size, i);
            }
        }
        if pivot.0 == T::ZERO {
            return None;
        }
        let (done, below) = rows.split_at_mut_checked(k + 1)?;
        let (solved, rhs) = b.split_at_mut_checked(k + 1)?;
        let (row, solved) = (done.last_mut()?, solved.last_mut()?);
        if pivot.1 > k {
            // `slice::swap` would be a reachable panic.
            let index = pivot.1 - k - 1;
            mem::swap(row, below.get_mut(index)?);
            mem::swap(solved, rhs.get_mut(index)?);
        }
        let row = row.as_flattened_mut();
        let reciprocal = T::ONE / *row.get(k)?;
        *row.get_mut(k)? = reciprocal;
        let row = row.get(k + 1..n)?;
        let solved = *solved;
        for (other, rhs) in below.iter_mut().zip(rhs) {
            let other = other.as_flattened_mut().get_mut(k..n)?;
            let (first, rest) = other.split_first_mut()?;
            let factor = *first * reciprocal;
            axpy(-factor, row, rest);
            *rhs -= factor * solved;
        }
    }
    for (k, row) in rows.iter().enumerate().rev() {
        let (head, solved) = b.split_at_mut_checked(k + 1)?;
        let row = row.as_flattened().get(k..n)?;
        let (reciprocal, row) = row.split_first()?;
        let entry = head.last_mut()?;
        *entry = (*entry - dot(row, solved)) * *reciprocal;
    }
    Some(())
}
