//! Impulses that are no solution, however small their error ([`crate::guide::error`], "Absurd impulses").
//!
//! An impulse of a million times the expected size makes a violation of the expected size a relative error of 1e-6. So impulses far above the
//! expected size are judged by velocities and energies, which they do not loosen.

use crate::linalg::stacked::Stacked;
use crate::linalg::vector::{at_least, square};
use crate::linalg::zip::{zip3, zip4};
use crate::problem::{DOUBTFUL_IMPULSE_RATIO, Problem};
use crate::real::Real;
use crate::scene::RowLaw;

/// Largest ratio of an impulse to what the momenta and the offsets ask of one dof: a wedge of half a degree.
const LARGEST_ADVANTAGE: f64 = 1e4;

/// Largest energy `alpha s²` of a violation `s`, as a share of what is asked for: a tenth of the velocity.
const LARGEST_SHARE: f64 = 1e-2;

/// Least energy that is asked for, as a share of that of all free velocities: less is noise.
const LEAST_SHARE: f64 = 1e-6;

/// Rounding of a velocity, relative to the velocities of all impulses.
const ROUNDING: f64 = 16.0;

/// Energies (J) of velocities `s` along rows with the effective masses `alpha`, each `alpha s²`.
struct Energies<T> {
    /// The largest of a violation.
    violated: T,
    /// The largest of a violation by the offsets alone.
    asked: T,
    /// The largest of a violation by the free velocities.
    met: T,
    /// The largest of a free velocity.
    free: T,
    /// Sum for the velocity of each impulse alone.
    pushed: T,
    /// Work of all impulses, twice.
    work: T,
}

impl<T: Real> Energies<T> {
    fn none() -> Self {
        let [violated, asked, met, free, pushed, work] = [T::ZERO; 6];
        Self { violated, asked, met, free, pushed, work }
    }

    /// Takes in the law of a row, with its velocity, offset and free velocity.
    fn take_in_law(&mut self, alpha: T, law: RowLaw<T>, [u, offset, q]: [T; 3]) {
        let energy = |violation: T| alpha * violation * violation;
        let closing = |velocity: T| match law {
            RowLaw::Limit => at_least(-velocity, T::ZERO),
            RowLaw::Equality => velocity,
            RowLaw::Box { .. } => T::ZERO,
        };
        self.violated = at_least(energy(closing(u)), self.violated);
        self.asked = at_least(energy(closing(offset)), self.asked);
        self.met = at_least(energy(closing(q)), self.met);
        self.free = at_least(energy(q), self.free);
    }

