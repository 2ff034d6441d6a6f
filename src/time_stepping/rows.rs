//! Helpers that make joint rows.

use super::Parameter;
use super::offsets::{Gap, closing_speed, reciprocal};
use crate::error::Error;
use crate::real::Real;
use crate::scene::{JointRow, RowLaw};
use nalgebra::SVector;

/// Stop of a joint, `0 <= λ ⟂ row · v + distance / h >= 0`: a [`Gap`] (in rad and rad/s, or m and m/s), with its [`Gap::row`].
///
/// ```
/// use nalgebra::vector;
/// use stiction::time_stepping::JointLimit;
///
/// let stop = JointLimit { distance: 0.125, recovery: 0.5, ..JointLimit::default() };
/// let knee = stop.row(vector![0.0, 1.0], 0.25, 7)?;
/// assert_eq!((knee.offset, knee.key), (0.5, 7)); // half a radian a second, and no faster
/// # Ok::<(), stiction::Error>(())
/// ```
pub type JointLimit<T> = Gap<T>;

impl<T: Real> Gap<T> {
    /// The row of a joint's stop over a `step > 0` (s).
    ///
    /// `distance` is how far the joint is from its stop (rad, m); `row` points away from that: 1 at the joint with `distance = q - q_min` for
    /// the lower stop, -1 with `q_max - q` for the upper one.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] as of [`Gap::offset`], with [`Parameter::Distance`]. (The scene checks `row`, here and below.)
    pub fn row<const N: usize>(
        &self,
        row: SVector<T, N>,
        step: T,
        key: u32,
    ) -> Result<JointRow<T, N>, Error> {
        let offset = closing_speed(Parameter::Distance, self, Parameter::Step.positive(step))?;
        Ok(rigid(row, offset, RowLaw::Limit, key))
    }
}

/// Dry friction of a joint: a torque up to a limit holds the joint, or slows it down.
///
/// ```
/// use nalgebra::vector;
/// use stiction::{RowLaw, time_stepping::DryFriction};
///
/// let gear = DryFriction { torque: 0.5 }.row(vector![1.0], 0.25, 0)?;
/// assert_eq!(gear.law, RowLaw::Box { lower: -0.125, upper: 0.125 });
/// # Ok::<(), stiction::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DryFriction<T> {
    /// Largest torque, not negative (N·m, N).
    pub torque: T,
}

impl<T: Real> DryFriction<T> {
    /// The row over a `step > 0` (s).
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] with the torque if it is negative or not finite or its impulse overflows, or with the step.
    pub fn row<const N: usize>(
        &self,
        row: SVector<T, N>,
        step: T,
        key: u32,
    ) -> Result<JointRow<T, N>, Error> {
        let law = within(Parameter::Torque, self.torque, step)?;
        Ok(rigid(row, T::ZERO, law, key))
    }
}

/// A motor with a position and velocity controller and a torque limit, as one row.
///
/// Its torque is `τ = -k_p (q + h q̇ - q_d) - k_d (q̇ - v_d) + τ_ff` within `± limit`, with `q̇ = row · v` at the end of the
/// step. So stiff gains are stable at any step, and the limit is exact.
///
/// ```
/// use nalgebra::vector;
/// use stiction::{RowLaw, time_stepping::Motor};
///
/// let knee = Motor { stiffness: 4.0, damping: 1.0, limit: 8.0, ahead: 0.5, ..Motor::default() };
/// let row = knee.row(vector![1.0], 0.25, 0)?;
/// assert_eq!((row.offset, row.compliance), (1.0, 2.0));
/// assert_eq!(row.law, RowLaw::Box { lower: -2.0, upper: 2.0 });
/// # Ok::<(), stiction::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Motor<T> {
    /// Gain `k_p >= 0` of the position (N·m/rad, N/m).
    pub stiffness: T,
    /// Gain `k_d >= 0` of the velocity (N·m·s/rad, N·s/m). At least one of the gains is above 0.
    pub damping: T,
    /// Torque `τ_ff` (N·m, N) added to that of the gains.
    pub feedforward: T,
    /// Largest torque, not negative (N·m, N). With infinity (default) the row is a [`RowLaw::Equality`].
    pub limit: T,
    /// Position minus wanted position, `q - q_d`, at the beginning of the step (rad, m).
    pub ahead: T,
    /// Wanted velocity `v_d` (rad/s, m/s).
    pub target: T,
}

