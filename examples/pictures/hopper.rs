//! A planar hopper: a body on a springy leg that hops off towards 1 m/s, and then on
//! the spot again.
//!
//! The foot is a contact that is open most of the time and stays in the scene: its gap is an offset,
//! so that one factor serves the whole run. Control after Raibert: thrust in stance, foot placement
//! in flight, the body kept upright by the hip while the foot holds on the floor.
//!
//! `cargo run --release -p pictures --bin hopper [FILE.svg]`

use nalgebra::{SMatrix, SVector, Vector2, matrix, vector};
use pictures::{curve, panel};
use std::error::Error;
use stiction::time_stepping::{Gap, free_impulse};
use stiction::{Contact, ContactMode, Factor, Scene, Settings, Solver, Status};

const GRAVITY: f64 = 9.81;
const STEP: f64 = 5e-4;
const MU: f64 = 0.7;
/// Body and foot (kg), and the body's moment of inertia (kg m²).
const BODY: f64 = 8.0;
const FOOT: f64 = 0.4;
const INERTIA: f64 = 0.6;
/// The leg: its length at rest (m), spring (N/m), damper (N s/m).
const LENGTH: f64 = 0.6;
const SPRING: f64 = 3000.0;
const DAMPER: f64 = 30.0;
/// A penetration is pushed out at 0.1 m/s at most; nothing closes faster than 10 m/s.
const GAP: Gap<f64> = Gap { distance: 0.0, recovery: 0.1, reach: 10.0 };

/// Body x, height, pitch; foot x, height.
type Coordinates = SVector<f64, 5>;

/// Weight, leg and motors.
fn force(q: &Coordinates, v: &Coordinates, stance: bool, wish: f64) -> Coordinates {
    let leg: Vector2<f64> = vector![q[3] - q[0], q[4] - q[1]];
    let (length, axis) = (leg.norm(), leg.normalize());
    let across = vector![-axis.y, axis.x];
    let rate = vector![v[3] - v[0], v[4] - v[1]];
    // Thrust: on the way up the spring is set 3 cm longer.
    let thrust = if stance && rate.dot(&axis) > 0.0 { 0.03 } else { 0.0 };
    let push = SPRING * (LENGTH + thrust - length) - DAMPER * rate.dot(&axis);
    let hip = if stance {
        60.0 * q[2] + 6.0 * v[2]
    } else {
        // The foot lands half a stance ahead, and further ahead to slow down.
        let ahead = 0.075 * v[0] + 0.04 * (v[0] - wish);
        let angle = (ahead / LENGTH).asin() - leg.x.atan2(-leg.y);
        30.0 * angle - 2.0 * rate.dot(&across) / length
    };
    let on_foot = axis * push + across * (hip / length);
    vector![-on_foot.x, -on_foot.y - BODY * GRAVITY, -hip, on_foot.x, on_foot.y - FOOT * GRAVITY]
}

fn main() -> Result<(), Box<dyn Error>> {
    let mass = SMatrix::<f64, 5, 5>::from_diagonal(&vector![BODY, BODY, INERTIA, FOOT, FOOT]);
    let mut scene = Scene::<f64, 5, 2, 1>::new();
    scene.set_mass(&mass)?;
    scene.push(&Contact {
        jacobian: matrix![0.0, 0.0, 0.0, 0.0, 1.0; 0.0, 0.0, 0.0, 1.0, 0.0],
        offset: vector![0.0, 0.0],
        mu: MU,
        key: 0,
    })?;
    let factor = Factor::new(&scene)?;
    let mut solver = Solver::new();
    let settings = Settings::new(1e-9);

    let mut q = vector![0.0, 0.9, 0.0, 0.0, 0.3];
    let mut v = Coordinates::zeros();
    let mut stance = false;
    let (mut body, mut foot) = (Vec::new(), Vec::new());
    let (mut speed, mut wished) = (Vec::new(), Vec::new());
    let (mut landings, mut slipping, mut standing) = (0, 0, 0);
    for step in 1..=20_000 {
        let time = STEP * f64::from(step);
        let wish = if (1.0..6.0).contains(&time) { 1.0 } else { 0.0 };
        let distance = q[4];
        let offset = vector![Gap { distance, ..GAP }.offset(STEP)?, 0.0];
        scene.set_offset(0, &offset)?;
        let push = free_impulse(&mass, &v, &force(&q, &v, stance, wish), STEP);
        let solution = solver.solve(&scene, &factor, &push, &settings)?;
        if solution.status != Status::Solved {
            return Err(format!("step {step}: {:?}", solution.status).into());
        }
        v = solution.velocity;
        q += v * STEP;
        let mode = solution.contacts[0].mode;
        let touches = mode != ContactMode::Open;
        landings += usize::from(touches && !stance);
        standing += usize::from(touches);
        slipping += usize::from(mode == ContactMode::Slip);
        stance = touches;
        if step % 10 == 0 {
            body.push((q[0], q[1]));
            foot.push((q[3], q[4]));
            speed.push((time, v[0]));
            wished.push((time, wish));
        }
    }
    println!("{landings} landings; on the floor in {standing} of 20000 steps, slipping in {slipping}");
    let paths = [curve("body", body), curve("foot", foot)];
    let speeds = [curve("body", speed), curve("wished for", wished)];
    pictures::draw(
        "hopper",
        &[
            panel("A planar hopper", "distance (m)", "height (m)", paths),
            panel("Its speed", "time (s)", "speed (m/s)", speeds),
        ],
    )
}
