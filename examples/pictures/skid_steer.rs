//! A skid-steer rover turns: its tracks pull along, and have to slip across.
//!
//! Each of four contacts has 0.9 along the track and another coefficient across; the belts move as surfaces. With less grip
//! across the rover turns faster, and comes nearer to the rate of wheels that would not slip, `(v_r - v_l) / width`.
//!
//! `cargo run --release -p pictures --bin skid_steer [FILE.svg]`

use nalgebra::{Matrix6, SMatrix, Vector3, matrix, vector};
use pictures::{curve, panel};
use std::error::Error;
use stiction::time_stepping::free_impulse;
use stiction::{Contact, Kernel, Settings, Surface};

const STEP: f64 = 5e-3;
const MASS: f64 = 40.0;
const GRAVITY: f64 = 9.81;
/// Half the length between the axles and half the width between the tracks; height of the centre (m).
const HALF: [f64; 2] = [0.3, 0.2];
const HEIGHT: f64 = 0.15;
/// Velocities of the left and of the right belt (m/s).
const BELTS: [f64; 2] = [0.2, 0.8];

/// Velocity of the point `p` of a body, normal first; dofs are the velocity of its centre and its angular velocity, along its
/// own axes (forward, to the left, up).
fn jacobian(p: &Vector3<f64>) -> SMatrix<f64, 3, 6> {
    matrix![
        0.0, 0.0, 1.0, p.y, -p.x, 0.0;
        1.0, 0.0, 0.0, 0.0, p.z, -p.y;
        0.0, 1.0, 0.0, -p.z, 0.0, p.x
    ]
}

/// Where the rover was, and how fast it turned, with this coefficient across its tracks.
type Drive = (Vec<(f64, f64)>, Vec<(f64, f64)>);

fn drive(across: f64) -> Result<Drive, Box<dyn Error>> {
    let moments = vector![1.2, 2.0, 2.6];
    let mass = Matrix6::from_diagonal(&vector![MASS, MASS, MASS, moments.x, moments.y, moments.z]);
    let mut kernel = Kernel::<f64, 6, 3, 4, 0, 4>::new();
    let scene = kernel.scene_mut();
    scene.set_mass(&mass)?;
    let surface = Surface { friction: [0.9, across], ..Surface::isotropic(0.0) };
    let corners = [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
    for (key, (x, y)) in (0..).zip(corners) {
        let belt = if y > 0.0 { BELTS[0] } else { BELTS[1] };
        scene.push_on(
            &Contact {
                jacobian: jacobian(&vector![x * HALF[0], y * HALF[1], -HEIGHT]),
                offset: vector![0.0, -belt, 0.0],
                mu: 0.0,
                key,
            },
            &surface,
        )?;
    }
    let (mut x, mut y, mut yaw) = (0.0, 0.0, 0.0_f64);
    let mut velocity = vector![0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let weight = vector![0.0, 0.0, -MASS * GRAVITY, 0.0, 0.0, 0.0];
    let (mut path, mut rates) = (Vec::new(), Vec::new());
    for step in 1..=1200 {
        // In its own axes momentum turns with the rover: force -ω × m v.
        let spin = velocity[5];
        let turning = vector![spin * velocity[1], -spin * velocity[0], 0.0, 0.0, 0.0, 0.0];
        let force = weight + turning * MASS;
        let push = free_impulse(&mass, &velocity, &force, STEP);
        let solution = kernel.solve(&push, &Settings::new(1e-9))?;
        if !solution.is_solved() {
            return Err(format!("step {step}: {}", solution.status).into());
        }
        velocity = solution.velocity;
        let (sin, cos) = yaw.sin_cos();
        x += STEP * (cos * velocity[0] - sin * velocity[1]);
        y += STEP * (sin * velocity[0] + cos * velocity[1]);
        yaw += STEP * velocity[5];
        path.push((x, y));
        rates.push((STEP * f64::from(step), velocity[5]));
    }
    Ok((path, rates))
}

fn main() -> Result<(), Box<dyn Error>> {
    let ideal = (BELTS[1] - BELTS[0]) / (2.0 * HALF[1]);
    let (mut paths, mut turns) = (Vec::new(), Vec::new());
    for (across, label) in [(0.9, "0.9 across"), (0.5, "0.5 across"), (0.1, "0.1 across")] {
        let (path, rates) = drive(across)?;
        let (_, rate) = rates.last().ok_or("no step was taken")?;
        println!("{label}: turns at {rate:.3} rad/s, without slip at {ideal:.3}");
        paths.push(curve(label, path));
        turns.push(curve(label, rates));
    }
    turns.push(curve("without slip", vec![(0.0, ideal), (6.0, ideal)]));
    pictures::draw(
        "skid_steer",
        &[
            panel("A rover on tracks with 0.9 along, belts at 0.2 and 0.8 m/s", "x (m)", "y (m)", paths),
            panel("Less grip across turns faster", "time (s)", "yaw rate (rad/s)", turns),
        ],
    )
}
