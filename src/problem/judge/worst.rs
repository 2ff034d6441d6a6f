//! What is asked of a solution later: whether it is that of the scene, its worst contact, and its violations in the units of the scene.

use crate::cone::split;
use crate::error::Error;
use crate::factor::Factor;
use crate::linalg::vector::{larger, norm, unit, zeros};
use crate::linalg::zip::zip3;
use crate::real::Real;
use crate::scene::Scene;
use crate::sets::ContactSet;
use crate::sets::contact::natural_map;
use crate::solution::{RowMode, RowSolution, Settings, Solution, Violation};
use nalgebra::SVector;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize> Solution<T, N, D, C, R> {
    /// Checks that it is usable, and that it is the solution of the scene as it is.
    pub(crate) fn check<const S: usize>(
        &self,
        scene: &Scene<T, N, D, C, R, S>,
        factor: &Factor<T, N, D, C, R>,
        settings: &Settings<T>,
    ) -> Result<(), Error> {
        if !factor.is_current(scene) {
            return Err(Error::StaleFactor);
        }
        if !self.is_usable(settings.tolerance) || !self.has_numbers() {
            return Err(Error::NoSolution);
        }
        if self.data == scene.data_fingerprint(0) { Ok(()) } else { Err(Error::SceneChanged) }
    }

    /// Index of the contact with the largest error, or `None` if all are exact or nothing was solved. Pass the scene and the factor of the
    /// solve; a contact in whose place the scene has another key does not count. What has changed since counts as in [`Self::violation`].
    ///
    /// The error of a contact is the largest entry of `r_i - Π_K(r_i - alpha_i û_i)` (N·s), see [`crate::guide::error`].
    /// [`crate::Kernel::worst_contact`] needs neither.
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
    /// assert_eq!(kernel.worst_contact(), Some(0)); // nothing has pushed it yet
    /// # Ok::<(), stiction::Error>(())
    /// ```
    #[must_use]
    pub fn worst_contact<const S: usize>(
        &self,
        scene: &Scene<T, N, D, C, R, S>,
        factor: &Factor<T, N, D, C, R>,
    ) -> Option<usize> {
        let (mut largest, mut worst) = (T::ZERO, None);
        for (i, contact, found) in zip3(0..C, scene.contacts(), &self.contacts) {
            if contact.key != found.key {
                continue;
            }
            let alpha = factor.mean_effective_mass(i);
            let set = ContactSet::<T, D>::new(contact, self.model, alpha, zeros());
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

    /// The largest violations of Coulomb's law and of the laws of joint rows, in the units of the scene: what a mechanic would measure.
    /// Pass the scene and the factor of the solve. [`crate::Kernel::violation`] needs neither.
    ///
    /// It measures the velocities and impulses of the solution by the friction and the bounds that the scene has now. It sees no Jacobian or offset that has
    /// changed since: velocities are those of the solve.
    ///
    /// A contact in whose place the scene has another key counts with its closing speed alone, and such a joint row with its speed alone:
    /// also a reached limit of [`crate::Kernel::solve_with_limits`], which is not in the scene.
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
    /// assert_eq!(kernel.violation().closing_speed, 0.1);
    /// # Ok::<(), stiction::Error>(())
    /// ```
    #[must_use]
    pub fn violation<const S: usize>(
        &self,
        scene: &Scene<T, N, D, C, R, S>,
        factor: &Factor<T, N, D, C, R>,
    ) -> Violation<T> {
        let mut worst = Violation::<T>::none();
        for (i, found) in self.contacts.iter().enumerate() {
            worst.closing_speed = worst.closing_speed.max(-split(&found.velocity).0);
            let contact = scene.contacts().get(i);
            if let Some(contact) = contact.filter(|contact| contact.key == found.key) {
                let (u, r) =
                    (scene.scaled_velocity(i, found.velocity), scene.scaled_impulse(i, found.impulse));
                worst.add_contact(contact.mu, factor.mean_effective_mass(i), &u, &r);
            }
        }
        for (j, found) in self.rows.iter().enumerate() {
            worst.add_row_speed(found);
            let row = scene.rows().get(j);
            if let Some(row) = row.filter(|row| row.key == found.key) {
                worst.add_row_impulse(row.law.bounds(), factor.row_effective_mass(j), found);
            }
        }
        worst
    }
}

impl<T: Real> Violation<T> {
    /// No violation.
    const fn none() -> Self {
        Self {
            closing_speed: T::ZERO,
            opening_impulse: T::ZERO,
            outside_cone: T::ZERO,
            creep: T::ZERO,
            missing_friction: T::ZERO,
            row_speed: T::ZERO,
            row_impulse: T::ZERO,
        }
    }

    /// Takes in a contact, in scaled rows.
    fn add_contact<const D: usize>(&mut self, mu: T, alpha: T, u: &SVector<T, D>, r: &SVector<T, D>) {
        let alpha_u = u * alpha;
        let unit = unit_of(&[alpha_u, *r]);
        let (scaled_r, scaled_alpha_u) = (r * unit, alpha_u * unit);
        let ((load, friction), (opening, _)) = (split(&scaled_r), split(&scaled_alpha_u));
        let excess = norm(friction) - mu * load.max(T::ZERO);
        self.outside_cone = self.outside_cone.max(excess.max(-load) / unit);
        self.opening_impulse = self.opening_impulse.max(load.min(opening) / unit);

        // The friction that would stop the contact. Of a contact that slides it lies outside of the disk `mu r_N`.
        let stopping = scaled_r - scaled_alpha_u;
        let (size, most) = (norm(split(&stopping).1), mu * load.max(T::ZERO));
        if size > most {
            let missing = stopping * (most / size) - scaled_r;
            self.missing_friction = self.missing_friction.max(norm(split(&missing).1) / unit);
        } else {
            self.creep = self.creep.max(norm(split(u).1));
        }
    }

    /// Takes in the speed of a joint row.
    fn add_row_speed(&mut self, found: &RowSolution<T>) {
        let against = match found.mode {
            RowMode::Open | RowMode::AtLimit | RowMode::AtLower => -found.velocity,
            RowMode::AtUpper => found.velocity,
            RowMode::Holding => found.velocity.abs(),
        };
        self.row_speed = self.row_speed.max(against);
    }

    /// Takes in the impulse of a joint row.
    fn add_row_impulse(&mut self, [lower, upper]: [T; 2], alpha: T, found: &RowSolution<T>) {
        let off = match found.mode {
            RowMode::Open | RowMode::Holding => T::ZERO,
            RowMode::AtLimit => found.impulse.min(found.velocity * alpha),
            RowMode::AtLower => found.impulse - lower,
            RowMode::AtUpper => upper - found.impulse,
        };
        self.row_impulse = self.row_impulse.max(off);
    }
}

/// A unit in which the squares of these entries neither overflow nor vanish.
fn unit_of<T: Real, const D: usize>(vectors: &[SVector<T, D>]) -> T {
    let largest = vectors.iter();
    unit(largest.fold(T::ZERO, |largest, x| larger(largest, x.as_slice(), T::ONE)))
}
