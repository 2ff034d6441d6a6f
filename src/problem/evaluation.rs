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
    /// The error of a velocity and an impulse, and what rounding may hide of it: in `W`, which measures
    /// steps and sizes, in the sums, and here.
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

    /// [`Self::error`] with as fine a bound on rounding as there is.
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

    /// Writes velocity, contacts and error of an impulse into a solution. The error has a bound on
    /// rounding in it, as fine as is needed to find that it is below a tolerance.
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
        for ((law, &r), &u) in self.laws().iter().zip(r).zip(opaque(&u)) {
            let (impulse, velocity) = (r.into(), u.into());
            let contact = ContactSolution {
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
    /// The contact that obeys its law least: the one with the largest entry of `r_i - Π_K(r_i - alpha_i û_i)` (N·s), the
    /// first part of [`Self::error`]. `None` if there is no contact, or none that is off.
    ///
    /// Scene, factor and settings are those of the solve.
    #[must_use]
    pub fn worst_contact(
        &self,
        scene: &Scene<T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        settings: &Settings<T>,
    ) -> Option<usize> {
        let (mut largest, mut worst) = (T::ZERO, None);
        for (i, (contact, found)) in scene.contacts().iter().zip(&self.contacts).enumerate() {
            let law = ContactLaw::<T, D>::new(contact, settings.model, factor.step(i), zeros());
            let residual = residual::natural_map_of(&law, &found.velocity, &found.impulse);
            let size = residual::larger(largest, residual.as_slice(), T::ONE);
            if size > largest {
                (largest, worst) = (size, Some(i));
            }
        }
        worst
    }
}
