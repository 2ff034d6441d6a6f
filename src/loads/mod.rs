//! What a solution bears, told by its velocity alone: the least impulses, and how near to slipping it is ([`crate::guide::loads`]).
//!
//! In a hyperstatic scene many impulses obey the law with one velocity, and a solve returns some of them. The velocity says what each contact may bear:
//! nothing where it opens, any impulse of its cone where it sticks, an impulse against its slip where it slips. Of all impulses in these convex sets
//! that carry the same momentum, [`springs`] finds those of springs of equal stiffness.

use crate::cone::FrictionCone;
use crate::error::Error;
use crate::factor::Factor;
use crate::linalg::blocks::product;
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::{norm, square};
use crate::linalg::zip::{zip3, zip5};
use crate::real::Real;
use crate::scene::{Scaling, Scene};
use crate::sets::RowSet;
use crate::solution::{ContactMode, RowMode, RowSolution, Settings, Solution};
use heapless::Vec;
use nalgebra::SVector;
use spring::{Bearing, RowSpring};
use springs::Springs;

mod free;
mod reserve;
mod spring;
mod springs;

/// The least impulses of a solution: of all that obey the law with its velocity, those of springs of equal stiffness.
///
/// Where no contact uses all its friction, they are the limit of contacts and joint rows of equal, vanishing compliance. (Springs that slip under
/// Coulomb's law share the load otherwise.) They depend on the velocity alone: not on the past, the step size or rounding. [`crate::guide::loads`]
/// says what they are good for, and what they cannot know.
///
/// ```
/// use nalgebra::{Matrix3, matrix, vector};
/// use stiction::{Contact, Kernel, Settings};
///
/// // A beam of 3 kg (x, height, angle) on three supports without friction, half a metre apart.
/// let mut kernel = Kernel::<f64, 3, 1, 3>::new();
/// let scene = kernel.scene_mut();
/// scene.set_mass(&Matrix3::from_diagonal(&vector![3.0, 3.0, 0.25]))?;
/// for (key, place) in [(0, -0.5), (1, 0.0), (2, 0.5)] {
///     scene.push(&Contact { jacobian: matrix![0.0, 1.0, place], offset: vector![0.0], mu: 0.0, key })?;
/// }
/// let settings = Settings::new(1e-9);
/// kernel.solve(&vector![0.0, -3.0, 0.0], &settings)?;
///
/// let least = kernel.least_impulses(&settings)?;
/// assert!(least.contacts.iter().all(|impulse| (impulse[0] - 1.0).abs() < 1e-6)); // a third each
/// # Ok::<(), stiction::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LeastImpulses<T: Real, const D: usize, const C: usize, const R: usize = 0> {
    /// Contact impulses (N·s; spin and roll N·m·s), normal first, in the order of the scene.
    pub contacts: Vec<SVector<T, D>, C>,
    /// Impulses of joint rows (N·s, N·m·s), in the order of the scene.
    pub rows: Vec<T, R>,
    /// How much less momentum they carry than those of the solution (dimensionless), in the norm of `M⁻¹`. It is at most the tolerance, if
    /// rounding allows that.
    pub momentum_error: T,
}

