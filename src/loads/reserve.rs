//! How near to slipping a solution is: the least share of friction, or the largest further load, with which what sticks still sticks.
//!
//! Both are the boundary of a convex question: can the springs of [`super::springs`] carry the load? What they miss, `|F|`, falls nearly linearly
//! towards that boundary, so Newton's method from the side where they cannot finds it in a few trials.

use super::Question;
use super::spring::{Bearing, ContactSpring, RowSpring};
use super::springs::Springs;
use crate::cone::FrictionCone;
use crate::error::{Error, Input};
use crate::factor::Factor;
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::norm;
use crate::linalg::zip::{zip3, zip4};
use crate::real::Real;
use crate::scene::{Scene, check_entries};
use crate::sets::RowSet;
use crate::solution::{Settings, Solution};
use nalgebra::SVector;

/// Trials at most.
const MOST_TRIALS: usize = 40;

/// A share of friction beyond which no friction helps.
const LARGEST_SHARE: f64 = 30.0;

/// Largest further load, over the present one.
const LARGEST_LOAD: f64 = 1e6;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize> Solution<T, N, D, C, R> {
    /// The least share of the friction coefficients of all contacts that stick with which the same velocity still obeys the law: 0.8 says that a
    /// fifth of the friction may go before one of them slips. It is 0 if none needs friction. Pass the scene and the factor of the solve.
    ///
    /// What slips or moves may go on with that. [`Settings::tolerance`] is the accuracy, relative; [`Settings::still`] says what sticks.
    /// The friction that one contact uses is no such warning: bodies share ([`crate::guide::loads`]).
    ///
    /// # Errors
    /// As [`crate::LeastImpulses::new`].
    pub fn slip_reserve<const S: usize>(
        &self,
        scene: &Scene<T, N, D, C, R, S>,
        factor: &Factor<T, N, D, C, R>,
        settings: &Settings<T>,
    ) -> Result<T, Error> {
        let mut springs = Springs::new(factor);
        springs.take_on(scene, self, settings, Question::Reserve)?;
        number(least_share(&mut springs, T::ONE, resolution(settings)))
    }

    /// The largest factor on a further impulse `load` (over the velocities, N·s), with which the same velocity still obeys the convex relaxation
    /// of the law: what sticks bears the load as well. It is infinite if any factor can be borne. Pass the scene and the factor of the solve.
    ///
    /// Coulomb's law may let go earlier: in the relaxation a contact may push where it would open.
    /// [`Settings::tolerance`] is the accuracy, relative.
    ///
    /// # Errors
    /// As [`crate::LeastImpulses::new`]; [`Error::NotFinite`] of the load.
    pub fn load_reserve<const S: usize>(
        &self,
        scene: &Scene<T, N, D, C, R, S>,
        factor: &Factor<T, N, D, C, R>,
        load: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<T, Error> {
        check_entries::<T, N>(scene.used(load, 1), Input::FreeImpulse)?;
        let mut springs = Springs::new(factor);
        springs.take_on(scene, self, settings, Question::Reserve)?;
        // Known impulses carry the present load alone, and say nothing of how much others miss.
        (springs.known, springs.most_missed) = (None, T::INFINITY);
        let [mut load] = load.data.0;
        factor.whiten(&mut load);
        number(largest_load(&mut springs, &load, resolution(settings)))
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Scene<T, N, D, C, R, S>
{
    /// The least share of the friction coefficients with which all bodies could stay at rest under a free impulse, if all contacts bear: above
    /// 1 they slide, and it is infinite if they tip or fall whatever the friction. Joint rows hold within their bounds. Pass the factor of
    /// the scene. Offsets play no part.
    ///
    /// # Errors
    /// [`Error::InvalidTolerance`]; [`Error::StaleFactor`]; [`Error::NotFinite`]; [`Error::NoSolution`] if numbers overflow.
    pub fn rest_reserve(
        &self,
        factor: &Factor<T, N, D, C, R>,
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<T, Error> {
        settings.check()?;
        check_entries::<T, N>(self.used(free_impulse, 1), Input::FreeImpulse)?;
        if !factor.is_current(self) {
            return Err(Error::StaleFactor);
        }
        let mut springs = Springs::new(factor);
        let mass = factor.common_effective_mass();
        for (i, spring, contact) in zip3(0..C, &mut springs.contacts, self.contacts()) {
            if factor.mean_effective_mass(i) > T::ZERO {
                *spring = ContactSpring {
                    bearing: Bearing::Cone,
                    cone: FrictionCone::new(contact.mu).unwrap_or(FrictionCone::frictionless()),
                    stiffness: mass,
                    anchor: [T::ZERO; D],
                };
            }
        }
        for (j, spring, row) in zip3(0..R, &mut springs.rows, self.rows()) {
            let set = RowSet::new(row, factor.row_effective_mass(j), T::ZERO);
            if set.is_free() {
                *spring = RowSpring { bounds: set.bounds, stiffness: set.alpha, anchor: T::ZERO };
                springs.pushes_at_rest |= spring.pushes();
            }
        }
        let [mut load] = free_impulse.data.0;
        factor.whiten(&mut load);
        springs.load = load.map(|x| -x);
        number(least_share(&mut springs, T::INFINITY, resolution(settings)))
    }
}

/// A reserve, unless numbers have overflowed.
fn number<T: Real>(reserve: T) -> Result<T, Error> {
    let is_number = reserve >= T::ZERO;
    if is_number { Ok(reserve) } else { Err(Error::NoSolution) }
}

/// Accuracy of a reserve, relative.
fn resolution<T: Real>(settings: &Settings<T>) -> T {
    settings.tolerance.max(T::EPSILON.square_root())
}

/// A trial of a value from which on the springs carry the load.
enum Trial<T> {
    /// They carry it, also down to this value.
    Holds(T),
    /// They do not; from about this value on they do.
    Fails(T),
}

/// The least share of friction with which the springs carry the load; `high` if it is known that they do with that.
fn least_share<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    springs: &mut Springs<'_, T, N, D, C, R>,
    high: T,
    resolution: T,
) -> T {
    let whole = springs.contacts;
    let trial = |share: T| {
        for (spring, whole) in springs.contacts.iter_mut().zip(&whole) {
            if spring.bearing == Bearing::Cone {
                spring.cone = FrictionCone::new(whole.cone.friction() * share).unwrap_or(whole.cone);
            }
        }
        if springs.carry(resolution) {
            return Trial::Holds(share.min(springs.largest_use(&whole)));
        }
        let missed = springs.missed();
        let mut u = Stacked::zero();
        let energy = springs.factor.contact_velocity(&missed, &mut u);
        let mut rub = T::ZERO;
        for (spring, whole, r, u) in zip4(&springs.contacts, &whole, &springs.impulses.contacts, &u.contacts)
        {
            if let (Bearing::Cone, [load, ..], [_, tangent @ ..]) =
                (&spring.bearing, r.as_slice(), u.as_slice())
            {
                rub += whole.cone.friction() * *load * norm(tangent);
            }
        }
        Trial::Fails(if rub > T::ZERO { share + energy / rub } else { T::INFINITY })
    };
    boundary([T::ZERO, high], T::literal(LARGEST_SHARE), resolution, trial)
}

/// The largest factor on a further load, whitened, with which the springs carry both.
fn largest_load<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    springs: &mut Springs<'_, T, N, D, C, R>,
    further: &[T; N],
    resolution: T,
) -> T {
    let (present, factor) = (springs.load, springs.factor);
    let (own, size) = (factor.energy(&present), factor.energy(further));
    if size <= T::ZERO {
        return T::INFINITY;
    }
    let unit = if own > T::ZERO { (own / size).square_root() } else { T::ONE };
    let mut trial = |x: T| {
        for (load, present, further) in zip3(&mut springs.load, &present, further) {
            *load = *present + *further * (unit * x);
        }
        if springs.carry(resolution) {
            return Trial::Holds(x);
        }
        let missed = springs.missed();
        let mut slope = T::ZERO;
        for (missed, further, reciprocal) in zip3(&missed, further, factor.reciprocal_pivots()) {
            slope += *missed * reciprocal * (*further * unit);
        }
        Trial::Fails(if slope < T::ZERO { x - factor.energy(&missed) / slope } else { T::ZERO })
    };
    let (mut high, mut low) = (T::ZERO, -T::literal(4.0));
    while let Trial::Holds(_) = trial(low) {
        (high, low) = (low, low * T::literal(16.0));
        if -low > T::literal(LARGEST_LOAD) {
            return T::INFINITY;
        }
    }
    -boundary([low, high], T::ZERO, resolution, trial) * unit
}

/// The least value between `low` and `high` from which on a trial holds, from above. An infinite `high` is sought up to `most`; it stays
/// infinite if no value holds.
fn boundary<T: Real>(
    [mut low, mut high]: [T; 2],
    most: T,
    resolution: T,
    mut trial: impl FnMut(T) -> Trial<T>,
) -> T {
    let half = T::literal(0.5);
    let mut value = if high.is_finite() { high } else { low };
    // Newton's guess from `low`, once that was tried.
    let mut guess = None;
    let mut width = T::INFINITY;
    for step in 0..MOST_TRIALS {
        let mut bound = None;
        let has_held = match trial(value) {
            Trial::Holds(down_to) => {
                high = down_to.max(low);
                bound = (high < value).then_some(high);
                true
            }
            Trial::Fails(next) => {
                (low, guess) = (value, Some(next));
                false
            }
        };
        let accuracy = resolution * high.abs().max(T::literal(1e-3));
        if high.is_finite() && high - low <= accuracy {
            return high;
        }
        // Where impulses say how far they hold, that may be the end of it. Newton's guess is to lie within the accuracy of both ends.
        let beside = accuracy * T::literal(0.375);
        let next = match (bound, guess) {
            (Some(bound), _) => Some(bound - beside),
            (None, Some(guess)) if has_held => Some(guess - beside),
            (None, Some(guess)) if high.is_finite() => Some(guess + beside),
            (None, Some(guess)) => {
                let farther = low.max(T::literal(0.25)) * T::literal(4.0);
                Some((guess + guess * resolution * T::literal(0.25)).min(farther))
            }
            (None, None) => None,
        };
        let stalls = step % 3 == 2 && high - low > width * half;
        if step % 3 == 2 {
            width = high - low;
        }
        value = match next {
            None => low,
            Some(_) if !high.is_finite() && low >= most => return high,
            Some(next) if !high.is_finite() || !stalls && low < next && next < high => next,
            Some(_) if guess.is_none() => low,
            Some(_) => (low + high) * half,
        };
    }
    high
}
