//! The judge: computes the velocity, contacts, joint rows and error of a solution from its impulses.

use crate::linalg::blocks::diagonal_of;
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::{add, at_least};
use crate::linalg::zip::{zip3, zip4, zip5};
use crate::problem::{Age, Problem};
use crate::real::Real;
use crate::scene::Scaling;
use crate::sets::contact::natural_map;
use crate::solution::{ContactSolution, RowSolution, Solution};
use dynamics::Dynamics;
use rounding::Rounding;

mod balance;
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
    /// Writes velocity, contacts, joint rows and error of the impulses `r` into a solution. The error includes a bound on rounding.
    ///
    /// Momenta are summed only where the bound on their rounding is not small beside the tolerance, or if `exactly` is set. Then sums are
    /// computed with twice the digits if the error exceeds the tolerance.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn evaluate(
        &self,
        r: &Stacked<T, D, C, R>,
        (tolerance, exactly): (T, bool),
        solution: &mut Solution<T, N, D, C, R>,
    ) {
        let [v] = &mut solution.velocity.data.0;
        if self.scene.is_mixed() {
            let impulses = self.impulses(r);
            self.factor.velocity(&self.whitened, &impulses.judged, v);
            let impulses = [&impulses.written, &impulses.judged];
            self.judge(impulses, (tolerance, exactly), solution);
        } else {
            self.factor.velocity(&self.whitened, r, v);
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
        let [v] = &solution.velocity.data.0;
        let (mut u, mut rounding) = (unset(), Rounding::unset());
        let balance = if exactly { None } else { self.momentum_balance(v, judged, tolerance) };
        let balance =
            balance.filter(|_| self.factor_age == Age::New || self.is_confirmed(v, written, tolerance));
        if let Some(balance) = &balance {
            [rounding.momentum, rounding.weighted] = balance.momentum;
            // Single precision has too few digits for bounds without sums.
            if T::EPSILON < T::literal(1e-10) && !self.scene.is_mixed() {
                self.scene.contact_velocities(v, &mut u);
                self.crude_velocity_rounding(balance.moved, &mut rounding.velocities);
                solution.error = self.error(&balance.dynamics, &u, judged, &rounding);
                if solution.error <= tolerance {
                    self.write(written, judged, &u, tolerance, solution);
                    return;
                }
            }
        }
        self.fill_velocities(v, written, &mut u, &mut rounding);
        let mut dynamics =
            balance.map_or_else(|| self.sum_momenta(v, written, &mut rounding), |balance| balance.dynamics);
        solution.error = self.error(&dynamics, &u, judged, &rounding);
        if exactly && solution.error > tolerance {
            self.sum_exactly(v, written, (&mut u, &mut dynamics), &mut rounding);
            solution.error = self.error(&dynamics, &u, judged, &rounding);
        }
        self.write(written, judged, &u, tolerance, solution);
    }

    /// The dynamics by sums of momenta. Fills the bounds on their rounding.
    #[inline] // a call would take 90 bytes more stack of a chip
    fn sum_momenta(
        &self,
        v: &[T; N],
        written: &Stacked<T, D, C, R>,
        rounding: &mut Rounding<T, C, R>,
    ) -> Dynamics<T> {
        let [free] = &self.free_impulse.data.0;
        let mut dynamics = self.scene.dynamics(free, v, written);
        self.set_least_sizes(&mut dynamics);
        self.momentum_rounding(&mut dynamics, rounding);
        dynamics
    }

    /// Fills `u` with velocities, compliance included, and the bounds on their rounding.
    #[cfg_attr(target_os = "none", inline(never))]
    fn fill_velocities(
        &self,
        v: &[T; N],
        written: &Stacked<T, D, C, R>,
        u: &mut Stacked<T, D, C, R>,
        rounding: &mut Rounding<T, C, R>,
    ) {
        let mut sizes = unset();
        self.scene.velocities_and_sizes(v, u, &mut sizes);
        self.velocity_rounding(written, &sizes, &mut rounding.velocities);
        self.add_compliance(written, u);
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
    #[cfg_attr(target_os = "none", inline(never))]
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
    fn error(
        &self,
        dynamics: &Dynamics<T>,
        u: &Stacked<T, D, C, R>,
        r: &Stacked<T, D, C, R>,
        rounding: &Rounding<T, C, R>,
    ) -> T {
        let uncertainty = self.factor.uncertainty();
        if self.is_immovable_and_violated || self.loses_digits() || self.factor.is_uncertain() {
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
        error = error.max(rounding.momentum_error(dynamics));
        if error > T::ZERO {
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
        solution.data = self.scene.data_fingerprint(0);
        solution.model = self.model;
        // Slower than this is not told apart from rest: what the tolerance allows, or the error if that is larger.
        let share = solution.error.max(tolerance);
        let size = self.expected_size.max(self.sets.contact_square(judged).square_root());
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

/// Rows that are still to be written. (Zeros would call `memset`.)
fn unset<T: Real, const D: usize, const C: usize, const R: usize>() -> Stacked<T, D, C, R> {
    Stacked { contacts: [[T::ONE; D]; C], rows: [T::ONE; R] }
}
