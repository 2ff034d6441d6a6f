//! Offsets of contacts: gaps, springs, restitution, moving surfaces.

use super::Parameter;
use crate::error::Error;
use crate::linalg::cholesky::axpy;
use crate::linalg::vector::zeros;
use crate::real::Real;
use nalgebra::{SMatrix, SVector};

/// The distance of a contact, which may close within the step, and no further.
///
/// A contact that is open stays in the scene this way and costs no new factor.
///
/// ```
/// use stiction::time_stepping::Gap;
///
/// let (step, near) = (0.25, Gap { recovery: 0.1, reach: 3.0, ..Gap::default() });
/// assert_eq!(Gap { distance: 0.5, ..near }.offset(step), Ok(2.0));
/// assert_eq!(Gap { distance: -0.5, ..near }.offset(step), Ok(-0.1));
/// assert_eq!(Gap { distance: 8.0, ..near }.offset(step), Ok(3.0));
/// assert_eq!(Gap { distance: -0.5, ..Gap::default() }.offset(step), Ok(0.0)); // nothing is thrown
/// assert!(Gap { distance: f64::NAN, ..near }.offset(step).is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Gap<T> {
    /// Distance of the contact (m), negative in penetration, infinite if nothing is near (default 0).
    pub distance: T,
    /// Largest speed at which a penetration is pushed out (m/s), not negative; with 0 (default) it stays. 0.1 m/s brings it out gently. Infinity
    /// throws the body: 1 mm is out after a step of 1 ms, at 1 m/s, and this velocity lasts.
    pub recovery: T,
    /// Largest offset (m/s), not negative, infinite by default. Set it to the largest closing speed that you expect: a far gap does not loosen
    /// the error, but the central path and the search for a proof of infeasibility take their scale from the largest offset.
    pub reach: T,
}

impl<T: Real> Default for Gap<T> {
    fn default() -> Self {
        Self { distance: T::ZERO, recovery: T::ZERO, reach: T::INFINITY }
    }
}

impl<T: Real> Gap<T> {
    /// Normal offset `w_N = distance / step` (m/s) over a `step > 0` (s), not below `-recovery` and not above `reach`.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] with the argument that is out of range, or with [`Parameter::Gap`] if the quotient overflows and the bound on
    /// that side is infinite.
    pub fn offset(&self, step: T) -> Result<T, Error> {
        closing_speed(Parameter::Gap, self, Parameter::Step.positive(step))
    }
}

/// The speed (m/s, rad/s) that closes a distance within a duration, not below `-recovery` and not above `reach`.
pub(super) fn closing_speed<T: Real>(
    name: Parameter,
    gap: &Gap<T>,
    duration: Result<T, Error>,
) -> Result<T, Error> {
    let distance = name.distance(gap.distance)?;
    let (least, most) = (-Parameter::Recovery.bound(gap.recovery)?, Parameter::Reach.bound(gap.reach)?);
    let speed = distance / duration?;
    // `min` and `max` may return a zero of either sign.
    name.finite(if speed < least {
        least
    } else if speed > most {
        most
    } else {
        speed
    })
}

/// A spring with a damper in a contact or a joint row: stiffness and relaxation time.
///
/// ```
/// use stiction::Error;
/// use stiction::time_stepping::{Gap, Parameter, Spring};
///
/// let (step, rubber) = (0.25, Spring { stiffness: 2.0, relaxation: 0.25 });
/// assert_eq!(rubber.compliance(step), Ok(4.0));
/// assert_eq!(rubber.offset(&Gap { distance: -0.25, ..Gap::default() }, step), Ok(-0.5));
///
/// let nothing = Spring { stiffness: 0.0, ..rubber }.compliance(step);
/// assert_eq!(nothing, Err(Error::InvalidParameter { parameter: Parameter::Stiffness }));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Spring<T> {
    /// Stiffness `k > 0` (N/m, N·m/rad). Infinite is rigid.
    pub stiffness: T,
    /// Relaxation time `τ >= 0` (s). The damper is `k τ`.
    pub relaxation: T,
}

impl<T: Real> Spring<T> {
    /// Compliance `R = 1 / (h (h + τ) k)` (1/kg) over a step `h > 0` (s); with [`Self::offset`] a spring `k` with a damper `k τ`,
    /// implicit over the step.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] with the argument that is out of range, or so small that the compliance overflows.
    pub fn compliance(&self, step: T) -> Result<T, Error> {
        let stiffness = Parameter::Stiffness.positive_or_infinite(self.stiffness)?;
        let duration = self.duration(step)?;
        reciprocal(step * duration, stiffness, Parameter::Stiffness)
    }

