//! Steps a body and says whether it stayed.

use crate::body::{Body, Kind, STEP};
use nalgebra::SVector;
use stiction::time_stepping::free_impulse;
use stiction::{Error, Kernel, Real, Settings};

/// Ticks under the weight alone, before the load comes.
pub(crate) const WEIGHT_ALONE: usize = 5;

/// A body that moves by more has slid off, beside what the tolerance explains (m/s).
const SLIDES: f64 = 1e-3;

/// Multiples of the tolerance, in units of the impulses over the mass, which an error may move a body by: for good, and while it
/// still counts as quiet.
const ERRORS: [f64; 2] = [100.0, 10.0];

/// Number type and tolerance.
#[derive(Clone, Copy)]
pub(crate) struct Setting {
    pub(crate) name: &'static str,
    pub(crate) tolerance: f64,
    pub(crate) is_single: bool,
}

const fn setting(name: &'static str, tolerance: f64, is_single: bool) -> Setting {
    Setting {
        name,
        tolerance,
        is_single,
    }
}

pub(crate) const SETTINGS: [Setting; 4] = [
    setting("f32, 1e-4", 1e-4, true),
    setting("f64, 1e-4", 1e-4, false),
    setting("f64, 1e-6", 1e-6, false),
    setting("f64, 1e-9", 1e-9, false),
];

/// What became of a body.
#[derive(Clone, Default)]
pub(crate) struct Outcome {
    /// The tick at whose end it moved, and went on until it had slid off.
    pub(crate) left: Option<usize>,
    /// The largest speed while it stayed, m/s.
    pub(crate) fastest: f64,
    /// Ticks that were not solved.
    pub(crate) unsolved: usize,
    /// Work of all ticks.
    pub(crate) work: usize,
    /// Ticks.
    pub(crate) ticks: usize,
}

pub(crate) fn run(body: &Body, setting: Setting, ticks: usize, is_cold: bool) -> Outcome {
    let plan = (setting.tolerance, ticks, is_cold);
    let outcome = match (body.kind, setting.is_single) {
        (Kind::Free | Kind::Held, false) => steps::<f64, 18, 4, 12>(body, plan),
        (Kind::Free | Kind::Held, true) => steps::<f32, 18, 4, 12>(body, plan),
        (Kind::Rover, false) => steps::<f64, 10, 4, 4>(body, plan),
        (Kind::Rover, true) => steps::<f32, 10, 4, 4>(body, plan),
        (_, false) => steps::<f64, 6, 8, 0>(body, plan),
        (_, true) => steps::<f32, 6, 8, 0>(body, plan),
    };
    outcome.expect("the body is valid")
}

fn steps<T: Real, const N: usize, const C: usize, const R: usize>(
    body: &Body,
    (tolerance, ticks, is_cold): (f64, usize, bool),
) -> Result<Outcome, Error> {
    let mut kernel: Kernel<T, N, 3, C, R> = body.kernel()?;
    let mass = *kernel.scene().mass();
    let settings = Settings::new(T::literal(tolerance));
    let unit = tolerance * body.force * STEP / body.kilograms();
    let [slides, quiet] = ERRORS.map(|errors| errors * unit);
    let weight = body.weight.fixed_rows::<N>(0).into_owned();
    let loaded = weight + body.load.fixed_rows::<N>(0);
    let [weight, loaded] = [weight, loaded].map(|force| force.map(T::literal));
    let mut velocity = SVector::<T, N>::zeros();
    let mut outcome = Outcome {
        ticks: WEIGHT_ALONE + ticks,
        ..Outcome::default()
    };
    let (mut moves_since, mut has_left) = (None, false);
    for tick in 0..outcome.ticks {
        if is_cold {
            kernel.solver_mut().reset();
        }
        let force = if tick < WEIGHT_ALONE {
            &weight
        } else {
            &loaded
        };
        let push = free_impulse(&mass, &velocity, force, T::literal(STEP));
        let solution = kernel.solve(&push, &settings)?;
        outcome.unsolved += usize::from(!solution.is_solved());
        outcome.work += solution.work.total();
        velocity = solution.velocity;
        if has_left {
            continue;
        }
        let fastest = solution
            .contacts
            .iter()
            .map(|contact| double(contact.velocity.norm()));
        let whole = velocity.dot(&(mass * velocity)) / T::literal(body.kilograms());
        let speed = fastest.fold(double(whole).max(0.0).sqrt(), f64::max);
        if speed <= quiet {
            moves_since = None;
        } else {
            moves_since = moves_since.or(Some(tick));
        }
        has_left = speed > SLIDES + slides;
        if !has_left {
            outcome.fastest = outcome.fastest.max(speed);
        }
    }
    if has_left {
        outcome.left = moves_since;
    }
    Ok(outcome)
}

fn double<T: Real>(x: T) -> f64 {
    x.to_subset().unwrap_or(f64::NAN)
}
