//! Contacts that pull.

use super::Parameter;
use crate::error::Error;
use crate::real::Real;
use nalgebra::{SMatrix, SVector};

/// A contact that pulls while it touches: a suction cup, a magnet.
///
/// With the largest pull `a = h force` the impulse `r + a e_N` lies in the friction cone, because suction presses the contact. So
/// [`Self::push_back`] takes `a` from the free impulse before the solve, and [`Self::impulse`] takes it from the solved impulse.
///
/// ```
/// use nalgebra::{Matrix1, matrix, vector};
/// use stiction::{Contact, Kernel, Settings, time_stepping::Suction};
///
/// // 1 kg hangs from a suction cup at the ceiling: the contact's normal points down.
/// let (step, cup, contact_jacobian) = (0.5, Suction { force: 16.0, touches: true }, matrix![-1.0]);
/// let mut kernel = Kernel::<f64, 1, 1, 1>::new();
/// kernel.scene_mut().set_mass(&Matrix1::new(1.0))?;
/// let (jacobian, offset) = (contact_jacobian, vector![0.0]);
/// kernel.scene_mut().push(&Contact { jacobian, offset, mu: 0.0, key: 0 })?;
/// let mut push = vector![-9.81 * step];
/// cup.push_back(&contact_jacobian, step, &mut push)?;
/// let solution = kernel.solve(&push, &Settings::new(1e-9))?;
/// let impulse = cup.impulse(&solution.contacts[0].impulse, step)?;
/// assert!(solution.velocity[0].abs() < 1e-9 && (impulse[0] + 9.81 * step).abs() < 1e-8); // it pulls
/// # Ok::<(), stiction::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Suction<T> {
    /// Largest pull, not negative (N).
    pub force: T,
    /// True if the contact touches at the beginning of the step. Across a gap it does not pull.
    pub touches: bool,
}

impl<T: Real> Suction<T> {
    /// Subtracts the pull of a contact with this Jacobian (`D × N`), over a `step > 0` (s), from the free impulse (N·s).
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] with [`Parameter::Suction`] or the step.
    pub fn push_back<const N: usize, const D: usize>(
        &self,
        jacobian: &SMatrix<T, D, N>,
        step: T,
        free_impulse: &mut SVector<T, N>,
    ) -> Result<(), Error> {
        let pull = self.pull(step)?;
        for (impulse, column) in free_impulse.iter_mut().zip(&jacobian.data.0) {
            *impulse -= pull * column.first().copied().unwrap_or(T::ZERO);
        }
        Ok(())
    }

    /// Impulse of the contact (N·s), which may pull, from its impulse in the solution.
    ///
    /// # Errors
    /// As of [`Self::push_back`].
    pub fn impulse<const D: usize>(&self, solved: &SVector<T, D>, step: T) -> Result<SVector<T, D>, Error> {
        let mut impulse = *solved;
        crate::cone::add_to_normal(&mut impulse, -self.pull(step)?);
        Ok(impulse)
    }

    /// Largest pull over a step (N·s), 0 if the contact does not touch.
    fn pull(&self, step: T) -> Result<T, Error> {
        let force = Parameter::Suction.not_negative(self.force)?;
        let pull = Parameter::Suction.finite(Parameter::Step.positive(step)? * force)?;
        Ok(if self.touches { pull } else { T::ZERO })
    }
}