impl<T: Real> Default for Motor<T> {
    /// One without gains, feedforward and target, all 0, and without a limit, infinity.
    fn default() -> Self {
        Self {
            stiffness: T::ZERO,
            damping: T::ZERO,
            feedforward: T::ZERO,
            limit: T::INFINITY,
            ahead: T::ZERO,
            target: T::ZERO,
        }
    }
}

impl<T: Real> Motor<T> {
    /// The row over a `step > 0` (s).
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] with the argument that is negative or not finite (the limit may be infinite), with
    /// [`Parameter::MotorGains`] if both gains are 0, or with the argument that makes the offset or the compliance overflow.
    pub fn row<const N: usize>(
        &self,
        row: SVector<T, N>,
        step: T,
        key: u32,
    ) -> Result<JointRow<T, N>, Error> {
        let stiffness = Parameter::MotorStiffness.not_negative(self.stiffness)?;
        let damping = Parameter::MotorDamping.not_negative(self.damping)?;
        let feedforward = Parameter::Feedforward.finite(self.feedforward)?;
        let ahead = Parameter::Ahead.finite(self.ahead)?;
        let target = Parameter::Target.finite(self.target)?;
        let step = Parameter::Step.positive(step)?;
        let law = if self.limit == T::INFINITY {
            RowLaw::Equality
        } else {
            within(Parameter::TorqueLimit, self.limit, step)?
        };

        let implicit = Parameter::MotorStiffness.finite(step * stiffness)?;
        let gain = Parameter::MotorDamping.finite(damping + implicit)?;
        Parameter::MotorGains.finite(T::ONE / gain)?;
        let offset = (stiffness * ahead - damping * target - feedforward) / gain;
        if !offset.is_finite() {
            let overflows = |term: T| !(term / gain).is_finite();
            return Err(if overflows(stiffness * ahead) {
                Parameter::Ahead.error()
            } else if overflows(damping * target) {
                Parameter::Target.error()
            } else {
                Parameter::Feedforward.error()
            });
        }
        Ok(JointRow { row, offset, law, compliance: reciprocal(step, gain, Parameter::MotorGains)?, key })
    }
}

/// One row of a closed loop or of a gear: `row · v + drift / h = 0`. It removes the drift within the step. Redundant rows do no harm.
///
/// ```
/// use nalgebra::vector;
/// use stiction::time_stepping::ClosedLoop;
///
/// // Two fingers that mimic each other.
/// let finger = ClosedLoop { drift: 0.5, recovery: 1.0 }.row(vector![1.0, -1.0], 0.25, 0)?;
/// assert_eq!(finger.offset, 1.0);
/// # Ok::<(), stiction::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ClosedLoop<T> {
    /// Position error of the loop (m, rad), of which the row is the derivative: 0 (default) while the loop is closed.
    pub drift: T,
    /// Largest speed at which the drift is removed (m/s, rad/s), not negative, infinite by default.
    pub recovery: T,
}

impl<T: Real> Default for ClosedLoop<T> {
    fn default() -> Self {
        Self { drift: T::ZERO, recovery: T::INFINITY }
    }
}

impl<T: Real> ClosedLoop<T> {
    /// The row over a `step > 0` (s).
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] as of [`Gap::offset`], with [`Parameter::Drift`].
    pub fn row<const N: usize>(
        &self,
        row: SVector<T, N>,
        step: T,
        key: u32,
    ) -> Result<JointRow<T, N>, Error> {
        let gap = Gap {
            distance: Parameter::Drift.finite(self.drift)?,
            recovery: self.recovery,
            reach: self.recovery,
        };
        let offset = closing_speed(Parameter::Drift, &gap, Parameter::Step.positive(step))?;
        Ok(rigid(row, offset, RowLaw::Equality, key))
    }
}

/// A joint row without compliance.
const fn rigid<T: Real, const N: usize>(
    row: SVector<T, N>,
    offset: T,
    law: RowLaw<T>,
    key: u32,
) -> JointRow<T, N> {
    JointRow { row, offset, law, compliance: T::ZERO, key }
}

/// The box of the impulses of torques within `±torque` over a step.
fn within<T: Real>(name: Parameter, torque: T, step: T) -> Result<RowLaw<T>, Error> {
    let torque = name.not_negative(torque)?;
    let upper = name.finite(Parameter::Step.positive(step)? * torque)?;
    Ok(RowLaw::Box { lower: -upper, upper })
}
