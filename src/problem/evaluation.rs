//! From an impulse to a solution: velocity, contacts and error.

use crate::laws::{Laws, Room};
use crate::linalg::blocks::ContactVector;
use crate::linalg::hints::opaque;
use crate::problem::dynamics::{self, Dynamics};
use crate::problem::residual;
use crate::problem::rounding::{self, Rounding};
use crate::problem::{ContactLaw, Problem, slots};
use crate::solution::zeros;
use crate::{ContactSolution, Factor, Real, Scene, Settings, Solution};
use nalgebra::SVector;

impl<T: Real, const N: usize, const D: usize, const C: usize, L: Laws> Problem<'_, T, N, D, C, L> {
    /// Error of velocities and impulses, of contacts in scaled rows, of joint rows as they stand, with bounds on rounding added:
    /// of `W`, which gives the steps `alpha_i` and the sizes, of the sums, and of this evaluation.
    #[cfg_attr(target_os = "none", inline(never))]
    fn error(
        &self,
        momentum: &Dynamics<T, L>,
        u: &[[T; D]],
        r: &[[T; D]],
        rounding: &Rounding<T, C, L>,
    ) -> T {
        let (u, noise) = (opaque(u), opaque(&rounding.velocities));
        let mut natural_map = residual::natural_map(self.laws(), self.size, u, r, noise);
        if let Some(energies) = self.energies.get() {
            let given = |i| self.given(i);
            natural_map = energies.larger(natural_map, self.laws(), (u, r), noise, given);
        }
        if self.is_hopeless {
            return T::ONE / T::ZERO;
        }
        let mut error = natural_map.max(momentum.plain.error(rounding.momentum));
        if let (Some(weighted), Some(&noise)) = (momentum.weighted.get(), rounding.weighted.get()) {
            error = error.max(weighted.error(noise));
        }
        if error > T::ZERO {
            let uncertainty = self.factor.uncertainty();
            return error * (T::ONE + uncertainty) + T::literal(4.0) * T::EPSILON;
        }
        error
    }

    /// Writes velocity, contacts and error of an impulse into a solution. The error includes a bound on rounding. If it exceeds
    /// the tolerance, what it is made of is computed again with twice the digits.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn evaluate(
        &self,
        r: &ContactVector<T, D, C>,
        tolerance: T,
        solution: &mut Solution<T, N, D, C, L>,
    ) {
        let mut u = [[T::ONE; D]; C]; // all that is used is overwritten, and zeros would call memset
        let r = opaque(r.get(..self.factor.contacts()).unwrap_or_default());
        let [v] = &mut solution.velocity.data.0;
        self.factor.velocity(&self.whitened, r, v);
        let [free] = &self.free_impulse.data.0;
        // Of contacts alone both are `r`.
        let written = self.written(r);
        let [impulses, judged] = match written.get() {
            Some(both) => both
                .each_ref()
                .map(|all| all.get(..r.len()).unwrap_or_default()),
            None => [r; 2],
        };
        let mut momentum = dynamics::momentum(self.scene, free, v, impulses, &mut u);
        let mut scaled = self.give_way(impulses, &mut u, &mut momentum);
        let rounding = rounding::bound(self, v, r, &momentum);
        solution.error = self.error(&momentum, scaled.get().unwrap_or(&u), judged, &rounding);
        if solution.error > tolerance {
            let places = (&mut u[..], &mut momentum);
            let rounding = rounding::refine(self, v, [r, impulses], places, &rounding);
            scaled = self.give_way(impulses, &mut u, &mut momentum);
            solution.error = self.error(&momentum, scaled.get().unwrap_or(&u), judged, &rounding);
        }
        let scaled = scaled.get().unwrap_or(&u);
        solution.contacts.clear();
        let laws = self.laws().iter().zip(self.scene.contacts()).enumerate();
        let places = r.iter().zip(scaled).zip(impulses.iter().zip(opaque(&u)));
        for ((i, (law, source)), ((&r, &scaled), (&impulse, &velocity))) in laws.zip(places) {
            let (r, scaled) = (r.into(), SVector::from(scaled));
            let contact = ContactSolution {
                key: source.key,
                impulse: impulse.into(),
                velocity: velocity.into(),
                mode: residual::mode(law, &scaled, &r),
            };
            // There is room: the scene has no more contacts than the solution.
            let _ = solution.contacts.push(contact);
            if L::MIXED
                && let Some(place) = solution.rows.get_mut(i)
            {
                let slot = self.scene.slot(i);
                let scaled = self.factor.scaled(i, velocity.into());
                *place = slots::rows_of((law, slot), &(scaled, r), place.get());
            }
        }
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Solution<T, N, D, C> {
    /// Index of the contact with the largest error, or `None` if all are exact. Pass the scene, factor and settings of the
    /// solve.
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
    pub fn worst_contact(
        &self,
        scene: &Scene<T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        settings: &Settings<T>,
    ) -> Option<usize> {
        let (mut largest, mut worst) = (T::ZERO, None);
        for (i, (contact, found)) in scene.contacts().iter().zip(&self.contacts).enumerate() {
            let alpha = factor.natural_map_step(i);
            let law = ContactLaw::<T, D>::new(contact, settings.model, alpha, zeros());
            if law.is_hopeless_at(&found.velocity) {
                return Some(i);
            }
            let pushed = found.velocity * alpha;
            let (residual, _) = residual::natural_map_of(&law, &pushed, &found.impulse);
            let size = residual::larger(largest, residual.as_slice(), T::ONE);
            if size > largest {
                (largest, worst) = (size, Some(i));
            }
        }
        worst
    }
}
