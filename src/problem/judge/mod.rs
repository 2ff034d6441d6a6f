//! The judge: from an impulse to a solution, its velocity and its error.

use crate::linalg::stacked::Stacked;
use crate::linalg::vector::at_least;
use crate::problem::Problem;
use crate::real::Real;
use crate::scene::Scaling;
use crate::sets::contact::natural_map;
use crate::solution::{ContactSolution, RowSolution, Solution};
use dynamics::Dynamics;
use rounding::Rounding;

pub(crate) mod dynamics;
pub(crate) mod rounding;
mod worst;

/// Impulses as they are written, and as they are judged: of contacts in scaled rows.
struct Impulses<T, const D: usize, const C: usize, const R: usize> {
    written: Stacked<T, D, C, R>,
    judged: Stacked<T, D, C, R>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Problem<'_, T, N, D, C, R, S>
{
    /// Writes velocity, contacts, joint rows and error of an impulse into a solution. The error includes a bound on rounding, as fine as the
    /// tolerance needs it. If it exceeds the tolerance and is wanted `exactly`, what it is made of is computed again with twice the digits.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn evaluate(
        &self,
        r: &Stacked<T, D, C, R>,
        (tolerance, exactly): (T, bool),
        solution: &mut Solution<T, N, D, C, R>,
    ) {
        let [v] = &mut solution.velocity.data.0;
        self.factor.velocity(&self.whitened, r, v);
        if self.scene.is_mixed() {
            let impulses = self.written(r);
            let impulses = [&impulses.written, &impulses.judged];
            self.judge(impulses, (tolerance, exactly), solution);
        } else {
            self.judge([r; 2], (tolerance, exactly), solution);
        }
    }

    /// Impulses as they are written, in rows that are not scaled, those of joint rows within their bounds; and what of them is
    /// judged.
    fn written(&self, r: &Stacked<T, D, C, R>) -> Impulses<T, D, C, R> {
        let mut impulses = Impulses {
            written: *r,
            judged: *r,
        };
        let contacts = impulses
            .written
            .contacts
            .iter_mut()
            .zip(&mut impulses.judged.contacts);
        for (i, (written, judged)) in contacts.enumerate().take(self.sets.contacts().len()) {
            *written = self.scene.scale(i, *written);
            *judged = self.scene.unscale(i, *written);
        }
        let rows = impulses
            .written
            .rows
            .iter_mut()
            .zip(&mut impulses.judged.rows);
        for ((written, judged), set) in rows.zip(self.sets.rows()) {
            *written = set.project(*written);
            *judged = *written;
        }
        impulses
    }

    /// Writes what impulses do, and their error.
    #[cfg_attr(target_os = "none", inline(never))]
    fn judge(
        &self,
        [written, judged]: [&Stacked<T, D, C, R>; 2],
        (tolerance, exactly): (T, bool),
        solution: &mut Solution<T, N, D, C, R>,
    ) {
        // All that is used is overwritten, and zeros would call memset.
        let unknown = || Stacked {
            contacts: [[T::ONE; D]; C],
            rows: [T::ONE; R],
        };
        let ([v], [free]) = (&solution.velocity.data.0, &self.free_impulse.data.0);
        let mut u = unknown();
        if let Some(rounding) = rounding::crude(self, v, judged, tolerance) {
            let mut momentum = dynamics::plain_momentum(self.scene, free, v, written, &mut u);
            momentum.plain.compare_with_less(rounding.momentum);
            solution.error = self.error(&momentum, &u, judged, &rounding);
            if solution.error <= tolerance {
                self.write(written, judged, &u, solution);
                return;
            }
        }
        let mut sizes = unknown();
        let mut momentum = dynamics::momentum(self.scene, free, v, written, &mut u, &mut sizes);
        self.add_compliance(written, &mut u);
        self.set_floors(&mut momentum);
        let mut rounding = rounding::bound(self, written, &sizes, &mut momentum);
        solution.error = self.error(&momentum, &u, judged, &rounding);
        if exactly && solution.error > tolerance {
            let places = (&mut u, &mut momentum);
            rounding::refine(self, v, written, places, &mut rounding);
            solution.error = self.error(&momentum, &u, judged, &rounding);
        }
        self.write(written, judged, &u, solution);
    }

