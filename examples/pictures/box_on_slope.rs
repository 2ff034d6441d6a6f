//! A box thrown down a slope: on a flat one it comes to rest and sticks, on a steep one it slides on.
//!
//! Beside the computed speed stands the one on paper: `v = v0 + g (sin s - mu cos s) t`, until it
//! is zero.
//!
//! `cargo run --release -p pictures --bin box_on_slope [FILE.svg]`

use nalgebra::{Matrix6, SMatrix, Vector3, matrix, vector};
use pictures::{curve, dots, panel};
use std::error::Error;
use stiction::time_stepping::{Gap, free_impulse};
use stiction::{Contact, ContactMode, Factor, Scene, Settings, Solver, Status};

const GRAVITY: f64 = 9.81;
const STEP: f64 = 0.01;
const MU: f64 = 0.4;
const SPEED: f64 = 1.5;
/// A penetration is pushed out at 0.1 m/s at most; nothing closes faster than 10 m/s.
const GAP: Gap<f64> = Gap { distance: 0.0, recovery: 0.1, reach: 10.0 };

/// Velocity of the point `p` of a body along (down the slope, across, out of it); dofs are the velocity
/// of the centre and the angular velocity along the same axes.
fn point_jacobian(p: &Vector3<f64>) -> SMatrix<f64, 3, 6> {
    matrix![
        1.0, 0.0, 0.0, 0.0, p.z, -p.y;
        0.0, 1.0, 0.0, -p.z, 0.0, p.x;
        0.0, 0.0, 1.0, p.y, -p.x, 0.0
    ]
}

/// One step in the life of the box.
struct Moment {
    time: f64,
    distance: f64,
    speed: f64,
    sticks: bool,
}

fn throw(slope: f64) -> Result<Vec<Moment>, Box<dyn Error>> {
    // A brick of 2 kg, 20 x 16 x 10 cm. It stays flat on the slope, so M and H never change.
    let (m, half) = (2.0, vector![0.10, 0.08, 0.05]);
    let [a, b, c] = half.map(|x| x * x).into();
    let inertia = vector![b + c, c + a, a + b] * (m / 3.0);
    let mass = Matrix6::from_diagonal(&vector![m, m, m, inertia.x, inertia.y, inertia.z]);
    let weight = vector![slope.sin(), 0.0, -slope.cos(), 0.0, 0.0, 0.0] * (m * GRAVITY);

    let mut scene = Scene::<f64, 6, 3, 4>::new();
    scene.set_mass(&mass)?;
    for (x, y) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        let corner = vector![x * half.x, y * half.y, -half.z];
        let velocity = point_jacobian(&corner);
        scene.push(&Contact::at_point(&Vector3::z(), &velocity, MU, 0)?)?;
    }
    let factor = Factor::new(&scene)?;
    let mut solver = Solver::new();
    let settings = Settings::new(1e-9);

    let (mut distance, mut gap) = (0.0, GAP);
    let mut velocity = vector![SPEED, 0.0, 0.0, 0.0, 0.0, 0.0];
    let mut moments = Vec::new();
    for step in 1..=100 {
        // The gap of all four corners; an offset and f cost no new factor.
        let offset = vector![gap.offset(STEP)?, 0.0, 0.0];
        for corner in 0..4 {
            scene.set_offset(corner, &offset)?;
        }
        let push = free_impulse(&mass, &velocity, &weight, STEP);
        let solution = solver.solve(&scene, &factor, &push, &settings)?;
        if solution.status != Status::Solved {
            return Err(format!("step {step}: {:?}", solution.status).into());
        }
        velocity = solution.velocity;
        distance += STEP * velocity.x;
        gap.distance += STEP * velocity.z;
        moments.push(Moment {
            time: STEP * f64::from(step),
            distance,
            speed: velocity.x,
            sticks: solution.contacts.iter().all(|c| c.mode == ContactMode::Stick),
        });
    }
    Ok(moments)
}

/// Distance and speed on paper.
fn on_paper(slope: f64, time: f64) -> (f64, f64) {
    let acceleration = GRAVITY * (slope.sin() - MU * slope.cos());
    let stops = if acceleration < 0.0 { -SPEED / acceleration } else { f64::INFINITY };
    let t = time.min(stops);
    (SPEED * t + acceleration * t * t / 2.0, SPEED + acceleration * t)
}

fn main() -> Result<(), Box<dyn Error>> {
    let (mut speeds, mut distances) = (Vec::new(), Vec::new());
    for (degrees, label, paper) in [(12.0_f64, "12 degrees", "on paper"), (30.0, "30 degrees", "")] {
        let slope = degrees.to_radians();
        let moments = throw(slope)?;
        let last = moments.last().ok_or("no step was taken")?;
        let expected = on_paper(slope, last.time).0;
        let does = if last.sticks { "sticks" } else { "slides" };
        println!(
            "{degrees} degrees: {does} after {:.2} s and {:.3} m, {expected:.3} m on paper",
            last.time, last.distance
        );
        let times = || moments.iter().map(|m| m.time);
        let points = |value: fn(&Moment) -> f64| times().zip(moments.iter().map(value)).collect();
        let paper = |points| dots(paper, points);
        speeds.push(curve(label, points(|m| m.speed)));
        speeds.push(paper(times().map(|t| (t, on_paper(slope, t).1)).collect()));
        distances.push(curve(label, points(|m| m.distance)));
        distances.push(paper(times().map(|t| (t, on_paper(slope, t).0)).collect()));
    }
    pictures::draw(
        "box_on_slope",
        &[
            panel("A box thrown down a slope, mu = 0.4", "time (s)", "speed (m/s)", speeds),
            panel("How far it gets", "time (s)", "distance (m)", distances),
        ],
    )
}
