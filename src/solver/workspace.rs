//! Room for the one matrix that a solve by the default method needs beside the factor.

use crate::Real;
use crate::laws::{Coulomb, Laws};
use crate::linalg::blocks::ContactMatrix;
use crate::linalg::elimination::Elimination;
use crate::problem::Problem;
use crate::solver::jacobian::Jacobian;
use crate::solver::point::Point;

/// One matrix in contact space, factorised: by turns the Jacobian of a Newton step and that of the interior point.
#[derive(Clone, Debug)]
pub(crate) struct Workspace<T: Real, const D: usize, const C: usize, L: Laws = Coulomb> {
    matrix: ContactMatrix<T, D, C>,
    /// What of the Jacobian is not in the matrix.
    pub(super) jacobian: Jacobian<T, D, C, L>,
    /// Is the matrix that of the Jacobian?
    holds_jacobian: bool,
}

impl<T: Real, const D: usize, const C: usize, L: Laws> Workspace<T, D, C, L> {
    /// Nothing in it.
    pub(crate) const fn none() -> Self {
        Self {
            matrix: [[[[T::ZERO; D]; C]; D]; C],
            jacobian: Jacobian::none(),
            holds_jacobian: false,
        }
    }

    /// Forgets what is in it.
    pub(crate) fn forget(&mut self) {
        self.holds_jacobian = false;
    }

    /// Is a Jacobian kept?
    pub(crate) fn holds_jacobian(&self) -> bool {
        self.holds_jacobian
    }

    /// The Jacobian that is kept, and its matrix.
    pub(crate) fn kept(&self) -> Option<(&Jacobian<T, D, C, L>, &ContactMatrix<T, D, C>)> {
        self.holds_jacobian
            .then_some((&self.jacobian, &self.matrix))
    }

    /// Computes the Jacobian at a point; `None` if it is singular.
    #[inline]
    pub(crate) fn linearise<const N: usize>(
        &mut self,
        problem: &Problem<'_, T, N, D, C, L>,
        point: &Point<T, D, C>,
        damping: T,
    ) -> Option<(&Jacobian<T, D, C, L>, &ContactMatrix<T, D, C>)> {
        self.forget();
        let matrix = &mut self.matrix;
        self.jacobian.compute(problem, point, damping, matrix)?;
        self.holds_jacobian = true;
        self.kept()
    }

    /// Lends the matrix, and what eliminates in it, to the interior point.
    pub(crate) fn lend(&mut self) -> (&mut ContactMatrix<T, D, C>, &mut Elimination<T, D, C>) {
        self.forget();
        (&mut self.matrix, &mut self.jacobian.elimination)
    }
}

#[cfg(test)]
mod tests;
