//! The contact with the largest error, and the largest violations in the units of the scene.

use crate::cone::split;
use crate::factor::Factor;
use crate::linalg::vector::{larger, norm, unit, zeros};
use crate::linalg::zip::zip3;
use crate::real::Real;
use crate::scene::Scene;
use crate::sets::ContactSet;
use crate::sets::contact::natural_map;
use crate::solution::{RowMode, Settings, Solution, Violation};
use nalgebra::SVector;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize> Solution<T, N, D, C, R> {
    /// Index of the contact with the largest error, or `None` if all are exact. Pass the scene, factor and settings of the
    /// solve; a contact in whose place the scene has another key does not count.
    ///
    /// The error of a contact is the largest entry of `r_i - Π_K(r_i - alpha_i û_i)` (N·s), see [`crate::guide::error`].
    /// [`crate::Kernel::worst_contact`] needs the settings alone.
    ///
    /// ```
    /// # use nalgebra::{Matrix2, matrix, vector};
    /// # use stiction::{Contact, Kernel, Settings};
    /// # let mut kernel = Kernel::<f64, 2, 2, 1>::new();
    /// # let scene = kernel.scene_mut();
    /// # scene.set_mass(&(Matrix2::identity() * 2.0))?;
    /// # scene.push(&Contact { jacobian: matrix![0.0, 1.0; 1.0, 0.0], offset: vector![0.0, 0.0], mu: 0.5, key: 0 })?;
    /// let settings = Settings { budget: 0, ..Settings::new(1e-9) };
    /// kernel.solve(&vector![0.0, -0.2], &settings)?;
    /// assert_eq!(kernel.worst_contact(&settings), Some(0)); // nothing has pushed it yet
    /// # Ok::<(), stiction::Error>(())
    /// ```
    #[must_use]
    pub fn worst_contact<const S: usize>(
        &self,
        scene: &Scene<T, N, D, C, R, S>,
        factor: &Factor<T, N, D, C, R>,
        settings: &Settings<T>,
    ) -> Option<usize> {
        let (mut largest, mut worst) = (T::ZERO, None);
        for (i, contact, found) in zip3(0..C, scene.contacts(), &self.contacts) {
            if contact.key != found.key {
                continue;
            }
            let alpha = factor.mean_effective_mass(i);
            let set = ContactSet::<T, D>::new(contact, settings.model, alpha, zeros());
            let velocity = scene.scaled_velocity(i, found.velocity);
            let impulse = scene.scaled_impulse(i, found.impulse);
            if set.is_immovable_and_violated(&velocity) {
                return Some(i);
            }
            let alpha_u: SVector<T, D> = velocity * alpha;
            let unit = unit_of(&[alpha_u, impulse]);
            let residual = natural_map::contact_residual(&set, &(alpha_u * unit), &(impulse * unit));
            let size = larger(T::ZERO, residual.value.as_slice(), T::ONE / unit);
            if size > largest {
                (largest, worst) = (size, Some(i));
            }
        }
        worst
    }

    /// The largest violations of the laws of contacts and joint rows, in the units of the scene: an error that a mechanic would
    /// measure. Pass the scene of the solve, which has the cones. A contact in whose place the scene has another key counts with
    /// its closing speed alone.
    ///
    /// ```
    /// # use nalgebra::{Matrix2, matrix, vector};
    /// # use stiction::{Contact, Kernel, Settings};
    /// # let mut kernel = Kernel::<f64, 2, 2, 1>::new();
    /// # let scene = kernel.scene_mut();
    /// # scene.set_mass(&(Matrix2::identity() * 2.0))?;
    /// # scene.push(&Contact { jacobian: matrix![0.0, 1.0; 1.0, 0.0], offset: vector![0.0, 0.0], mu: 0.5, key: 0 })?;
    /// let settings = Settings { budget: 0, ..Settings::new(1e-9) };
    /// kernel.solve(&vector![0.0, -0.2], &settings)?;
    /// // Nothing has pushed it yet: it falls through the floor.
    /// assert_eq!(kernel.solution().violation(kernel.scene()).closing_speed, 0.1);
    /// # Ok::<(), stiction::Error>(())
    /// ```
    #[must_use]
    pub fn violation<const S: usize>(&self, scene: &Scene<T, N, D, C, R, S>) -> Violation<T> {
        let mut worst = Violation { closing_speed: T::ZERO, outside_cone: T::ZERO, row_speed: T::ZERO };
        for row in &self.rows {
            let against = match row.mode {
                RowMode::Open | RowMode::AtLimit | RowMode::AtLower => -row.velocity,
                RowMode::AtUpper => row.velocity,
                RowMode::Holding => row.velocity.abs(),
            };
            worst.row_speed = worst.row_speed.max(against);
        }
        for (i, found) in self.contacts.iter().enumerate() {
            let (normal, _) = split(&found.velocity);
            worst.closing_speed = worst.closing_speed.max(-normal);
            let contact = scene.contacts().get(i);
            let Some(contact) = contact.filter(|contact| contact.key == found.key) else {
                continue;
            };
            let impulse = scene.scaled_impulse(i, found.impulse);
            let unit = unit_of(&[impulse]);
            let (normal, _) = split(&impulse);
            let excess = norm(split(&(impulse * unit)).1) / unit - contact.mu * normal.max(T::ZERO);
            worst.outside_cone = worst.outside_cone.max(excess).max(-normal);
        }
        worst
    }
}

/// A unit in which the squares of these entries neither overflow nor vanish.
fn unit_of<T: Real, const D: usize>(vectors: &[SVector<T, D>]) -> T {
    let largest = vectors.iter();
    unit(largest.fold(T::ZERO, |largest, x| larger(largest, x.as_slice(), T::ONE)))
}
