//! From one time step to the next: the free impulse and the offsets `w` of a scene.
//!
//! Semi-implicit stepping after Moreau and Jean: masses, Jacobians and gaps are taken at the
//! beginning of a step of length `h`, contact impulses and friction act on the velocity at its end,
//! and the position follows from that velocity.
//!
//! A helper whose arguments have no meaning (NaN, a step of 0, a negative stiffness) returns an error that names the
//! [`Parameter`]; what it returns else is finite. [`free_impulse`] and [`moving_surface`] are sums of products, which the scene
//! checks.
//!
//! ```
//! use nalgebra::{Matrix2, matrix, vector};
//! use stiction::{Contact, Factor, Scene, Settings, Solver, time_stepping as law};
//!
//! // 2 kg, thrown at 1 m/s over a floor (x, height) from 1 cm above it.
//! let (mass, weight, h) = (Matrix2::identity() * 2.0, vector![0.0, -2.0 * 9.81], 0.001);
//! let mut scene = Scene::<f64, 2, 2, 1>::new();
//! scene.set_mass(&mass)?;
//! let jacobian = matrix![0.0, 1.0; 1.0, 0.0];
//! scene.push(&Contact { jacobian, offset: vector![0.0, 0.0], mu: 0.4, key: 0 })?;
//! let factor = Factor::new(&scene)?; // neither the free impulse nor w is part of it
//! let (mut solver, settings) = (Solver::new(), Settings::new(1e-9));
//!
//! let (mut position, mut velocity) = (vector![0.0, 0.01], vector![1.0, 0.0]);
//! for _ in 0..1000 {
//!     scene.set_offset(0, &vector![law::gap(position.y, h, 0.1, 10.0)?, 0.0])?;
//!     let push = law::free_impulse(&mass, &velocity, &weight, h);
//!     velocity = solver.solve(&scene, &factor, &push, &settings)?.velocity;
//!     position += velocity * h;
//! }
//! assert!(velocity.norm() < 1e-9 && position.y.abs() < 1e-9); // it lies still, on the floor
//! # Ok::<(), stiction::Error>(())
//! ```

use crate::linalg::cholesky::axpy;
use crate::solution::zeros;
use crate::{Error, Real};
use nalgebra::{SMatrix, SVector};

mod parameter;
mod rows;

pub use parameter::Parameter;
pub use rows::{Motor, closed_loop, compliance, compliant_gap, dry_friction, joint_limit, motor};

/// Free impulse of a step, `M v + h F` (N·s): `M v_free`, and `-f` in the note.
///
/// `v` is the velocity before the step, `F` (N) the sum of all forces except those of the contacts: weight, motors, and
/// `-C(q, v) v` if `M` depends on the position.
///
/// ```
/// # use nalgebra::{Matrix2, vector};
/// # use stiction::time_stepping::free_impulse;
/// let (mass, velocity, force) = (Matrix2::identity() * 2.0, vector![1.0, 0.0], vector![0.0, -16.0]);
/// assert_eq!(free_impulse(&mass, &velocity, &force, 0.5), vector![2.0, -8.0]);
/// ```
#[must_use]
pub fn free_impulse<T: Real, const N: usize>(
    mass: &SMatrix<T, N, N>,
    velocity: &SVector<T, N>,
    force: &SVector<T, N>,
    step: T,
) -> SVector<T, N> {
    let mut impulse: SVector<T, N> = zeros();
    for (column, &v) in mass.as_slice().chunks_exact(N).zip(velocity.iter()) {
        axpy(v, column, impulse.as_mut_slice());
    }
    axpy(step, force.as_slice(), impulse.as_mut_slice());
    impulse
}

