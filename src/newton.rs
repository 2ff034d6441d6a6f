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
use crate::cholesky::dot;
use crate::cone::{add_to_normal, split, square};
use crate::contact_space::{ContactMatrix, ContactVector, normalise, subtract_rows};
use crate::problem::{Law, Problem};
use crate::solution::zeros;
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
    /// A point at rest, not evaluated yet.
    pub(crate) const fn zero() -> Self {
        Self {
            z: [zeros(); C],
            velocity: [zeros(); C],
            impulse: [[T::ZERO; D]; C],
            relative: [[T::ZERO; D]; C],
            residual: [[T::ZERO; D]; C],
            energy: T::ZERO,
            natural_map: T::ZERO,
        }
    }

    /// Moves to `z_i = P_i - r_i / rho_i` of its own `P` and `r`, with `rho_i = scale alpha_i`.
    #[inline(never)]
    pub(crate) fn rebuild<const N: usize>(&mut self, problem: &Problem<'_, T, N, D, C>, scale: T) {
        let contacts = self.z.iter_mut().zip(&self.velocity).zip(&self.impulse);
        for (((z, velocity), &impulse), law) in contacts.zip(problem.laws()) {
            *z = *velocity;
            if law.step > T::ZERO {
                *z -= SVector::from(impulse) * (T::ONE / (scale * law.step));
            }
        }
        self.update(problem, scale);
    }

    /// Evaluates what follows from `z`, with `rho_i = scale alpha_i`.
    #[inline(never)]
    pub(crate) fn update<const N: usize>(&mut self, problem: &Problem<'_, T, N, D, C>, scale: T) {
        let laws = problem.laws();
        let pairs = self.z.iter().zip(&mut self.velocity).zip(&mut self.impulse);
        for (law, (((z, velocity), impulse), residual)) in
            laws.iter().zip(pairs.zip(&mut self.residual))
        {
            let (projection, slip) = law.cone.dual().project_with_length(z);
            *velocity = projection;
            *impulse = ((projection - z) * (scale * law.step)).into();
            // S - P
            let mut rest = -projection;
            add_to_normal(&mut rest, law.lift * slip);
            *residual = rest.into();
        }
        self.natural_map = problem.natural_map(&self.impulse, &mut self.relative);
        self.energy = T::ZERO;
        let pairs = self.residual.iter_mut().zip(&self.relative);
        for (law, (residual, relative)) in laws.iter().zip(pairs) {
            for (residual, &relative) in residual.iter_mut().zip(relative) {
                *residual += relative;
            }
            self.energy += law.step * square(residual);
        }
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
    #[inline(never)]
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
#[inline(never)]
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
        let source = delassus.get(i)?;
        for (l, &j) in coupled.iter().enumerate() {
            let block = blocks.get(j)?;
            for (a, (row, source)) in rows.iter_mut().zip(source).enumerate() {
                let entries = row.get_mut(l)?;
                let source = source.get(j)?;
                for (entry, column) in entries.iter_mut().zip(&block.coupling.data.0) {
                    *entry = product(source, column);
                }
                if k == l {
                    for (entry, column) in entries.iter_mut().zip(&block.own.data.0) {
                        *entry += *column.get(a)?;
                    }
                }
            }
        }
    }
    let rows = workspace.get_mut(..coupled.len())?;
    eliminate::<T, D, C>(rows, rhs.get_mut(..coupled.len())?)?;

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
        problem
            .factor
            .delassus_times(push.get(..laws.len())?, moved.get_mut(..laws.len())?);
        let rhs = point.residual.iter().zip(moved);
        let targets = step.iter_mut().zip(&blocks).zip(rhs).take(laws.len());
        for ((step, block), (&residual, moved)) in targets.filter(|((_, block), _)| block.open) {
            *step = block.solve_open(SVector::from(residual) - SVector::from(moved));
        }
    }
    let finite = step.iter().flatten().all(T::is_finite);
    finite.then_some(step)
}

/// Gaussian elimination by contacts, pivots sought within the rows of each; the solution replaces
/// `b`.
#[inline(never)]
fn eliminate<T: Real, const D: usize, const C: usize>(
    matrix: &mut [[ContactVector<T, D, C>; D]],
    b: &mut [[T; D]],
) -> Option<()> {
    let n = matrix.len();
    for k in 0..n {
        let (done, below) = matrix.split_at_mut_checked(k + 1)?;
        let (solved, rest) = b.split_at_mut_checked(k + 1)?;
        let (rows, rhs) = (done.last_mut()?, solved.last_mut()?);
        normalise(rows, k, k, n, Some(rhs))?;
        let swapped = *rhs;
        for (solved, row) in rhs.iter_mut().zip(&*rows) {
            *solved = product(row.get(k)?, &swapped);
        }
        for (others, other_rhs) in below.iter_mut().zip(rest) {
            for (row, entry) in others.iter_mut().zip(other_rhs) {
                let factors = *row.get(k)?;
                subtract_rows(row, &factors, rows, (k + 1) * D, n * D);
                *entry -= product(&factors, rhs);
            }
        }
    }
    for (k, rows) in matrix.iter().enumerate().rev() {
        let (head, solved) = b.split_at_mut_checked(k + 1)?;
        for (entry, row) in head.last_mut()?.iter_mut().zip(rows) {
            let row = row.get(k + 1..n)?;
            *entry -= dot(row.as_flattened(), solved.as_flattened());
        }
    }
    Some(())
}

/// Scalar product in the rows of one contact.
#[inline]
fn product<T: Real, const D: usize>(x: &[T; D], y: &[T; D]) -> T {
    x.iter().zip(y).fold(T::ZERO, |sum, (&x, &y)| sum + x * y)
}
