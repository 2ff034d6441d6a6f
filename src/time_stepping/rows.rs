//! What joint rows and compliance are made of.

use super::{Parameter, closing_speed};
use crate::{Error, JointRow, Real, RowLaw};
use nalgebra::SVector;

/// Stop of a joint `distance` (rad, m) away, infinite if it has none, `0 <= λ ⟂ row · v + distance / h >= 0`.
///
/// `row` points away from the stop: 1 at the joint with `distance = q - q_min` for the lower stop, -1 with `q_max - q` for
/// the upper one. A joint beyond its stop comes back at `recovery >= 0` (rad/s, m/s) at most; `recovery`, `reach` and
/// `step > 0` (s) are as for [`super::gap`].
///
/// # Errors
/// [`Error::InvalidParameter`] as of [`super::gap`], with [`Parameter::Distance`]. (The scene checks `row`, here and below.)
///
/// ```
/// # use nalgebra::vector;
/// # use stiction::time_stepping::joint_limit;
/// let (step, recovery, reach) = (0.25, 0.5, 100.0);
/// let knee = joint_limit(vector![0.0, 1.0], 0.125, step, recovery, reach, 7)?;
/// assert_eq!((knee.offset, knee.key), (0.5, 7)); // half a radian a second, and no faster
/// # Ok::<(), stiction::Error>(())
/// ```
pub fn joint_limit<T: Real, const N: usize>(
    row: SVector<T, N>,
    distance: T,
    step: T,
    recovery: T,
    reach: T,
    key: u32,
) -> Result<JointRow<T, N>, Error> {
    Ok(JointRow {
        row,
        offset: closing_speed(Parameter::Distance, distance, step, recovery, reach)?,
        law: RowLaw::Limit,
        compliance: T::ZERO,
        key,
    })
}

/// Dry friction of a joint, up to a `torque >= 0` (N·m, N): the joint stands still if that is enough, or is slowed down by it.
///
/// # Errors
/// [`Error::InvalidParameter`] with the torque, if it is negative or not finite or its impulse overflows; or with `step > 0` (s).
///
/// ```
/// # use nalgebra::vector;
/// # use stiction::{RowLaw, time_stepping::dry_friction};
/// let gear = dry_friction(vector![1.0], 0.5, 0.25, 0)?;
/// assert_eq!(gear.law, RowLaw::Box { lower: -0.125, upper: 0.125 });
/// # Ok::<(), stiction::Error>(())
/// ```
pub fn dry_friction<T: Real, const N: usize>(
    row: SVector<T, N>,
    torque: T,
    step: T,
    key: u32,
) -> Result<JointRow<T, N>, Error> {
    Ok(JointRow {
        row,
        offset: T::ZERO,
        law: within(Parameter::Torque, torque, step)?,
        compliance: T::ZERO,
        key,
    })
}

/// A motor with a position and velocity controller and a torque limit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Motor<T> {
    /// Gain `k_p >= 0` of the position (N·m/rad, N/m).
    pub stiffness: T,
    /// Gain `k_d >= 0` of the velocity (N·m·s/rad, N·s/m). Not 0 together with the other one.
    pub damping: T,
    /// Torque (N·m, N) that is added to what the gains ask for.
    pub feedforward: T,
    /// Largest torque, not negative (N·m, N).
    pub limit: T,
}

/// A motor as one row: `τ = -k_p (q + h s - q_d) - k_d (s - v_d) + τ_ff` within `± limit`, with `s = row · v` at the end of the
/// step: implicit, so that stiff gains are stable at any step, and limited exactly.
///
/// `ahead` (rad, m) is `q - q_d` at the beginning of the step, `target` (rad/s, m/s) the velocity `v_d`, `step > 0` (s).
///
/// # Errors
/// [`Error::InvalidParameter`] with what is negative or not finite, with [`Parameter::MotorGains`] if both are 0, and if the offset
/// or the compliance overflows with what makes it so large.
///
/// ```
/// # use nalgebra::vector;
/// # use stiction::{RowLaw, time_stepping::{Motor, motor}};
/// let knee = Motor { stiffness: 4.0, damping: 1.0, feedforward: 0.0, limit: 8.0 };
/// let row = motor(vector![1.0], &knee, 0.5, 0.0, 0.25, 0)?;
/// assert_eq!((row.offset, row.compliance), (1.0, 2.0));
/// assert_eq!(row.law, RowLaw::Box { lower: -2.0, upper: 2.0 });
/// # Ok::<(), stiction::Error>(())
/// ```
pub fn motor<T: Real, const N: usize>(
    row: SVector<T, N>,
    motor: &Motor<T>,
    ahead: T,
    target: T,
    step: T,
    key: u32,
) -> Result<JointRow<T, N>, Error> {
    let stiffness = Parameter::MotorStiffness.not_negative(motor.stiffness)?;
    let damping = Parameter::MotorDamping.not_negative(motor.damping)?;
    let feedforward = Parameter::Feedforward.finite(motor.feedforward)?;
    let ahead = Parameter::Ahead.finite(ahead)?;
    let target = Parameter::Target.finite(target)?;
    let law = within(Parameter::TorqueLimit, motor.limit, step)?;

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
    Ok(JointRow {
        row,
        offset,
        law,
        compliance: reciprocal(step, gain, Parameter::MotorGains)?,
        key,
    })
}

