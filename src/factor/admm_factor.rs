//! [`AdmmFactor`]: a factor with the resolvent that ADMM needs.

use super::Factor;
use crate::error::Error;
use crate::factor::resolvent::Resolvent;
use crate::real::Real;
use crate::scene::Scene;

/// A [`Factor`] with its resolvent `(I + rho W)⁻¹`, for [`crate::AdmmSolver`], which has an example.
#[derive(Clone, Debug)]
pub struct AdmmFactor<T: Real, const N: usize, const D: usize, const C: usize> {
    factor: Factor<T, N, D, C>,
    resolvent: Resolvent<T, D, C>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize> AdmmFactor<T, N, D, C> {
    /// An empty factor for [`Self::prepare`]. It is all zeros, so a `static` takes no flash.
    #[must_use]
    pub const fn empty() -> Self {
        Self { factor: Factor::empty(), resolvent: Resolvent::empty() }
    }

    /// The factor of a scene.
    ///
    /// # Errors
    /// As [`Self::prepare`].
    pub fn new<const S: usize>(scene: &Scene<T, N, D, C, 0, S>) -> Result<Self, Error> {
        let mut factor = Self::empty();
        factor.prepare(scene)?;
        Ok(factor)
    }

    /// Factorises a scene in place, with the default penalty: a power of two near 6 times the mass that contacts feel.
    ///
    /// # Errors
    /// As [`Factor::prepare`]; [`Error::InvalidPenalty`] if `HᵀH / M` overflows, or if the entries of `W` differ so much in size that
    /// `I + rho W` is singular in this number type. The factor is then empty.
    pub fn prepare<const S: usize>(&mut self, scene: &Scene<T, N, D, C, 0, S>) -> Result<(), Error> {
        self.factor.prepare(scene)?;
        let result = self.resolvent.compute(&self.factor, scene.default_penalty());
        if result.is_err() {
            self.factor.clear();
        }
        result
    }

    /// Sets the penalty `rho` (kg). It factorises `I + rho W` again, but not `M`.
    ///
    /// # Errors
    /// [`Error::InvalidPenalty`] if `rho` is not positive and finite, or so large that
    /// `I + rho W` is singular in this number type. The factor keeps its old penalty.
    pub fn set_penalty(&mut self, penalty: T) -> Result<(), Error> {
        let old = self.penalty();
        let result = self.resolvent.compute(&self.factor, penalty);
        if result.is_err() && self.resolvent.compute(&self.factor, old).is_err() {
            self.factor.clear();
        }
        result
    }

    /// The penalty `rho` (kg) of the augmented Lagrangian.
    #[must_use]
    pub const fn penalty(&self) -> T {
        self.resolvent.penalty
    }

    /// The factor without the resolvent.
    #[must_use]
    pub const fn factor(&self) -> &Factor<T, N, D, C> {
        &self.factor
    }

    /// `(I + rho W)⁻¹`
    pub(crate) const fn resolvent(&self) -> &Resolvent<T, D, C> {
        &self.resolvent
    }
}
