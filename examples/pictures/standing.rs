//! Drops a dumped robot onto its slope and reports how it creeps: our side of `examples/peers/standing.py`.
//!
//! `M`, `H` and all forces but the joints' are those of the scene file at every step: it lands from a millimetre above
//! the slope, and its posture hardly changes. Joints are held by the same PD law as in `standing.py`. Nothing is softened: a contact closes its gap
//! within a step, and one that penetrates by rounding is pushed out.
//!
//! `cargo run --release -p pictures --bin standing FILE.json STEP SECONDS [f32]` prints a line `time x y z` (s, m: the
//! way of the body) for every tenth of a second, and last what a step takes (µs), with and without a new factor.

use nalgebra::{Const, SVector, Vector3};
use std::env::args;
use std::error::Error;
use std::time::Instant;
use stiction::time_stepping::{Gap, free_impulse};
use stiction::{Factor, Real, Scene, Settings, Solver};
use testbed::scene_file::{self, SceneFile};

/// What holds a joint (N m/rad, N m s/rad), as in `standing.py`.
const STIFFNESS: f64 = 200.0;
const DAMPING: f64 = 10.0;
/// The velocities of the body; the others are joints.
const BODY: usize = 6;
/// A penetration is pushed out at 0.1 m/s at most; nothing closes faster than 10 m/s.
const GAP: Gap<f64> = Gap { distance: 0.0, recovery: 0.1, reach: 10.0 };

fn stand<T: Real, const N: usize>(
    file: &SceneFile,
    step: f64,
    seconds: f64,
    tolerance: f64,
) -> Result<(), Box<dyn Error>> {
    let mut scene: Scene<T, N, 3, 4> = file.scene()?;
    let mass = *scene.mass();
    let jacobians: Vec<_> = scene.contacts().iter().map(|c| c.jacobian).collect();
    let gaps: Vec<_> = file.w.iter().step_by(3).map(|w| w * step).collect();
    let at_rest = file.free_impulse::<f64, N>() / step;
    let h = T::literal(step);

    let mut factor = Factor::new(&scene)?;
    let mut solver = Solver::new();
    let settings = Settings::new(T::literal(tolerance));
    // Positions are kept in f64, as far as they have moved: what is measured is the contact, not the sum.
    let mut moved = SVector::<f64, N>::zeros();
    let mut velocity = SVector::<T, N>::zeros();
    let (mut whole, mut solve) = (f64::INFINITY, f64::INFINITY);
    let chunk = scene_steps(0.1, step);
    for k in 0..scene_steps(seconds, 0.1) {
        // Every other tenth of a second keeps the factor, so that both can be timed.
        let prepares = k % 2 == 0;
        let start = Instant::now();
        for _ in 0..chunk {
            let force = SVector::from_fn(|i, _| {
                let held = STIFFNESS * moved[i] + DAMPING * double(velocity[i]);
                T::literal(at_rest[i] - if i < BODY { 0.0 } else { held })
            });
            for (i, (jacobian, gap)) in jacobians.iter().zip(&gaps).enumerate() {
                let normal = jacobian.row(0);
                let closed: f64 = normal.iter().zip(&moved).map(|(a, b)| double(*a) * b).sum();
                let distance = gap + closed;
                let offset = Gap { distance, ..GAP }.offset(step)?;
                scene.set_offset(i, &Vector3::new(T::literal(offset), T::ZERO, T::ZERO))?;
            }
            if prepares {
                factor.prepare(&scene)?;
            }
            let push = free_impulse(&mass, &velocity, &force, h);
            let solution = solver.solve(&scene, &factor, &push, &settings)?;
            if !solution.is_solved() {
                return Err(format!("{}: {}", solution.status, solution.error).into());
            }
            velocity = solution.velocity;
            moved += velocity.map(double) * step;
        }
        let time = start.elapsed().as_secs_f64() * 1e6 / f64::from(chunk);
        let best = if prepares { &mut whole } else { &mut solve };
        *best = best.min(time);
        let body = moved.generic_view((0, 0), (Const::<3>, Const::<1>));
        let way: Vec<_> = body.iter().map(|x| format!("{x:e}")).collect();
        println!("{:.1} {}", 0.1 * f64::from(k + 1), way.join(" "));
    }
    println!("{whole} {solve}");
    Ok(())
}

fn double<T: Real>(x: T) -> f64 {
    x.to_subset().unwrap_or(f64::NAN)
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a few thousand
fn scene_steps(time: f64, step: f64) -> u32 {
    (time / step).round() as u32
}

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = args().skip(1).collect();
    let [file, step, seconds, number @ ..] = &words[..] else {
        return Err("standing FILE.json STEP SECONDS [f32]".into());
    };
    let scenes = scene_file::read(file.as_ref())?;
    let file = scenes.first().ok_or("no scene")?;
    let (step, seconds) = (step.parse()?, seconds.parse()?);
    match (file.n_dof, number.is_empty()) {
        (6, true) => stand::<f64, 6>(file, step, seconds, 1e-11),
        (18, true) => stand::<f64, 18>(file, step, seconds, 1e-11),
        (6, false) => stand::<f32, 6>(file, step, seconds, 1e-4),
        (18, false) => stand::<f32, 18>(file, step, seconds, 1e-4),
        (n, _) => Err(format!("{n} velocities, not 6 or 18").into()),
    }
}
