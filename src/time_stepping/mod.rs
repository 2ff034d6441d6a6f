//! From one time step to the next: the free impulse and the offsets `w` of a scene.
//!
//! Semi-implicit stepping after Moreau and Jean: masses, Jacobians and gaps are taken at the
//! beginning of a step of length `h`, contact impulses and friction act on the velocity at its end,
//! and the position follows from that velocity.
//!
//! A helper returns an error that names the [`Parameter`] if an argument has no meaning (NaN, a step of 0, a negative stiffness). Otherwise its
//! result is finite. The scene checks the results of [`free_impulse`] and [`moving_surface`].
//!
//! ```
//! use nalgebra::{Matrix2, matrix, vector};
//! use stiction::{Contact, Kernel, Settings, time_stepping::{Gap, free_impulse}};
//!
//! // 2 kg, thrown at 1 m/s over a floor (x, height) from 1 cm above it.
//! let (mass, weight, h) = (Matrix2::identity() * 2.0, vector![0.0, -2.0 * 9.81], 0.001);
//! let mut kernel = Kernel::<f64, 2, 2, 1>::new();
//! kernel.scene_mut().set_mass(&mass)?;
//! let jacobian = matrix![0.0, 1.0; 1.0, 0.0];
//! kernel.scene_mut().push(&Contact { jacobian, offset: vector![0.0, 0.0], mu: 0.4, key: 0 })?;
//! let settings = Settings::new(1e-9);
//!
//! let (mut position, mut velocity) = (vector![0.0, 0.01], vector![1.0, 0.0]);
//! for _ in 0..1000 {
//!     // Neither the offset nor the free impulse is part of the factor, which is computed once.
//!     let gap = Gap { distance: position.y, recovery: 0.1, reach: 10.0 };
//!     kernel.scene_mut().set_offset(0, &vector![gap.offset(h)?, 0.0])?;
//!     velocity = kernel.solve(&free_impulse(&mass, &velocity, &weight, h), &settings)?.velocity;
//!     position += velocity * h;
//! }
//! assert!(velocity.norm() < 1e-9 && position.y.abs() < 1e-9); // it lies still, on the floor
//! # Ok::<(), stiction::Error>(())
//! ```

use crate::linalg::cholesky::axpy;
use crate::linalg::vector::zeros;
use crate::real::Real;
use nalgebra::{SMatrix, SVector};

mod adhesion;
mod checks;
mod friction;
mod offsets;

mod rows;

pub use crate::parameter::Parameter;
pub use adhesion::Suction;
pub use friction::StaticFriction;
pub use offsets::{Gap, Restitution, Spring, moving_surface};
pub use rows::{ClosedLoop, DryFriction, JointLimit, Motor};

/// Free impulse of a step, `M v_free = M v⁻ + h F` (`N` entries; N·s, N·m·s): the momentum without contacts.
/// It is `-f` in the note.
///
/// `v⁻` is the velocity before the step, `F` (N, N·m) the sum of all forces except those of the contacts: weight, motors, and
/// `-C(q, v⁻) v⁻` if `M` depends on the position.
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
    for (column, &v) in mass.data.0.iter().zip(velocity.iter()) {
        axpy(v, column, impulse.as_mut_slice());
    }
    axpy(step, force.as_slice(), impulse.as_mut_slice());
    impulse
}