    /// Normal offset `w_N = distance / (h + τ)` (m/s) over a step `h > 0` (s), at most `reach`. `recovery` has no effect.
    ///
    /// # Errors
    /// As of [`Gap::offset`], and [`Parameter::Relaxation`].
    pub fn offset(&self, gap: &Gap<T>, step: T) -> Result<T, Error> {
        let recovery = T::INFINITY;
        closing_speed(Parameter::Gap, &Gap { recovery, ..*gap }, self.duration(step))
    }

    /// The time `h + τ` (s) in which a compliant contact closes.
    fn duration(&self, step: T) -> Result<T, Error> {
        let relaxation = Parameter::Relaxation.not_negative(self.relaxation)?;
        Parameter::Relaxation.finite(Parameter::Step.positive(step)? + relaxation)
    }
}

/// `1 / (time gain)`. The error names the step if `1 / time` overflows, and otherwise the gain.
pub(super) fn reciprocal<T: Real>(time: T, gain: T, name: Parameter) -> Result<T, Error> {
    Parameter::Step.finite(T::ONE / Parameter::Step.finite(time)?)?;
    name.finite(T::ONE / (time * gain))
}

/// A contact that bounces, by Newton's law.
///
/// **With friction this law may make energy**, as it asks for the normal velocity whatever friction does meanwhile (Kane and Levinson's double pendulum
/// leaves with 1.6 times its energy). Without friction it never does, nor does `e = 0`. So where a chain of bodies strikes with friction, compare the
/// energy before and after, and solve again with `e = 0` if it has grown.
///
/// ```
/// # use stiction::time_stepping::{Gap, Restitution};
/// let ball = Restitution { coefficient: 0.5, threshold: 0.25 };
/// assert_eq!(ball.offset(-3.0, 0.0)?, -1.5); // leaves at half its speed
/// assert_eq!(ball.offset(-0.125, 0.0)?, 0.0); // too slow to bounce
/// let gap = Gap { distance: 1.0, ..Gap::default() }.offset(0.25)?;
/// assert_eq!(ball.offset(-3.0, gap)?, 4.0); // not there yet
/// # Ok::<(), stiction::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Restitution<T> {
    /// Coefficient of restitution `e`, 0 to 1.
    pub coefficient: T,
    /// Largest approach speed (m/s) without a bounce, not negative. It lets a contact come to rest, and should exceed `h` times the
    /// acceleration that presses it.
    pub threshold: T,
}

impl<T: Real> Restitution<T> {
    /// Normal offset (m/s): `w_N = e u_N⁻` if the contact closes within this step (`gap_offset + approach <= 0`) and approaches
    /// faster than the threshold, else `gap_offset`. An overlap that `gap_offset` pushes out faster than the bounce keeps
    /// `gap_offset`.
    ///
    /// - `approach` (m/s): normal velocity `u_N⁻` before the step, negative in approach.
    /// - `gap_offset` (m/s): the result of [`Gap::offset`].
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] with the argument that is out of range or not finite.
    pub fn offset(&self, approach: T, gap_offset: T) -> Result<T, Error> {
        let approach = Parameter::Approach.finite(approach)?;
        let bounce = Parameter::Restitution.share(self.coefficient)? * approach;
        let threshold = Parameter::Threshold.not_negative(self.threshold)?;
        let gap_offset = Parameter::GapOffset.finite(gap_offset)?;
        let closes = approach < -threshold && gap_offset + approach <= T::ZERO;
        Ok(if closes && bounce < T::ZERO { bounce.min(gap_offset) } else { gap_offset })
    }
}

/// Offset of a contact with a moving surface, `w = -R v_s` (`D` entries, m/s). Add it to the other offsets.
///
/// `v_s` is the velocity of the surface at the contact. The rows of `R` (`D × K`) are the normal and the tangents of the contact in the
/// coordinates of `v_s`. With `R = H_i`, `v_s` is a velocity of the whole system.
///
/// ```
/// # use nalgebra::{matrix, vector};
/// # use stiction::time_stepping::moving_surface;
/// let frame = matrix![0.0, 0.0, 1.0; 1.0, 0.0, 0.0; 0.0, 1.0, 0.0]; // normal z, tangents x, y
/// let belt = vector![0.5, 0.0, 0.0];
/// assert_eq!(moving_surface(&frame, &belt), vector![0.0, -0.5, 0.0]);
/// ```
#[must_use]
pub fn moving_surface<T: Real, const D: usize, const K: usize>(
    frame: &SMatrix<T, D, K>,
    velocity: &SVector<T, K>,
) -> SVector<T, D> {
    let mut offset: SVector<T, D> = zeros();
    for (column, &v) in frame.data.0.iter().zip(velocity.iter()) {
        axpy(-v, column, offset.as_mut_slice());
    }
    offset
}
