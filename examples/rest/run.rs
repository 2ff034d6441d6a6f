//! Steps a body and says whether it stayed.

use crate::body::{Body, Kind, STEP};
use nalgebra::SVector;
use stiction::time_stepping::free_impulse;
use stiction::{Error, Kernel, Real, Settings};

/// How a body is stepped.
#[derive(Clone, Copy)]
pub(crate) struct Plan {
    /// Ticks under the weight alone, before the load comes.
    pub(crate) alone: usize,
    /// Ticks under both.
    pub(crate) loaded: usize,
    /// Is the last solution forgotten in each tick?
    pub(crate) is_cold: bool,
}

/// A body that moves by more has slid off, beside what the tolerance explains (m/s).
const SLIDES: f64 = 1e-3;

/// One that stays and moves by more in between was not left at rest.
const MOVES: f64 = 1e-5;

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
    Setting { name, tolerance, is_single }
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
    /// It stayed in the end, but moved by more than errors of the tolerance explain.
    pub(crate) has_moved: bool,
    /// Ticks that were not solved.
    pub(crate) unsolved: usize,
    /// Work of all ticks.
    pub(crate) work: usize,
    /// Ticks.
    pub(crate) ticks: usize,
}

pub(crate) fn run(body: &Body, setting: Setting, plan: Plan) -> Outcome {
    let tolerance = setting.tolerance;
    let outcome = match (body.kind, setting.is_single) {
        (Kind::Free | Kind::Held, false) => steps::<f64, 18, 4, 12>(body, tolerance, plan),
        (Kind::Free | Kind::Held, true) => steps::<f32, 18, 4, 12>(body, tolerance, plan),
        (Kind::Rover, false) => steps::<f64, 10, 4, 4>(body, tolerance, plan),
        (Kind::Rover, true) => steps::<f32, 10, 4, 4>(body, tolerance, plan),
        (_, false) => steps::<f64, 6, 8, 0>(body, tolerance, plan),
        (_, true) => steps::<f32, 6, 8, 0>(body, tolerance, plan),
    };
    outcome.expect("the body is valid")
}

fn steps<T: Real, const N: usize, const C: usize, const R: usize>(
    body: &Body,
    tolerance: f64,
    plan: Plan,
) -> Result<Outcome, Error> {
    let mut kernel: Kernel<T, N, 3, C, R> = body.kernel()?;
    let mass = *kernel.scene().mass();
    let settings = Settings::new(T::literal(tolerance));
    let unit = tolerance * body.force * STEP / body.kilograms();
    let [errors, quiet] = ERRORS.map(|errors| errors * unit);
    let weight = body.weight.fixed_rows::<N>(0).into_owned();
    let loaded = weight + body.load.fixed_rows::<N>(0);
    let [weight, loaded] = [weight, loaded].map(|force| force.map(T::literal));
    let mut velocity = SVector::<T, N>::zeros();
    let mut outcome = Outcome { ticks: plan.alone + plan.loaded, ..Outcome::default() };
    let (mut moves_since, mut has_left) = (None, false);
    for tick in 0..outcome.ticks {
        if plan.is_cold {
            kernel.solver_mut().reset();
        }
        let force = if tick < plan.alone { &weight } else { &loaded };
        let push = free_impulse(&mass, &velocity, force, T::literal(STEP));
        let solution = kernel.solve(&push, &settings)?;
        outcome.unsolved += usize::from(!solution.is_solved());
        outcome.work += solution.work.total();
        velocity = solution.velocity;
        if has_left {
            continue;
        }
        let fastest = solution.contacts.iter().map(|contact| double(contact.velocity.norm()));
        let whole = velocity.dot(&(mass * velocity)) / T::literal(body.kilograms());
        let speed = fastest.fold(double(whole).max(0.0).sqrt(), f64::max);
        if speed <= quiet {
            moves_since = None;
        } else {
            moves_since = moves_since.or(Some(tick));
        }
        has_left = speed > SLIDES + errors;
        outcome.has_moved |= speed > MOVES + errors;
    }
    if has_left {
        (outcome.left, outcome.has_moved) = (moves_since, false);
    }
    Ok(outcome)
}

pub(crate) fn double<T: Real>(x: T) -> f64 {
    x.to_subset().unwrap_or(f64::NAN)
}
