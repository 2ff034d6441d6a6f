//! Semismooth Newton on the fixed-point map of ADMM, in contact space: the point.
//!
//! With one vector `z` a contact, `P = Π_{K*}(z)` and `r = rho_i (P - z)`, the impulse lies in `K`
//! and is complementary to `P` whatever `z` is; a solution is a root of
//!
//! `E(z) = W r + q + S(P) - P`, `S_i = mu_i |P_Ti| e_N`.
//!
//! `E` needs no resolvent: the penalty is only a scale here, so each contact has its own, its
//! effective mass `rho_i = alpha_i`. A step `d` solves the linearised equation, see
//! [`crate::solver::jacobian`].

use crate::Real;
use crate::cone::{add_to_normal, square};
use crate::laws::{Laws, Room};
use crate::linalg::blocks::ContactVector;
use crate::linalg::hints::rolled;
use crate::problem::Problem;
use crate::problem::residual;
use crate::solution::zeros;
use nalgebra::SVector;

/// A point `z` and what follows from it.
#[derive(Clone, Debug)]
pub(crate) struct Point<T, const D: usize, const C: usize> {
    pub(crate) z: [SVector<T, D>; C],
    /// `P = Π_{K*}(z)`
    pub(crate) p: [SVector<T, D>; C],
    /// `r`
    pub(crate) r: ContactVector<T, D, C>,
    /// `u = W r + q`
    pub(crate) u: ContactVector<T, D, C>,
    /// `E(z)`
    pub(crate) residual: ContactVector<T, D, C>,
    /// `Σ alpha_i |E_i|²`, what a step has to reduce. An energy, and not its root, so that units
    /// scaled by powers of two change nothing but exponents.
    pub(crate) merit: T,
    /// First part of the error.
    pub(crate) natural_map: T,
}

impl<T: Real, const D: usize, const C: usize> Point<T, D, C> {
    /// No point yet.
    pub(crate) const fn none() -> Self {
        Self {
            z: [zeros(); C],
            p: [zeros(); C],
            r: [[T::ZERO; D]; C],
            u: [[T::ZERO; D]; C],
            residual: [[T::ZERO; D]; C],
            merit: T::ZERO,
            natural_map: T::ZERO,
        }
    }

    /// Sets `r = 0` and `P = 0`, from where sweeps set off; `z`, residual and merit are stale until [`Self::rebuild`].
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn set_zero_impulse<const N: usize, L: Laws>(
        &mut self,
        problem: &Problem<'_, T, N, D, C, L>,
    ) {
        self.p = [zeros(); C];
        self.r = [[T::ZERO; D]; C];
        problem.free_velocities(&mut self.u);
        self.natural_map = if L::MIXED {
            problem.natural_map_at(&self.r, &self.u)
        } else {
            residual::quotient(problem.alone, problem.size)
        };
    }

    /// Moves to `z_i = P_i - r_i / rho_i` of its own `P` and `r`, with `rho_i = alpha_i`.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn rebuild<const N: usize, L: Laws>(
        &mut self,
        problem: &Problem<'_, T, N, D, C, L>,
    ) {
        let sources = self.p.iter().zip(&self.r);
        let contacts = self.z.iter_mut().zip(sources);
        for ((z, (velocity, &impulse)), law) in contacts.zip(problem.laws()) {
            rolled();
            *z = *velocity;
            if law.alpha > T::ZERO {
                *z -= SVector::from(impulse) * (T::ONE / law.alpha);
            }
        }
        self.update(problem);
    }

    /// Moves to `z_i = û_i - r_i / rho_i` of its own `r` and `u`.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn rebuild_from_velocity<const N: usize, L: Laws>(
        &mut self,
        problem: &Problem<'_, T, N, D, C, L>,
    ) {
        problem.augmented_velocity(&self.u, &mut self.p);
        self.rebuild(problem);
    }

    /// Moves `z`, and nothing else, to `start + step length`.
    pub(crate) fn go(&mut self, start: &[SVector<T, D>; C], step: &[SVector<T, D>; C], length: T) {
        for (z, (start, step)) in self.z.iter_mut().zip(start.iter().zip(step)) {
            rolled();
            *z = start + step * length;
        }
    }

    /// Evaluates what follows from `z`, with `rho_i = alpha_i`.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn update<const N: usize, L: Laws>(&mut self, problem: &Problem<'_, T, N, D, C, L>) {
        let laws = problem.laws();
        let targets = self.p.iter_mut();
        let targets = targets.zip(&mut self.r);
        let targets = targets.zip(&mut self.residual);
        let sources = laws.iter().zip(&self.z);
        for ((law, z), ((velocity, impulse), residual)) in sources.zip(targets) {
            rolled();
            if let Some(rows) = law.rows.get() {
                // Whoever holds is to have no velocity to the bit, and whoever does not its bound: `alpha` is a power of two.
                let push = rows.project(&(z * -law.alpha));
                (*velocity, *impulse) = (z + push / law.alpha, push.into());
                *residual = (-*velocity).into();
                continue;
            }
            let (projection, slip) = law.cone.dual().project_with_length(z);
            *velocity = projection;
            *impulse = ((projection - z) * law.alpha).into();
            // S - P
            let mut rest = -projection;
            add_to_normal(&mut rest, law.shift_factor * slip);
            *residual = rest.into();
        }
        self.natural_map = problem.natural_map(&self.r, &mut self.u);
        self.merit = T::ZERO;
        let pairs = self.residual.iter_mut();
        let pairs = pairs.zip(&self.u);
        for (law, (residual, relative)) in laws.iter().zip(pairs) {
            rolled();
            for (residual, &relative) in residual.iter_mut().zip(relative) {
                *residual += relative;
            }
            self.merit += law.alpha * square(residual);
        }
    }
}
