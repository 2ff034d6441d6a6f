//! A coin that spins and rolls on its edge, and comes to rest: torsional and rolling friction have one budget.
//!
//! Two joint rows hold it upright. Without spin it rolls `3/4 v² radius / (length g)`, where rolling resistance has spent its energy. Spun,
//! friction is busy with the spin at first, and it rolls farther.
//!
//! `cargo run --release -p pictures --bin spinning_coin [FILE.svg]`

use nalgebra::{Matrix6, SVector, vector};
use pictures::{curve, dots, panel};
use std::error::Error;
use stiction::time_stepping::ClosedLoop;
use stiction::{Contact, Kernel, Settings, Surface};
use testbed::rolling;

const GRAVITY: f64 = 9.81;
const STEP: f64 = 2e-4;
const MASS: f64 = 7.5e-3;
const RADIUS: f64 = 0.0116;
/// Rolling and torsional coefficients (m).
const ROLL: f64 = 3e-4;
const SPIN: f64 = 4e-4;
const SPEED: f64 = 0.3;

/// Speed along the edge and spin over time, and how far it has rolled, from this spin.
struct Run {
    speeds: Vec<(f64, f64)>,
    spins: Vec<(f64, f64)>,
    distance: f64,
}

fn run(spin: f64) -> Result<Run, Box<dyn Error>> {
    // Dofs along axes that turn with the coin: forward, along its axle, up; velocity and angular velocity.
    let across = 0.25 * MASS * RADIUS * RADIUS;
    let axle = 2.0 * across;
    let masses = vector![MASS, MASS, MASS, across, axle, across];
    let mut kernel = Kernel::<f64, 6, 6, 1, 2, 1>::new();
    let scene = kernel.scene_mut();
    scene.set_mass(&Matrix6::from_diagonal(&masses))?;
    let surface = Surface { spin: SPIN, roll: [ROLL; 2], ..Surface::isotropic(0.4) };
    scene.push_on(
        &Contact { jacobian: rolling::jacobian(RADIUS), offset: SVector::zeros(), mu: 0.0, key: 0 },
        &surface,
    )?;
    // It neither tips nor drifts sideways.
    for (key, dof) in [(1, 3), (2, 1)] {
        scene.push_row(&ClosedLoop::default().row(SVector::ith(dof, 1.0), STEP, key)?)?;
    }
    let mut velocity = vector![SPEED, 0.0, 0.0, 0.0, SPEED / RADIUS, spin];
    let (mut speeds, mut spins, mut distance) = (Vec::new(), Vec::new(), 0.0);
    for step in 1..=10_000 {
        let mut push = masses.component_mul(&velocity);
        push[2] -= STEP * MASS * GRAVITY;
        let solution = kernel.solve(&push, &Settings::new(1e-9))?;
        if !solution.is_solved() {
            return Err(format!("step {step}: {}", solution.status).into());
        }
        velocity = solution.velocity;
        distance += STEP * velocity[0];
        if step % 10 == 0 {
            let time = STEP * f64::from(step);
            speeds.push((time, velocity[0]));
            spins.push((time, velocity[5]));
        }
    }
    Ok(Run { speeds, spins, distance })
}

fn main() -> Result<(), Box<dyn Error>> {
    let on_paper = 0.75 * SPEED * SPEED * RADIUS / (ROLL * GRAVITY);
    let (mut speeds, mut spins) = (Vec::new(), Vec::new());
    for (spin, label) in [(0.0, "not spun"), (40.0, "40 rad/s at first"), (120.0, "120 rad/s at first")] {
        let run = run(spin)?;
        println!("{label}: rolls {:.4} m; not spun, on paper {on_paper:.4}", run.distance);
        speeds.push(curve(label, run.speeds));
        spins.push(curve(label, run.spins));
    }
    let stops = SPEED * 1.5 * RADIUS / (ROLL * GRAVITY);
    speeds.push(dots("at rest on paper, not spun", vec![(stops, 0.0)]));
    pictures::draw(
        "spinning_coin",
        &[
            panel(
                "A coin on its edge: friction that is busy with spin lets it roll",
                "time (s)",
                "speed (m/s)",
                speeds,
            ),
            panel("Its spin", "time (s)", "spin (rad/s)", spins),
        ],
    )
}