impl<T: Real, const D: usize, const C: usize, const R: usize> LeastImpulses<T, D, C, R> {
    /// The least impulses of a solution of this scene, with its factor. A contact that slips or opens slower than [`Settings::still`] counts as one that
    /// sticks. [`Settings::tolerance`] is the momentum error that is allowed, and the largest error of a solution that has not reached its own
    /// tolerance ([`Solution::is_usable`]).
    ///
    /// A contact with compliance keeps what its spring bears. If its rows differ in compliance, all count as the softest.
    ///
    /// # Errors
    /// [`Error::InvalidTolerance`]; [`Error::StaleFactor`]; [`Error::NoSolution`] if the solution is not usable at that error, or if numbers
    /// overflow; [`Error::SceneChanged`].
    pub fn new<const N: usize, const S: usize>(
        scene: &Scene<T, N, D, C, R, S>,
        factor: &Factor<T, N, D, C, R>,
        solution: &Solution<T, N, D, C, R>,
        settings: &Settings<T>,
    ) -> Result<Self, Error> {
        let mut least = Self { contacts: Vec::new(), rows: Vec::new(), momentum_error: T::ZERO };
        let mut springs = Springs::new(factor);
        springs.take_on(scene, solution, settings, Question::Share)?;
        least.momentum_error = springs.settle(settings.tolerance);
        let missed = least.momentum_error;
        // What the error of the solution puts outside of the sets is missed. (More would be another fault, and is said.)
        let allowed = settings.tolerance.max(solution.error) * T::literal(RESTORED);
        if missed > settings.tolerance && missed <= allowed {
            least.momentum_error = springs.restore();
        }
        for (i, contact, spring) in zip3(0..C, &solution.contacts, &springs.contacts) {
            let mut impulse = contact.impulse;
            if spring.bearing != Bearing::Known {
                let r = springs.impulses.contacts.get(i).copied().unwrap_or([T::ZERO; D]);
                impulse = scene.physical_impulse(i, r).into();
            }
            let _ = least.contacts.push(impulse); // as many as the solution has
        }
        for (row, spring, &r) in zip3(&solution.rows, &springs.rows, &springs.impulses.rows) {
            let _ = least.rows.push(if spring.stiffness > T::ZERO { r } else { row.impulse });
        }
        let mut numbers = least.contacts.iter().flatten().chain(&least.rows);
        if numbers.any(|number| !number.is_finite()) || !least.momentum_error.is_finite() {
            return Err(Error::NoSolution);
        }
        Ok(least)
    }
}

/// Momentum that is restored at most, over the error of the solution.
const RESTORED: f64 = 1e3;

/// Least cosine of an impulse and the direction against a slip, for which that direction counts as known: an angle of 0.8°.
const DIRECTION: f64 = 0.9999;

/// Least impulse that may know the direction of a slide, over impulses that are noise.
const KNOWS_DIRECTION: f64 = 64.0;

/// Rounding error of the momentum that impulses carry, over the epsilon of a number and the root of their energy.
const ROUNDING: f64 = 16.0;

/// Square of what springs that can carry a load miss of it in a round, over `ε` and the energy of its impulses.
const MOST_MISSED: f64 = 16.0;

/// Stiffness `k` and anchor `a` of a spring that stands for an effective mass, in series with a compliance that is given over `ε`.
fn in_series<T: Real, const K: usize>(mass: T, compliance: T, r: [T; K]) -> (T, [T; K]) {
    (mass / (T::ONE + compliance * mass), r.map(|r| r * compliance))
}

/// What is asked of springs.
#[derive(Clone, Copy, PartialEq)]
enum Question {
    /// To carry what the impulses of the solution carry; where there is compliance, as it says.
    Share,
    /// Whether they could carry it, rigid. What is outside of a set by an error does not count.
    Reserve,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize> Springs<'_, T, N, D, C, R> {
    /// Takes on the contacts and joint rows of a solution, loaded with the momentum that its own impulses carry.
    #[cfg_attr(target_os = "none", inline(never))]
    fn take_on<const S: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, R, S>,
        solution: &Solution<T, N, D, C, R>,
        settings: &Settings<T>,
        question: Question,
    ) -> Result<(), Error> {
        let factor = self.factor;
        settings.check()?;
        solution.check(scene, factor, settings)?;
        let over_softness = match question {
            Question::Share => T::ONE / self.softness,
            Question::Reserve => T::ZERO,
        };
        let noise = Noise::of(factor, solution, settings);
        let mass = factor.common_effective_mass();
        let weight = if mass > T::ZERO { T::ONE / mass } else { T::ZERO };
        let (mut raw, mut energy) = (Stacked::zero(), T::ZERO);
        let contacts =
            zip5(0..C, &mut self.contacts, scene.contacts(), &solution.contacts, &mut raw.contacts);
        for (i, spring, contact, found, raw) in contacts {
            let r: [T; D] = scene.scaled_impulse(i, found.impulse.into());
            let u: [T; D] = scene.scaled_velocity(i, found.velocity.into());
            let compliance = scene.scaling(i).map_or(T::ZERO, Scaling::largest_compliance);
            spring.bearing = noise.bearing((factor.mean_effective_mass(i), contact.mu), (&u, &r), found.mode);
            spring.cone = FrictionCone::new(contact.mu).unwrap_or(FrictionCone::frictionless());
            (spring.stiffness, spring.anchor) = in_series(mass, compliance * over_softness, r);
            self.pushes_at_rest |= compliance * over_softness > T::ZERO;
            if spring.bearing != Bearing::Known {
                *raw = if question == Question::Share { r } else { spring.project(r) };
            }
            energy += square(raw) * weight;
        }
        let rows = zip5(0..R, &mut self.rows, scene.rows(), &solution.rows, &mut raw.rows);
        for (j, spring, row, found, raw) in rows {
            let set = RowSet::new(row, factor.row_effective_mass(j), T::ZERO);
            if set.is_free() && noise.holds(set.alpha, found) {
                let compliance = row.compliance * over_softness;
                let (stiffness, [anchor]) = in_series(set.alpha, compliance, [found.impulse]);
                *spring = RowSpring { bounds: set.bounds, stiffness, anchor };
                self.pushes_at_rest |= spring.pushes();
                *raw = found.impulse;
            }
            energy += *raw * *raw * factor.delassus().row_inverse_mass(j);
        }
        let rounding = T::EPSILON * T::literal(ROUNDING);
        self.noise = rounding * rounding * energy;
        self.most_missed = self.softness * energy * T::literal(MOST_MISSED);
        factor.add_whitened(&raw, &mut self.load);
        self.known = Some(raw);
        Ok(())
    }
}

