//! A ball thrown forward with backspin: it bounces, friction turns its spin, and in the end it rolls.
//!
//! Rebounds reach `e^(2k)` of the first height. While it slips friction keeps the angular momentum
//! about the point of contact, so that it rolls at `5/7 v0 - 2/7 r w0`, whatever `mu` and `e` are.
//!
//! `cargo run --release -p pictures --bin bouncing_ball [FILE.svg]`

use nalgebra::{Matrix3, matrix, vector};
use pictures::{curve, dots, panel};
use std::error::Error;
use stiction::time_stepping::{Gap, Restitution, free_impulse};
use stiction::{Contact, Factor, Scene, Settings, Solver};

const GRAVITY: f64 = 9.81;
const STEP: f64 = 1e-4;
const MASS: f64 = 0.6;
const RADIUS: f64 = 0.12;
/// It bounces where it is faster than it gets by falling for ten steps.
const BOUNCE: Restitution<f64> = Restitution { coefficient: 0.75, threshold: 10.0 * GRAVITY * STEP };
const MU: f64 = 0.15;
/// At the start: height of the lowest point (m), speed (m/s), backspin (rad/s).
const HEIGHT: f64 = 1.0;
const SPEED: f64 = 3.0;
const BACKSPIN: f64 = 40.0;
/// Its lowest point above the floor; a penetration is pushed out at 0.1 m/s at most, and nothing closes faster than 10 m/s.
const ABOVE: Gap<f64> = Gap { distance: HEIGHT, recovery: 0.1, reach: 10.0 };

fn main() -> Result<(), Box<dyn Error>> {
    // Dofs: forward, up, and the spin that turns the top backward; a solid sphere.
    let inertia = 0.4 * MASS * RADIUS * RADIUS;
    let mass = Matrix3::from_diagonal(&vector![MASS, MASS, inertia]);
    let weight = vector![0.0, -MASS * GRAVITY, 0.0];
    // The lowest point moves upward with the centre, and forward with centre and spin.
    let jacobian = matrix![0.0, 1.0, 0.0; 1.0, 0.0, RADIUS];

    let mut scene = Scene::<f64, 3, 2, 1>::new();
    scene.set_mass(&mass)?;
    scene.push(&Contact { jacobian, offset: vector![0.0, 0.0], mu: MU, key: 0 })?;
    let factor = Factor::new(&scene)?;
    let mut solver = Solver::new();
    let settings = Settings::new(1e-9);

    let (mut x, mut gap) = (0.0, ABOVE);
    let mut velocity = vector![SPEED, 0.0, BACKSPIN];
    let (mut path, mut slip, mut forward) = (vec![(x, HEIGHT)], Vec::new(), Vec::new());
    let mut peaks = Vec::new();
    for step in 1..=30_000 {
        let approach = velocity.y;
        let offset = BOUNCE.offset(approach, gap.offset(STEP)?)?;
        scene.set_offset(0, &vector![offset, 0.0])?;
        let push = free_impulse(&mass, &velocity, &weight, STEP);
        velocity = solver.solve(&scene, &factor, &push, &settings)?.velocity;
        x += STEP * velocity.x;
        gap.distance += STEP * velocity.y;

        if approach > 0.0 && velocity.y <= 0.0 {
            peaks.push((x, gap.distance));
        }
        let time = STEP * f64::from(step);
        if step % 20 == 0 {
            path.push((x, gap.distance));
            slip.push((time, velocity.x + RADIUS * velocity.z));
            forward.push((time, velocity.x));
        }
    }

    let rolling = 5.0 / 7.0 * SPEED - 2.0 / 7.0 * RADIUS * BACKSPIN;
    println!("rolls at {:.4} m/s; on paper {rolling:.4}", velocity.x);
    let mut expected = Vec::new();
    for (k, &(x, height)) in (1..=6).zip(&peaks) {
        let on_paper = HEIGHT * BOUNCE.coefficient.powi(2 * k);
        println!("rebound {k}: {height:.4} m; on paper {on_paper:.4}");
        expected.push((x, on_paper));
    }
    let last = STEP * 30_000.0;
    let title = "A ball with backspin, e = 0.75, mu = 0.15";
    let paths = [curve("path", path), dots("rebound on paper", expected)];
    let paper = dots("rolling, on paper", vec![(last, rolling), (last, 0.0)]);
    let speeds = [curve("of the ball", forward), curve("at its lowest point", slip), paper];
    pictures::draw(
        "bouncing_ball",
        &[
            panel(title, "distance (m)", "height of the lowest point (m)", paths),
            panel("It slips until it rolls", "time (s)", "velocity (m/s)", speeds),
        ],
    )
}
