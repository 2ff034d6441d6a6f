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
use crate::cone::{add_to_normal, square};
use crate::contact_space::{
    ContactMatrix, ContactVector, back_substitute, row_times, subtract_rows, triangularise,
};
use crate::problem::{Law, Problem};
use crate::solution::zeros;
use heapless::Vec;
use nalgebra::SVector;

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

    /// Moves to rest.
    pub(crate) fn reset<const N: usize>(&mut self, problem: &Problem<'_, T, N, D, C>, scale: T) {
        *self = Self::zero();
        self.update(problem, scale);
    }

    /// Moves to `z_i = P_i - r_i / rho_i` of its own `P` and `r`, with `rho_i = scale alpha_i`.
    #[inline(never)]
    pub(crate) fn rebuild<const N: usize>(&mut self, problem: &Problem<'_, T, N, D, C>, scale: T) {
        let sources = self.velocity.iter().zip(&self.impulse);
        let contacts = self.z.iter_mut().zip(sources);
        for ((z, (velocity, &impulse)), law) in contacts.zip(problem.laws()) {
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
        let targets = self.velocity.iter_mut();
        let targets = targets.zip(&mut self.impulse);
        let targets = targets.zip(&mut self.residual);
        let sources = laws.iter().zip(&self.z);
        for ((law, z), ((velocity, impulse), residual)) in sources.zip(targets) {
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
        let pairs = self.residual.iter_mut();
        let pairs = pairs.zip(&self.relative);
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
    coupling: [[T; D]; D],
    /// `DP - DS + λI`
    own: [[T; D]; D],
    /// In the interior of `K*`: `DP = I`.
    open: bool,
}

impl<T: Real, const D: usize> Block<T, D> {
    /// What stands in a place that is not used.
    const fn none() -> Self {
        Self {
            coupling: [[T::ZERO; D]; D],
            own: [[T::ZERO; D]; D],
            open: true,
        }
    }

    #[inline(never)]
    fn set(&mut self, law: &Law<T, D>, z: &SVector<T, D>, scale: T, regularisation: T) {
        let (derivative, direction) = law.cone.dual().derivative(z);
        let derivative = derivative.data.0; // symmetric: columns are rows
        let direction: [T; D] = direction.into();
        let scale = scale * law.step;
        self.open = true;
        self.own = derivative;
        // DS = mu e_N (P_T / |P_T|)ᵀ DP
        let slip = row_times(&direction, &derivative);
        if let Some(normal) = self.own.first_mut() {
            for (entry, slip) in normal.iter_mut().zip(slip) {
                *entry -= law.lift * slip;
            }
        }
        let rows = self.coupling.iter_mut().zip(&mut self.own).zip(&derivative);
        for (i, ((coupling, own), derivative)) in rows.enumerate() {
            for (j, (coupling, &derivative)) in coupling.iter_mut().zip(derivative).enumerate() {
                let identity = if i == j { T::ONE } else { T::ZERO };
                self.open &= derivative == identity;
                *coupling = (identity * (T::ONE + regularisation) - derivative) * scale;
            }
            if let Some(own) = own.get_mut(i) {
                *own += regularisation;
            }
        }
    }

    /// The step of an open contact, from what the others leave of its equation.
    fn solve_open(&self, rhs: &[T; D]) -> [T; D] {
        // `own` is (1 + λ) I but for its first row.
        let diagonal = self.own.as_flattened().last().copied().unwrap_or(T::ONE);
        let mut step = rhs.map(|rhs| rhs / diagonal);
        if let (Some(row), Some(&rhs)) = (self.own.first(), rhs.first())
            && let (Some((&own, row)), Some((normal, tangents))) =
                (row.split_first(), step.split_first_mut())
        {
            let coupled = row.iter().zip(tangents);
            let rest = coupled.fold(rhs, |rest, (&own, &mut step)| rest - own * step);
            *normal = rest / own;
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
    let mut blocks = [const { Block::none() }; C];
    let mut coupled = Vec::<usize, C>::new();
    for (i, ((block, law), z)) in &mut blocks.iter_mut().zip(laws).zip(&point.z).enumerate() {
        block.set(law, z, scale, regularisation);
        if !block.open {
            coupled.push(i).ok()?;
        }
    }

    // The rows and columns of the contacts that are not open, close together.
    let delassus = problem.factor.delassus();
    let mut rhs = [[T::ZERO; D]; C];
    let coupled = &coupled;
    for (l, &j) in coupled.iter().enumerate() {
        *rhs.get_mut(l)? = *point.residual.get(j)?;
        let Block { coupling, own, .. } = blocks.get(j)?;
        for (k, (rows, &i)) in workspace.iter_mut().zip(coupled).enumerate() {
            for (a, (row, source)) in rows.iter_mut().zip(delassus.get(i)?).enumerate() {
                let mut entries = row_times(source.get(j)?, coupling);
                if k == l {
                    for (entry, own) in entries.iter_mut().zip(own.get(a)?) {
                        *entry += *own;
                    }
                }
                *row.get_mut(l)? = entries;
            }
        }
    }
    let rows = workspace.get_mut(..coupled.len())?;
    eliminate::<T, D, C>(rows, rhs.get_mut(..coupled.len())?)?;

    // Back to all contacts; the open ones follow from the impulses of the others.
    let mut step = [zeros(); C];
    let mut push = [[T::ZERO; D]; C];
    for (rhs, &i) in rhs.iter().zip(coupled) {
        *step.get_mut(i)? = SVector::from(*rhs);
        for (push, row) in push.get_mut(i)?.iter_mut().zip(&blocks.get(i)?.coupling) {
            *push = product(row, rhs);
        }
    }
    if coupled.len() < laws.len() {
        let mut rest = [[T::ZERO; D]; C];
        let contacts = ..laws.len();
        problem
            .factor
            .delassus_times(push.get(contacts)?, rest.get_mut(contacts)?);
        let targets = step
            .iter_mut()
            .zip(&blocks)
            .zip(&mut rest)
            .zip(&point.residual);
        for (((step, block), rest), residual) in targets.take(laws.len()) {
            if block.open {
                for (rest, &residual) in rest.iter_mut().zip(residual) {
                    *rest = residual - *rest;
                }
                *step = block.solve_open(rest).into();
            }
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
    let mut pivots = [[T::ZERO; D]; C];
    for (k, pivots) in pivots.iter_mut().enumerate().take(n) {
        let (done, below) = matrix.split_at_mut_checked(k + 1)?;
        let (solved, rest) = b.split_at_mut_checked(k + 1)?;
        let (rows, rhs) = (done.last_mut()?, solved.last_mut()?);
        *pivots = triangularise(rows, k, k, n, Some(rhs))?;
        for (others, other_rhs) in below.iter_mut().zip(rest) {
            for (row, entry) in others.iter_mut().zip(other_rhs) {
                let factors = divide(row.get(k)?, rows, k, pivots)?;
                subtract_rows(row, &factors, rows, (k + 1) * D, n * D);
                *entry -= product(&factors, rhs);
            }
        }
    }
    for (k, (rows, pivots)) in matrix.iter().zip(&pivots).enumerate().rev() {
        let (head, solved) = b.split_at_mut_checked(k + 1)?;
        let target = head.last_mut()?;
        for (entry, row) in target.iter_mut().zip(rows) {
            *entry -= dot(row.get(k + 1..n)?.as_flattened(), solved.as_flattened());
        }
        back_substitute(rows, k, pivots, target)?;
    }
    Some(())
}

/// Solves `xᵀ U = yᵀ` for the upper triangle of the diagonal block of contact `k`.
#[inline]
fn divide<T: Real, const D: usize, const C: usize>(
    y: &[T; D],
    rows: &[ContactVector<T, D, C>; D],
    k: usize,
    pivots: &[T; D],
) -> Option<[T; D]> {
    let mut x = *y;
    for (p, (row, &pivot)) in rows.iter().zip(pivots).enumerate() {
        let (head, rest) = x.split_at_mut_checked(p + 1)?;
        let entry = head.last_mut()?;
        *entry *= pivot;
        for (x, &u) in rest.iter_mut().zip(row.get(k)?.get(p + 1..)?) {
            *x -= *entry * u;
        }
    }
    Some(x)
}

/// Scalar product in the rows of one contact.
#[inline]
fn product<T: Real, const D: usize>(x: &[T; D], y: &[T; D]) -> T {
    x.iter().zip(y).fold(T::ZERO, |sum, (&x, &y)| sum + x * y)
}
