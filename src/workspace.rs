//! Room for the one matrix that a solve by the default method needs beside the factor.

use crate::linearisation::Linearisation;
use crate::resolvent::Resolvent;
use crate::{Factor, Real};

/// One matrix in contact space, by turns that of a Newton step and the resolvent of adapted
/// penalties, or of a factor that has none.
#[derive(Clone, Debug)]
pub(crate) struct Workspace<T, const D: usize, const C: usize> {
    pub(crate) resolvent: Resolvent<T, D, C>,
    pub(crate) linearisation: Linearisation<T, D, C>,
}

impl<T: Real, const D: usize, const C: usize> Workspace<T, D, C> {
    pub(crate) const fn empty() -> Self {
        Self {
            resolvent: Resolvent::empty(),
            linearisation: Linearisation::none(),
        }
    }

    /// The resolvent in use, if there is one: this one, or that of the factor.
    pub(crate) fn resolvent<'a, const N: usize>(
        &'a self,
        has_own: bool,
        factor: &'a Factor<T, N, D, C>,
    ) -> Option<&'a Resolvent<T, D, C>> {
        let own = has_own.then_some(&self.resolvent);
        own.or(factor.resolvent())
    }

    /// Forgets the last linearisation.
    pub(crate) fn forget(&mut self) {
        self.linearisation.forget();
    }
}