/// One row of a loop that is closed, or of a gear: `row · v + drift / h = 0`, so that what has drifted apart is put right
/// within the step, at `recovery >= 0` (m/s, rad/s) at most.
///
/// `drift` (m, rad) is what `row` is the derivative of: 0 while the loop is closed. Redundant rows do no harm. `step > 0` (s) and
/// `recovery` are as for [`super::gap`].
///
/// # Errors
/// [`Error::InvalidParameter`] as of [`super::gap`], with [`Parameter::Drift`].
///
/// ```
/// # use nalgebra::vector;
/// # use stiction::time_stepping::closed_loop;
/// let finger = closed_loop(vector![1.0, -1.0], 0.5, 0.25, 1.0, 0)?; // two fingers that mimic each other
/// assert_eq!(finger.offset, 1.0);
/// # Ok::<(), stiction::Error>(())
/// ```
pub fn closed_loop<T: Real, const N: usize>(
    row: SVector<T, N>,
    drift: T,
    step: T,
    recovery: T,
    key: u32,
) -> Result<JointRow<T, N>, Error> {
    let drift = Parameter::Drift.finite(drift)?;
    Ok(JointRow {
        row,
        offset: closing_speed(Parameter::Drift, drift, step, recovery, recovery)?,
        law: RowLaw::Equality,
        compliance: T::ZERO,
        key,
    })
}

/// Compliance of a stiffness `k > 0` (N/m) with a relaxation time `τ >= 0` (s), `R = 1 / (h (h + τ) k)` (1/kg); with the offset
/// [`compliant_gap`] a spring `k` with a damper `k τ`, implicit over the step `h > 0` (s). An infinite stiffness is rigid, `R = 0`.
///
/// # Errors
/// [`Error::InvalidParameter`] with the argument that is not as above, or so small that the compliance overflows.
///
/// ```
/// use stiction::Error;
/// use stiction::time_stepping::{Parameter, compliance};
///
/// assert_eq!(compliance(2.0, 0.25, 0.25), Ok(4.0));
/// let nothing = compliance(0.0, 0.25, 0.25);
/// assert_eq!(nothing, Err(Error::InvalidParameter { parameter: Parameter::Stiffness }));
/// ```
pub fn compliance<T: Real>(stiffness: T, relaxation: T, step: T) -> Result<T, Error> {
    let stiffness = Parameter::Stiffness.positive_or_infinite(stiffness)?;
    let duration = softened(relaxation, step)?;
    reciprocal(step * duration, stiffness, Parameter::Stiffness)
}

/// Normal offset of a contact that gives way, `w_N = gap / (h + τ)` (m/s), at most `reach >= 0`, with a relaxation time `τ >= 0`
/// (s), a step `h > 0` (s) and a gap (m) as of [`super::gap`].
///
/// # Errors
/// [`Error::InvalidParameter`] with the argument that is not as above, or with [`Parameter::Gap`] if the quotient overflows.
///
/// ```
/// # use stiction::time_stepping::compliant_gap;
/// assert_eq!(compliant_gap(-0.25, 0.25, 0.25, 3.0), Ok(-0.5));
/// ```
pub fn compliant_gap<T: Real>(gap: T, relaxation: T, step: T, reach: T) -> Result<T, Error> {
    let duration = softened(relaxation, step)?;
    closing_speed(Parameter::Gap, gap, duration, T::ONE / T::ZERO, reach)
}

/// The time `h + τ` (s) in which what is compliant closes.
fn softened<T: Real>(relaxation: T, step: T) -> Result<T, Error> {
    let relaxation = Parameter::Relaxation.not_negative(relaxation)?;
    Parameter::Relaxation.finite(Parameter::Step.positive(step)? + relaxation)
}

/// `1 / (time gain)`. The error names the step, if the time is too small by itself, or else the gain.
fn reciprocal<T: Real>(time: T, gain: T, name: Parameter) -> Result<T, Error> {
    Parameter::Step.finite(T::ONE / Parameter::Step.finite(time)?)?;
    name.finite(T::ONE / (time * gain))
}

/// A box of a torque over a step.
fn within<T: Real>(name: Parameter, torque: T, step: T) -> Result<RowLaw<T>, Error> {
    let torque = name.not_negative(torque)?;
    let upper = name.finite(Parameter::Step.positive(step)? * torque)?;
    Ok(RowLaw::Box {
        lower: -upper,
        upper,
    })
}