/// Normal offset `w_N = gap / step` (m/s) of a contact: it may close within the step, and no further.
///
/// - `gap` (m): distance of the contact, negative in penetration, infinite if there is nothing near.
/// - `step > 0` (s): length `h` of the time step.
/// - `recovery >= 0` (m/s): the fastest at which a penetration is pushed out. At infinity it is out after the step.
/// - `reach >= 0` (m/s): the largest offset. Set it to the fastest closing speed to expect. Infinity does not limit it.
///
/// A contact that is open stays in the scene this way and costs no new factor. A `reach` that is much too large does not
/// loosen the error, but the interior point and the search for a proof of infeasibility take their scale from the largest
/// offsets.
///
/// # Errors
/// [`Error::InvalidParameter`] with the argument that is not as above, or with [`Parameter::Gap`] if the quotient overflows and
/// the bound on that side is infinite.
///
/// ```
/// # use stiction::time_stepping::gap;
/// let (step, recovery, reach) = (0.25, 0.1, 3.0);
/// assert_eq!(gap(0.5, step, recovery, reach), Ok(2.0));
/// assert_eq!(gap(-0.5, step, recovery, reach), Ok(-0.1));
/// assert_eq!(gap(8.0, step, recovery, reach), Ok(3.0));
/// assert!(gap(f64::NAN, step, recovery, reach).is_err());
/// ```
pub fn gap<T: Real>(gap: T, step: T, recovery: T, reach: T) -> Result<T, Error> {
    closing_speed(Parameter::Gap, gap, step, recovery, reach)
}

/// The speed (m/s, rad/s) that closes a distance within a step, not below `-recovery` and not above `reach`.
fn closing_speed<T: Real>(
    name: Parameter,
    distance: T,
    step: T,
    recovery: T,
    reach: T,
) -> Result<T, Error> {
    let speed = name.distance(distance)? / Parameter::Step.positive(step)?;
    let (least, most) = (
        -Parameter::Recovery.bound(recovery)?,
        Parameter::Reach.bound(reach)?,
    );
    // Not `min` and `max`, whose zero may have either sign.
    name.finite(if speed < least {
        least
    } else if speed > most {
        most
    } else {
        speed
    })
}

/// Normal offset of a contact that bounces (m/s): Newton's `w_N = e u_N⁻`, or `gap_offset` if it does not bounce now.
///
/// It is `e approach` if the contact closes within this step (`gap_offset + approach <= 0`) and approaches faster than
/// `threshold`; else `gap_offset`. Where both ask for a separation it is the faster one.
///
/// - `e`: coefficient of restitution, 0 to 1.
/// - `approach` (m/s): normal velocity `u_N⁻` before the step, negative in approach.
/// - `threshold >= 0` (m/s): lets a contact come to rest; it should exceed `h` times the acceleration that presses it.
/// - `gap_offset` (m/s): what [`gap`] gave.
///
/// # Errors
/// [`Error::InvalidParameter`] with the argument that is not as above, or not finite.
///
/// ```
/// # use stiction::time_stepping::{gap, restitution};
/// assert_eq!(restitution(0.5, -3.0, 0.25, 0.0)?, -1.5); // leaves at half its speed
/// assert_eq!(restitution(0.5, -0.125, 0.25, 0.0)?, 0.0); // too slow to bounce
/// assert_eq!(restitution(0.5, -3.0, 0.25, gap(1.0, 0.25, 0.0, 9.0)?)?, 4.0); // not there yet
/// # Ok::<(), stiction::Error>(())
/// ```
pub fn restitution<T: Real>(e: T, approach: T, threshold: T, gap_offset: T) -> Result<T, Error> {
    let approach = Parameter::Approach.finite(approach)?;
    let bounce = Parameter::Restitution.share(e)? * approach;
    let threshold = Parameter::Threshold.not_negative(threshold)?;
    let gap_offset = Parameter::GapOffset.finite(gap_offset)?;
    let closes = approach < -threshold && gap_offset + approach <= T::ZERO;
    Ok(if closes && bounce < T::ZERO {
        bounce.min(gap_offset)
    } else {
        gap_offset
    })
}

/// Offset of a contact with a moving surface, `w = -R v_s` (m/s); add it to the other offsets.
///
/// The rows of `R` are the contact's normal and tangents in the coordinates of the surface's
/// velocity `v_s` at the contact. With `R = H_i`, `v_s` is a velocity of the whole system.
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
    for (column, &v) in frame.as_slice().chunks_exact(D).zip(velocity.iter()) {
        axpy(-v, column, offset.as_mut_slice());
    }
    offset
}
