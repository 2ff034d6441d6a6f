//! The types that belong to a kernel: its sizes are written once.

use crate::kernel::Kernel;
use crate::real::Real;
use crate::scene::{Contact, JointRow, Scene};
use crate::solution::Solution;
use crate::solver::Phases;
use nalgebra::SVector;

/// The types of the sizes of a kernel, which a program then writes once.
///
/// ```
/// use nalgebra::{Matrix2, matrix, vector};
/// use stiction::{Contact, Error, FreeImpulseOf, Kernel, SceneOf, Settings, SolutionOf};
///
/// type Leg = Kernel<f32, 2, 2, 1>; // velocities, rows of a contact, contacts
///
/// fn fill(scene: &mut SceneOf<Leg>) -> Result<FreeImpulseOf<Leg>, Error> {
///     scene.clear();
///     scene.set_mass(&(Matrix2::identity() * 2.0))?;
///     scene.push(&Contact { jacobian: matrix![0.0, 1.0; 1.0, 0.0], offset: vector![0.0, 0.0], mu: 0.8, key: 7 })?;
///     Ok(vector![0.01, -0.04])
/// }
///
/// fn load(solution: &SolutionOf<Leg>) -> f32 {
///     solution.contacts.iter().map(|foot| foot.impulse[0]).sum()
/// }
///
/// let mut leg = Leg::new();
/// let free_impulse = fill(leg.scene_mut())?;
/// assert!((load(leg.solve(&free_impulse, &Settings::new(1e-4))?) - 0.04).abs() < 1e-4);
/// # Ok::<(), Error>(())
/// ```
pub trait Parts {
    /// Its scenes.
    type Scene;
    /// Its contacts.
    type Contact;
    /// Its joint rows and limits.
    type JointRow;
    /// Its free impulses (N·s), of the type of its velocities.
    type FreeImpulse;
    /// Its solutions.
    type Solution;
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize, P: Phases> Parts
    for Kernel<T, N, D, C, R, S, P>
{
    type Scene = Scene<T, N, D, C, R, S>;
    type Contact = Contact<T, N, D>;
    type JointRow = JointRow<T, N>;
    type FreeImpulse = SVector<T, N>;
    type Solution = Solution<T, N, D, C, R>;
}

/// The [`Scene`] of a kernel, see [`Parts`].
pub type SceneOf<K> = <K as Parts>::Scene;

/// A [`Contact`] of a kernel, see [`Parts`].
pub type ContactOf<K> = <K as Parts>::Contact;

/// A [`JointRow`] of a kernel, see [`Parts`].
pub type JointRowOf<K> = <K as Parts>::JointRow;

/// A free impulse of a kernel (N·s), or a velocity, see [`Parts`].
pub type FreeImpulseOf<K> = <K as Parts>::FreeImpulse;

/// The [`Solution`] of a kernel, see [`Parts`].
pub type SolutionOf<K> = <K as Parts>::Solution;