/// Motions that are noise: no larger than the error of the solution allows.
struct Noise<T> {
    /// Largest impulse (N·s) that would stop such a motion of a contact.
    impulse: T,
    /// Its root energy, for any contact or joint row.
    energy: T,
    /// [`Settings::still`]
    still: T,
}

impl<T: Real> Noise<T> {
    fn of<const N: usize, const D: usize, const C: usize, const R: usize>(
        factor: &Factor<T, N, D, C, R>,
        solution: &Solution<T, N, D, C, R>,
        settings: &Settings<T>,
    ) -> Self {
        let (mut impulse, mut energy) = (T::ZERO, T::ZERO);
        for (i, contact) in solution.contacts.iter().enumerate() {
            let alpha = factor.mean_effective_mass(i);
            if alpha > T::ZERO {
                let r = square(contact.impulse.as_slice());
                impulse += r;
                energy += r / alpha;
            }
        }
        for (j, row) in solution.rows.iter().enumerate() {
            energy += row.impulse * row.impulse * factor.delassus().row_inverse_mass(j);
        }
        let share = solution.error.max(settings.tolerance);
        let [impulse, energy] = [impulse, energy].map(|x| x.square_root() * share);
        Self { impulse, energy, still: settings.still }
    }

    /// Is a speed along a contact or joint row of effective mass `alpha` mere noise?
    fn hides(&self, alpha: T, speed: T) -> bool {
        alpha * speed <= self.impulse.max(self.energy * alpha.square_root())
    }

    /// What a contact may bear.
    fn bearing<const D: usize>(
        &self,
        (alpha, mu): (T, T),
        (u, r): (&[T; D], &[T; D]),
        mode: ContactMode,
    ) -> Bearing<T, D> {
        let [normal, tangent @ ..] = u.as_slice() else { return Bearing::Known };
        let opens = mode == ContactMode::Open && *normal > self.still && !self.hides(alpha, *normal);
        if alpha <= T::ZERO || opens {
            return Bearing::Known;
        }
        let speed = norm(tangent);
        let slips = match mode {
            ContactMode::Slip => true,
            ContactMode::Stick => false,
            ContactMode::Open => !self.hides(alpha, speed),
        };
        if mu > T::ZERO && !(slips && speed > self.still) {
            return Bearing::Cone;
        }
        let mut ray = u.map(|u| if speed > T::ZERO { -mu * (u / speed) } else { T::ZERO });
        if let Some(first) = ray.first_mut() {
            *first = T::ONE;
        }
        let (size, length) = (norm(&ray), norm(r));
        // Of a slide whose direction is noise the impulse knows it better, unless it is noise as well.
        let knows_better = length > self.impulse * T::literal(KNOWS_DIRECTION);
        let is_noise = knows_better && product(&ray, r) < size * length * T::literal(DIRECTION);
        Bearing::Ray(if is_noise { r.map(|r| r / length) } else { ray.map(|x| x / size) })
    }

    /// Does a joint row hold, so that any impulse within its bounds obeys its law?
    fn holds(&self, alpha: T, row: &RowSolution<T>) -> bool {
        match row.mode {
            RowMode::AtLimit | RowMode::Holding => true,
            RowMode::Open | RowMode::AtLower | RowMode::AtUpper => {
                alpha * row.velocity.abs() <= self.energy * alpha.square_root()
            }
        }
    }
}
