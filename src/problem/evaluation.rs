//! From an impulse to a solution: velocity, contacts and error.

use crate::laws::Laws;
use crate::linalg::blocks::ContactVector;
use crate::linalg::hints::opaque;
use crate::problem::dynamics::{self, Dynamics};
use crate::problem::residual;
use crate::problem::rounding::{self, Rounding};
use crate::problem::{ContactLaw, Problem};
use crate::solution::zeros;
use crate::{ContactSolution, Factor, Real, Scene, Settings, Solution};

impl<T: Real, const N: usize, const D: usize, const C: usize, L: Laws> Problem<'_, T, N, D, C, L> {
    /// Error of a velocity and an impulse, with bounds on rounding added: of `W`, which gives the steps `alpha_i` and the
    /// sizes, of the sums, and of this evaluation.
    #[cfg_attr(target_os = "none", inline(never))]
    fn error(
        &self,
        momentum: &Dynamics<T>,
        u: &ContactVector<T, D, C>,
        r: &[[T; D]],
        rounding: &Rounding<T, C>,
    ) -> T {
        let (u, noise) = (opaque(u), opaque(&rounding.velocities));
        let natural_map = residual::natural_map(self.laws(), self.size, u, r, noise);
        let error = natural_map.max(momentum.error(rounding.momentum));
        if error > T::ZERO {
            let uncertainty = self.factor.uncertainty();
            return error * (T::ONE + uncertainty) + T::literal(4.0) * T::EPSILON;
        }
        error
    }

    /// [`Self::error`] with the finest bound on rounding.
    #[cfg_attr(target_os = "none", inline(never))]
    fn finer_error(
        &self,
        momentum: &Dynamics<T>,
        u: &ContactVector<T, D, C>,
        r: &[[T; D]],
        v: &[T; N],
    ) -> T {
        let (mass, contacts) = (&self.scene.mass().data.0, self.scene.contacts());
        let [free] = &self.free_impulse.data.0;
        let rounding = rounding::count(mass, contacts, free, v, r, momentum.unit);
        self.error(momentum, u, r, &rounding)
    }

    /// Writes velocity, contacts and error of an impulse into a solution. The error includes a bound on rounding: a cheap
    /// one, or the finest if the cheap one exceeds the tolerance.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn evaluate(
        &self,
        r: &ContactVector<T, D, C>,
        tolerance: T,
        solution: &mut Solution<T, N, D, C, L>,
    ) {
        if L::MIXED {
            self.evaluate_slots(r, solution);
            return;
        }
        let mut u = [[T::ONE; D]; C]; // all that is used is overwritten, and zeros would call memset
        let r = opaque(r.get(..self.factor.contacts()).unwrap_or_default());
        let [v] = &mut solution.velocity.data.0;
        self.factor.velocity(&self.whitened, r, v);
        let (mass, contacts) = (&self.scene.mass().data.0, self.scene.contacts());
        let [free] = &self.free_impulse.data.0;
        let momentum = dynamics::momentum(self.scene, free, v, r, &mut u);
        let rounding = rounding::bound(self.laws(), mass, contacts, v, r, &momentum);
        solution.error = self.error(&momentum, &u, r, &rounding);
        if solution.error > tolerance {
            solution.error = self.finer_error(&momentum, &u, r, v);
        }
        solution.contacts.clear();
        let sources = self.laws().iter().zip(contacts);
        for (((law, source), &r), &u) in sources.zip(r).zip(opaque(&u)) {
            let (impulse, velocity) = (r.into(), u.into());
            let contact = ContactSolution {
                key: source.key,
                impulse,
                velocity,
                mode: residual::mode(law, &velocity, &impulse),
            };
            // There is room: the scene has no more contacts than the solution.
            let _ = solution.contacts.push(contact);
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
            let residual = residual::natural_map_of(&law, &found.velocity, &found.impulse);
            let size = residual::larger(largest, residual.as_slice(), T::ONE);
            if size > largest {
                (largest, worst) = (size, Some(i));
            }
        }
        worst
    }
}
