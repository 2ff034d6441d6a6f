//! The judge: computes the velocity, contacts, joint rows and error of a solution from its impulses.

use crate::linalg::blocks::diagonal_of;
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::{add, at_least};
use crate::linalg::zip::{zip3, zip4, zip5};
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

/// The impulses of a solution.
struct Impulses<T, const D: usize, const C: usize, const R: usize> {
    /// In physical rows, as they are written into the solution.
    written: Stacked<T, D, C, R>,
    /// In scaled rows.
    judged: Stacked<T, D, C, R>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Problem<'_, T, N, D, C, R, S>
{
    /// Writes velocity, contacts, joint rows and error of the impulses `r` into a solution. The error includes a bound on rounding. If it
    /// exceeds the tolerance and `exactly` is set, its sums are computed again with twice the digits.
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
            let impulses = self.impulses(r);
            let impulses = [&impulses.written, &impulses.judged];
            self.judge(impulses, (tolerance, exactly), solution);
        } else {
            self.judge([r; 2], (tolerance, exactly), solution);
        }
    }

    /// The impulses of a mixed scene, those of joint rows within their bounds. `r` is in scaled rows.
    fn impulses(&self, r: &Stacked<T, D, C, R>) -> Impulses<T, D, C, R> {
        let mut impulses = Impulses { written: *r, judged: *r };
        let Impulses { written, judged } = &mut impulses;
        let used = 0..self.sets.contacts().len();
        for (i, written, judged) in zip3(used, &mut written.contacts, &mut judged.contacts) {
            *written = self.scene.physical_impulse(i, *written);
            *judged = self.scene.scaled_impulse(i, *written);
        }
        for (written, judged, set) in zip3(&mut written.rows, &mut judged.rows, self.sets.rows()) {
            *written = set.project(*written);
            *judged = *written;
        }
        impulses
    }

    /// Writes contacts, joint rows and error of impulses whose velocity the solution has.
    #[cfg_attr(target_os = "none", inline(never))]
    fn judge(
        &self,
        [written, judged]: [&Stacked<T, D, C, R>; 2],
        (tolerance, exactly): (T, bool),
        solution: &mut Solution<T, N, D, C, R>,
    ) {
        // Ones, since zeros would call memset; all entries in use are overwritten.
        let unset = || Stacked { contacts: [[T::ONE; D]; C], rows: [T::ONE; R] };
        let ([v], [free]) = (&solution.velocity.data.0, &self.free_impulse.data.0);
        let mut u = unset();
        if let Some(rounding) = self.crude_rounding(v, judged, tolerance) {
            let mut dynamics = self.scene.contact_dynamics(free, v, written, &mut u);
            dynamics.plain.reduce_size(rounding.momentum);
            solution.error = self.error(&dynamics, &u, judged, &rounding);
            if solution.error <= tolerance {
                self.write(written, judged, &u, tolerance, solution);
                return;
            }
        }
        let mut sizes = unset();
        let mut dynamics = self.scene.dynamics(free, v, written, &mut u, &mut sizes);
        self.add_compliance(written, &mut u);
        self.set_least_sizes(&mut dynamics);
        let mut rounding = self.rounding(written, &sizes, &mut dynamics);
        solution.error = self.error(&dynamics, &u, judged, &rounding);
        if exactly && solution.error > tolerance {
            self.refine(v, written, (&mut u, &mut dynamics), &mut rounding);
            solution.error = self.error(&dynamics, &u, judged, &rounding);
        }
        self.write(written, judged, &u, tolerance, solution);
    }

    /// Adds to `u = H v + w` the velocities of compliance.
    #[inline]
    fn add_compliance(&self, r: &Stacked<T, D, C, R>, u: &mut Stacked<T, D, C, R>) {
        for (i, u, r) in zip3(0..C, &mut u.contacts, &r.contacts) {
            if let Some(scaling) = self.scene.scaling(i) {
                add(u, &scaling.compliance_velocity(r));
            }
        }
        self.scene.add_row_compliance(&r.rows, &mut u.rows);
    }

    /// Sets the least denominators of the momentum's error, if there are joint rows or compliance.
    #[inline]
    fn set_least_sizes(&self, dynamics: &mut Dynamics<T>) {
        let scene = self.scene;
        let mut scalings = (0..scene.counts().contacts).filter_map(|i| scene.scaling(i));
        if scene.rows().is_empty() && !scalings.any(Scaling::is_compliant) {
            return;
        }
        if let Some(weighted) = &mut dynamics.weighted {
            let masses = diagonal_of(&scene.mass().data.0);
            let heaviest = masses.fold(T::ZERO, |largest, mass| at_least(mass, largest));
            weighted.set_least_size(self.energy.momentum_floor(weighted.unit));
            let plain = self.energy.momentum_floor(dynamics.plain.unit);
            dynamics.plain.set_least_size(plain * heaviest);
        }
    }

    /// Error of the solution, with bounds on the rounding of its sums, of `W` (in `alpha_i` and the denominators) and of this function.
    /// `u` are velocities in physical rows, `r` impulses in scaled rows.
    #[cfg_attr(target_os = "none", inline(never))]
    fn error(
        &self,
        dynamics: &Dynamics<T>,
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
                *u = self.scene.scaled_velocity(i, *u);
            }
            let contacts = self.contact_error(&scaled, r, &noise.contacts);
            self.energy.larger_error(contacts, &self.sets, (&scaled, r), Some(noise))
        } else {
            self.contact_error(u, r, &noise.contacts)
        };
        error = error.max(dynamics.plain.error(rounding.momentum));
        if let Some(weighted) = &dynamics.weighted {
            error = error.max(weighted.error(rounding.weighted));
        }
        if error > T::ZERO {
            let uncertainty = self.factor.uncertainty();
            return error * (T::ONE + uncertainty) + T::literal(4.0) * T::EPSILON;
        }
        error
    }

    /// Writes impulses, velocities and modes into the solution.
    fn write(
        &self,
        written: &Stacked<T, D, C, R>,
        judged: &Stacked<T, D, C, R>,
        u: &Stacked<T, D, C, R>,
        tolerance: T,
        solution: &mut Solution<T, N, D, C, R>,
    ) {
        solution.data = self.factor.fingerprint();
        solution.model = self.model;
        // Slower than this is not told apart from rest: what the tolerance allows, or the error if that is larger.
        let share = solution.error.max(tolerance);
        let size = self.expected_size.max(judged.contact_square().square_root());
        solution.contacts.clear();
        let (sets, contacts) = (self.sets.contacts(), self.scene.contacts());
        for (set, contact, &velocity, &impulse, &r) in
            zip5(sets, contacts, &u.contacts, &written.contacts, &judged.contacts)
        {
            let u = self.scene.scaled_velocity(solution.contacts.len(), velocity);
            // The scene has no more contacts than fit into the solution.
            let _ = solution.contacts.push(ContactSolution {
                key: contact.key,
                impulse: impulse.into(),
                velocity: velocity.into(),
                mode: natural_map::mode(set, (&u, &r), (share * size, self.still)),
            });
        }
        solution.rows.clear();
        let (sets, rows) = (self.sets.rows(), self.scene.rows());
        for (set, row, &velocity, &impulse) in zip4(sets, rows, &u.rows, &written.rows) {
            let _ = solution.rows.push(RowSolution {
                key: row.key,
                impulse,
                velocity,
                mode: set.mode(row, impulse, velocity),
            });
        }
    }
}