    /// Takes in the impulses of a contact or a row, with their velocities and free velocities.
    fn take_in_work(&mut self, alpha: T, [r, u, q]: [&[T]; 3]) {
        for (&r, &u, &q) in zip3(r, u, q) {
            self.work += r * (u + q);
        }
        if alpha > T::ZERO {
            self.pushed += square(r) / alpha;
        }
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Problem<'_, T, N, D, C, R, S>
{
    /// Are impulses above [`DOUBTFUL_IMPULSE_RATIO`] times the expected ones?
    pub(crate) fn is_doubtful(&self, r: &Stacked<T, D, C, R>) -> bool {
        self.exceeds(r, T::literal(DOUBTFUL_IMPULSE_RATIO))
    }

    /// Must doubtful impulses be refused, whatever their error? They are refused if
    ///
    /// - contacts or joint rows violate their laws by more than a tenth of what the offsets ask for, or without such offsets by more than the free
    ///   motion does,
    /// - the work of all impulses, seen from the walls, is positive: `Σ r · (u + q) > 0`, with the free velocities `q`, or
    /// - they throw the bodies, and exceed [`LARGEST_ADVANTAGE`] times what one dof asks for.
    #[inline(never)]
    pub(crate) fn must_refuse(&self, r: &Stacked<T, D, C, R>) -> bool {
        if !self.is_doubtful(r) {
            return false;
        }
        // Velocities after a sweep are those that each contact met.
        let mut u = Stacked::zero();
        self.velocities(r, &mut u);
        let Energies { violated, met, pushed, work, .. } = self.energies(r, &u);
        self.lets_walls_close(r, &u)
            || met > T::ZERO && violated > at_least(met, rounding(rounding(pushed)))
            || work > rounding(pushed)
            || self.throws(r, &u) && self.exceeds_carried(r)
    }

    /// Do doubtful impulses let walls close: do contacts or joint rows violate their laws by more than a tenth of what the offsets ask for? `u`
    /// are their velocities.
    #[inline(never)]
    pub(crate) fn lets_walls_close(&self, r: &Stacked<T, D, C, R>, u: &Stacked<T, D, C, R>) -> bool {
        if !self.is_doubtful(r) || !self.scene.is_conceivably_infeasible() {
            return false;
        }
        let Energies { violated, asked, free, pushed, .. } = self.energies(r, u);
        let largest = at_least(asked * T::literal(LARGEST_SHARE), rounding(rounding(pushed)));
        asked > free * T::literal(LEAST_SHARE) && violated > largest
    }

    /// The energies of impulses, with their velocities `u`.
    #[inline(never)]
    fn energies(&self, r: &Stacked<T, D, C, R>, u: &Stacked<T, D, C, R>) -> Energies<T> {
        let mut energies = Energies::none();
        let scene = self.scene;
        for (i, contact, set, (r, u)) in
            zip4(0..C, scene.contacts(), self.sets.contacts(), r.contacts.iter().zip(&u.contacts))
        {
            let offset = scene.scaled_velocity(i, contact.offset);
            let normal = |x: &[T]| x.first().copied().unwrap_or(T::ZERO);
            let normals = [u.as_slice(), offset.as_slice(), set.q.as_slice()].map(normal);
            energies.take_in_law(set.alpha, RowLaw::Limit, normals);
            energies.take_in_work(set.alpha, [r, u, set.q.as_slice()]);
        }
        for (row, set, &r, &u) in zip4(scene.rows(), self.sets.rows(), &r.rows, &u.rows) {
            energies.take_in_law(set.alpha, row.law, [u, row.offset, set.q]);
            energies.take_in_work(set.alpha, [&[r], &[u], &[set.q]]);
            // A motor that always pushes works, too.
            let least = set.project(T::ZERO);
            energies.work -= (least + least) * u;
        }
        energies
    }

    /// Are impulses of contacts above [`LARGEST_ADVANTAGE`] times the impulse that one dof asks for?
    fn exceeds_carried(&self, r: &Stacked<T, D, C, R>) -> bool {
        let bound = self.carried() * T::literal(LARGEST_ADVANTAGE);
        r.contact_square() > bound * bound
    }

    /// Do doubtful impulses throw the bodies? Then the bodies have four times the energy of the free motion and of the velocities that the
    /// offsets ask for. `u` are their velocities.
    #[inline(never)]
    pub(crate) fn throws(&self, r: &Stacked<T, D, C, R>, u: &Stacked<T, D, C, R>) -> bool {
        if !self.is_doubtful(r) {
            return false;
        }
        let free = self.factor.energy(&self.whitened);
        // `rᵀ (H v + H v_free)` more are those of the impulses, the energy of springs included.
        let [mut asked, mut gained] = [T::ZERO; 2];
        let mut take_in = |alpha: T, [r, u, q, offset]: [T; 4]| {
            asked += alpha * offset * offset;
            gained += r * (u - offset + (q - offset));
        };
        let contacts = zip3(&r.contacts, &u.contacts, self.sets.contacts());
        for (i, (r, u, set), contact) in zip3(0..C, contacts, self.scene.contacts()) {
            let offset = self.scene.scaled_velocity(i, contact.offset);
            for (&r, &u, &q, &offset) in zip4(r, u, &set.q, &offset) {
                take_in(set.alpha, [r, u, q, offset]);
            }
        }
        for (&r, &u, set, row) in zip4(&r.rows, &u.rows, self.sets.rows(), self.scene.rows()) {
            take_in(set.alpha, [r, u, set.q, row.offset]);
        }
        let energy = free + gained;
        energy > (free + asked) * T::literal(4.0) || !energy.is_finite()
    }
}

/// The rounding of an energy.
fn rounding<T: Real>(energy: T) -> T {
    energy * (T::EPSILON * T::literal(ROUNDING))
}
