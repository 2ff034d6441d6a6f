//! The arguments of the helpers, and their requirements.

use core::fmt;

/// Argument of a helper of [`crate::time_stepping`] that an [`crate::Error::InvalidParameter`] speaks of.
///
/// Its `Display` text says what is required. All arguments have to be finite, with four exceptions: a distance to nothing, the
/// bounds `recovery` and `reach`, the stiffness of a [`crate::time_stepping::Spring`], and
/// [`crate::time_stepping::Motor::limit`].
///
/// ```
/// use stiction::Error;
/// use stiction::time_stepping::{Gap, Parameter};
///
/// let refused = Gap { distance: 0.01, ..Gap::default() }.offset(0.0);
/// assert_eq!(refused, Err(Error::InvalidParameter { parameter: Parameter::Step }));
/// assert_eq!(Parameter::Step.to_string(), "step is not a positive number that can be divided by");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Parameter {
    /// The length of the time step (s).
    Step,
    /// The distance of a contact (m).
    Gap,
    /// The distance of a joint from its stop (rad, m).
    Distance,
    /// The drift of a closed loop (rad, m).
    Drift,
    /// The largest speed at which a penetration is pushed out (m/s, rad/s).
    Recovery,
    /// The largest offset (m/s, rad/s).
    Reach,
    /// The coefficient of restitution.
    Restitution,
    /// The normal velocity before the step (m/s).
    Approach,
    /// The speed up to which nothing bounces (m/s).
    Threshold,
    /// The offset of the gap of a contact that may bounce (m/s).
    GapOffset,
    /// The torque of dry friction (N·m, N).
    Torque,
    /// [`crate::time_stepping::Motor::stiffness`] (N·m/rad, N/m).
    MotorStiffness,
    /// [`crate::time_stepping::Motor::damping`] (N·m·s/rad, N·s/m).
    MotorDamping,
    /// Both gains of a motor together: 0, or too small to divide by.
    MotorGains,
    /// [`crate::time_stepping::Motor::feedforward`] (N·m, N).
    Feedforward,
    /// [`crate::time_stepping::Motor::limit`] (N·m, N).
    TorqueLimit,
    /// The position of a motor minus its target (rad, m).
    Ahead,
    /// The target velocity of a motor (rad/s, m/s).
    Target,
    /// The stiffness of a compliant contact or row (N/m, N·m/rad).
    Stiffness,
    /// The relaxation time of a compliant contact or row (s).
    Relaxation,
    /// The force of a suction cup (N).
    Suction,
    /// The normal of a contact.
    Normal,
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Step => "step is not a positive number that can be divided by",
            Self::Gap => "gap is NaN, infinitely deep, or too large for the step",
            Self::Distance => {
                "distance of a joint from its stop is NaN, infinitely deep, or too large for the step"
            }
            Self::Drift => "drift of a loop is not finite, or too large for the step",
            Self::Recovery => "recovery is negative or NaN",
            Self::Reach => "reach is negative or NaN",
            Self::Restitution => "coefficient of restitution is not a number from 0 to 1",
            Self::Approach => "approach velocity is not finite",
            Self::Threshold => "threshold of restitution is negative or not finite",
            Self::GapOffset => "offset of the gap is not finite",
            Self::Torque => "torque of dry friction is negative, not finite or too large",
            Self::MotorStiffness => "stiffness of a motor is negative, not finite or too large",
            Self::MotorDamping => "damping of a motor is negative, not finite or too large",
            Self::MotorGains => "gains of a motor are both 0, or too small to be divided by",
            Self::Feedforward => "feedforward torque of a motor is not finite, or too large for its gains",
            Self::TorqueLimit => "torque limit of a motor is negative, not finite or too large",
            Self::Ahead => "position of a motor ahead of its target is not finite, or too large for the step",
            Self::Target => "target velocity of a motor is not finite or too large",
            Self::Stiffness => "stiffness is not positive, or too small to be divided by",
            Self::Relaxation => "relaxation time is negative, not finite or too large",
            Self::Suction => "force of suction is negative, not finite or too large",
            Self::Normal => "normal of a contact is no vector of length 1",
        })
    }
}
