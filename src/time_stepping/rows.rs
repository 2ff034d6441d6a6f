//! What joint rows and compliance are made of.

use super::gap;
use crate::{JointRow, Real, RowLaw};
use nalgebra::SVector;

/// Stop of a joint `distance` (rad, m) away, `0 <= λ ⟂ row · v + distance / h >= 0`.
///
/// `row` points away from the stop: 1 at the joint with `distance = q - q_min` for the lower stop, -1 with `q_max - q` for
/// the upper one. A joint beyond its stop comes back at `recovery >= 0` (rad/s, m/s) at most; `reach` is as for [`gap`].
///
/// ```
/// # use nalgebra::vector;
/// # use stiction::time_stepping::joint_limit;
/// let (step, recovery, reach) = (0.25, 0.5, 100.0);
/// let knee = joint_limit(vector![0.0, 1.0], 0.125, step, recovery, reach, 7);
/// assert_eq!((knee.offset, knee.key), (0.5, 7)); // half a radian a second, and no faster
/// ```
#[must_use]
pub fn joint_limit<T: Real, const N: usize>(
    row: SVector<T, N>,
    distance: T,
    step: T,
    recovery: T,
    reach: T,
    key: u32,
) -> JointRow<T, N> {
    JointRow {
        row,
        offset: gap(distance, step, recovery, reach),
        law: RowLaw::Limit,
        compliance: T::ZERO,
        key,
    }
}

/// Dry friction of a joint, up to a `torque` (N·m, N): the joint stands still if that is enough, or is slowed down by it.
///
/// ```
/// # use nalgebra::vector;
/// # use stiction::{RowLaw, time_stepping::dry_friction};
/// let gear = dry_friction(vector![1.0], 0.5, 0.25, 0);
/// assert_eq!(gear.law, RowLaw::Box { lower: -0.125, upper: 0.125 });
/// ```
#[must_use]
pub fn dry_friction<T: Real, const N: usize>(
    row: SVector<T, N>,
    torque: T,
    step: T,
    key: u32,
) -> JointRow<T, N> {
    JointRow {
        row,
        offset: T::ZERO,
        law: within(torque, step),
        compliance: T::ZERO,
        key,
    }
}

/// A motor with a position and velocity controller and a torque limit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Motor<T> {
    /// Gain `k_p` of the position (N·m/rad, N/m).
    pub stiffness: T,
    /// Gain `k_d` of the velocity (N·m·s/rad, N·s/m). Not 0 together with the other one.
    pub damping: T,
    /// Torque (N·m, N) that is added to what the gains ask for.
    pub feedforward: T,
    /// Largest torque (N·m, N).
    pub limit: T,
}

/// A motor as one row: `τ = -k_p (q + h s - q_d) - k_d (s - v_d) + τ_ff` within `± limit`, with `s = row · v` at the end of the
/// step: implicit, so that stiff gains are stable at any step, and limited exactly.
///
/// `ahead` is `q - q_d` at the beginning of the step, `target` the velocity `v_d`.
///
/// ```
/// # use nalgebra::vector;
/// # use stiction::{RowLaw, time_stepping::{Motor, motor}};
/// let knee = Motor { stiffness: 4.0, damping: 1.0, feedforward: 0.0, limit: 8.0 };
/// let row = motor(vector![1.0], &knee, 0.5, 0.0, 0.25, 0);
/// assert_eq!((row.offset, row.compliance), (1.0, 2.0));
/// assert_eq!(row.law, RowLaw::Box { lower: -2.0, upper: 2.0 });
/// ```
#[must_use]
pub fn motor<T: Real, const N: usize>(
    row: SVector<T, N>,
    motor: &Motor<T>,
    ahead: T,
    target: T,
    step: T,
    key: u32,
) -> JointRow<T, N> {
    let gain = motor.damping + step * motor.stiffness;
    let wanted = motor.stiffness * ahead - motor.damping * target - motor.feedforward;
    JointRow {
        row,
        offset: wanted / gain,
        law: within(motor.limit, step),
        compliance: T::ONE / (step * gain),
        key,
    }
}

/// One row of a loop that is closed, or of a gear: `row · v + drift / h = 0`, so that what has drifted apart is put right
/// within the step, at `recovery >= 0` (m/s, rad/s) at most.
///
/// `drift` (m, rad) is what `row` is the derivative of: 0 while the loop is closed. Redundant rows do no harm.
///
/// ```
/// # use nalgebra::vector;
/// # use stiction::time_stepping::closed_loop;
/// let finger = closed_loop(vector![1.0, -1.0], 0.5, 0.25, 1.0, 0); // two fingers that mimic each other
/// assert_eq!(finger.offset, 1.0);
/// ```
#[must_use]
pub fn closed_loop<T: Real, const N: usize>(
    row: SVector<T, N>,
    drift: T,
    step: T,
    recovery: T,
    key: u32,
) -> JointRow<T, N> {
    JointRow {
        row,
        offset: gap(drift, step, recovery, recovery),
        law: RowLaw::Equality,
        compliance: T::ZERO,
        key,
    }
}

/// Compliance of a stiffness `k` (N/m) with a relaxation time `τ` (s), `R = 1 / (h (h + τ) k)` (1/kg); with the offset
/// [`compliant_gap`] a spring `k` with a damper `k τ`, implicit over the step.
///
/// ```
/// # use stiction::time_stepping::compliance;
/// assert_eq!(compliance(2.0, 0.25, 0.25), 4.0);
/// ```
#[must_use]
pub fn compliance<T: Real>(stiffness: T, relaxation: T, step: T) -> T {
    T::ONE / (step * (step + relaxation) * stiffness)
}

/// Normal offset of a contact that gives way, `w_N = gap / (h + τ)` (m/s), at most `reach` (see [`gap`]).
///
/// ```
/// # use stiction::time_stepping::compliant_gap;
/// assert_eq!(compliant_gap(-0.25, 0.25, 0.25, 3.0), -0.5);
/// ```
#[must_use]
pub fn compliant_gap<T: Real>(gap: T, relaxation: T, step: T, reach: T) -> T {
    let offset = gap / (step + relaxation);
    // `min` would take a NaN for a number.
    if offset > reach { reach } else { offset }
}

/// A box of a torque over a step. (A negative one is for the scene to refuse.)
fn within<T: Real>(torque: T, step: T) -> RowLaw<T> {
    let upper = step * torque;
    RowLaw::Box {
        lower: -upper,
        upper,
    }
}
