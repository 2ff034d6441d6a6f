//! Room for the one matrix that a solve by the default method needs beside the factor.

use crate::factor::resolvent::Resolvent;
use crate::linalg::blocks::ContactMatrix;
use crate::linalg::elimination::Elimination;
use crate::problem::Problem;
use crate::solver::jacobian::Jacobian;
use crate::solver::point::Point;
use crate::{Factor, Real};

/// One matrix in contact space: by turns the Jacobian of a Newton step, factorised, and the resolvent of adapted
/// penalties, or of a factor that has none.
#[derive(Clone, Debug)]
pub(crate) struct Workspace<T, const D: usize, const C: usize> {
    room: Resolvent<T, D, C>,
    /// What of the Jacobian is not in the room.
    pub(super) jacobian: Jacobian<T, D, C>,
    content: Content,
}

/// What the matrix is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Content {
    Nothing,
    Jacobian,
    Resolvent,
}

impl<T: Real, const D: usize, const C: usize> Workspace<T, D, C> {
    /// Nothing in it.
    pub(crate) const fn none() -> Self {
        Self {
            room: Resolvent::empty(),
            jacobian: Jacobian::none(),
            content: Content::Nothing,
        }
    }

    /// A Jacobian is kept from solve to solve, a resolvent is not.
    pub(crate) fn begin(&mut self) {
        if self.content == Content::Resolvent {
            self.content = Content::Nothing;
        }
    }

    /// Forgets what is in it.
    pub(crate) fn forget(&mut self) {
        self.content = Content::Nothing;
    }

    /// Forgets a Jacobian.
    pub(crate) fn forget_jacobian(&mut self) {
        if self.content == Content::Jacobian {
            self.content = Content::Nothing;
        }
    }

    /// Is a Jacobian kept?
    pub(crate) fn holds_jacobian(&self) -> bool {
        self.content == Content::Jacobian
    }

    /// The Jacobian that is kept, and its matrix.
    pub(crate) fn kept(&self) -> Option<(&Jacobian<T, D, C>, &ContactMatrix<T, D, C>)> {
        self.holds_jacobian()
            .then_some((&self.jacobian, &self.room.matrix))
    }

    /// Computes the Jacobian at a point; `None` if it is singular.
    #[inline]
    pub(crate) fn linearise<const N: usize>(
        &mut self,
        problem: &Problem<'_, T, N, D, C>,
        point: &Point<T, D, C>,
        scale: T,
        damping: T,
    ) -> Option<(&Jacobian<T, D, C>, &ContactMatrix<T, D, C>)> {
        self.content = Content::Nothing;
        let matrix = &mut self.room.matrix;
        self.jacobian
            .compute(problem, point, scale, damping, matrix)?;
        self.content = Content::Jacobian;
        self.kept()
    }

    /// Lends the matrix, and what eliminates in it.
    pub(crate) fn lend(&mut self) -> (&mut ContactMatrix<T, D, C>, &mut Elimination<T, D, C>) {
        self.content = Content::Nothing;
        (&mut self.room.matrix, &mut self.jacobian.elimination)
    }

    /// Computes a resolvent of this solve's own; nothing is left if there is none for these penalties.
    pub(crate) fn resolve<const N: usize>(
        &mut self,
        factor: &Factor<T, N, D, C>,
        penalties: &[T; C],
    ) {
        let (delassus, contacts) = (factor.delassus(), factor.contacts());
        let computed = self.room.compute(delassus, contacts, penalties);
        self.content = if computed.is_ok() {
            Content::Resolvent
        } else {
            Content::Nothing
        };
    }

    /// The resolvent in use, if there is one: this one, or that of the factor.
    pub(crate) fn resolvent<'a, const N: usize>(
        &'a self,
        factor: &'a Factor<T, N, D, C>,
    ) -> Option<&'a Resolvent<T, D, C>> {
        let own = self.content == Content::Resolvent;
        own.then_some(&self.room).or(factor.resolvent())
    }
}