    /// Adds to `u = H v + w` the velocities of compliance.
    #[inline]
    fn add_compliance(&self, r: &Stacked<T, D, C, R>, u: &mut Stacked<T, D, C, R>) {
        for (i, (u, r)) in u.contacts.iter_mut().zip(&r.contacts).enumerate() {
            if let Some(scaling) = self.scene.scaling(i) {
                for (u, added) in u.iter_mut().zip(scaling.compliance_velocity(r)) {
                    *u += added;
                }
            }
        }
        self.scene.add_row_compliance(&r.rows, &mut u.rows);
    }

    /// Sets what momenta are compared with at least where there are joint rows or compliance. (A rigid contact on a surface is
    /// judged as every other one.)
    #[inline]
    fn set_floors(&self, momentum: &mut Dynamics<T>) {
        let scene = self.scene;
        let mut scalings = (0..scene.counts().contacts).filter_map(|i| scene.scaling(i));
        if scene.rows().is_empty() && !scalings.any(Scaling::is_compliant) {
            return;
        }
        if let Some(weighted) = &mut momentum.weighted {
            let diagonal = scene.mass().data.0.iter().enumerate();
            let heaviest = diagonal.fold(T::ZERO, |largest, (k, column)| {
                column
                    .get(k)
                    .map_or(largest, |&mass| at_least(mass, largest))
            });
            weighted.compare_with(self.energy.momentum_floor(weighted.unit));
            let plain = self.energy.momentum_floor(momentum.plain.unit);
            momentum.plain.compare_with(plain * heaviest);
        }
    }

    /// Error of velocities, not scaled, and impulses, with bounds on rounding added: of `W`, which gives the steps `alpha_i` and
    /// the sizes, of the sums, and of this evaluation.
    #[cfg_attr(target_os = "none", inline(never))]
    fn error(
        &self,
        momentum: &Dynamics<T>,
        u: &Stacked<T, D, C, R>,
        r: &Stacked<T, D, C, R>,
        rounding: &Rounding<T, C, R>,
    ) -> T {
        if self.is_immovable_and_violated || self.loses_digits() {
            return T::INFINITY;
        }
        let noise = &rounding.velocities;
        let mut error = if self.scene.is_mixed() {
            let mut scaled = *u;
            for (i, u) in scaled.contacts.iter_mut().enumerate() {
                *u = self.scene.scale(i, *u);
            }
            let contacts = self.contact_error(&scaled, r, &noise.contacts);
            self.energy
                .larger_error(contacts, &self.sets, (&scaled, r), Some(noise))
        } else {
            self.contact_error(u, r, &noise.contacts)
        };
        error = error.max(momentum.plain.error(rounding.momentum));
        if let Some(weighted) = &momentum.weighted {
            error = error.max(weighted.error(rounding.weighted));
        }
        if error > T::ZERO {
            let uncertainty = self.factor.uncertainty();
            return error * (T::ONE + uncertainty) + T::literal(4.0) * T::EPSILON;
        }
        error
    }

    /// Writes down impulses, velocities and modes.
    fn write(
        &self,
        written: &Stacked<T, D, C, R>,
        judged: &Stacked<T, D, C, R>,
        u: &Stacked<T, D, C, R>,
        solution: &mut Solution<T, N, D, C, R>,
    ) {
        solution.contacts.clear();
        let sources = self.sets.contacts().iter().zip(self.scene.contacts());
        let values = u
            .contacts
            .iter()
            .zip(written.contacts.iter().zip(&judged.contacts));
        for (i, ((set, contact), (&velocity, (&impulse, &r)))) in sources.zip(values).enumerate() {
            let u = self.scene.scale(i, velocity);
            // There is room: the scene has no more contacts than the solution.
            let _ = solution.contacts.push(ContactSolution {
                key: contact.key,
                impulse: impulse.into(),
                velocity: velocity.into(),
                mode: natural_map::mode(set, &u.into(), &r.into()),
            });
        }
        solution.rows.clear();
        let sources = self.sets.rows().iter().zip(self.scene.rows());
        for ((set, row), (&velocity, &impulse)) in sources.zip(u.rows.iter().zip(&written.rows)) {
            let _ = solution.rows.push(RowSolution {
                key: row.key,
                impulse,
                velocity,
                mode: set.mode(row, impulse, velocity),
            });
        }
    }
}
