//! A door with friction in its hinge, a closer and two stops: somebody throws it open, and it shuts itself.
//!
//! Friction, closer and stops are joint rows: no contact is needed. The closer is a spring with a damper that can do 12 N·m
//! and no more. Where the door lies still, friction and closer share the torque of the spring as the law says.
//!
//! `cargo run --release -p pictures --bin door [FILE.svg]`

use nalgebra::{Matrix1, vector};
use pictures::{curve, panel};
use std::error::Error;
use stiction::time_stepping::{DryFriction, JointLimit, Motor};
use stiction::{Kernel, RowMode, Settings};

const STEP: f64 = 2e-3;
/// Of a door of 25 kg and 0.9 m about its hinge (kg m²).
const INERTIA: f64 = 6.75;
/// Where it is stopped (rad).
const OPEN: f64 = 1.7;
/// Friction of the hinge (N·m).
const FRICTION: DryFriction<f64> = DryFriction { torque: 1.5 };
/// A stop: the door comes back from beyond it at 0.2 rad/s at most, and swings at less than 50 rad/s.
const STOP: JointLimit<f64> = JointLimit { distance: 0.0, recovery: 0.2, reach: 50.0 };

fn main() -> Result<(), Box<dyn Error>> {
    let closer = Motor { stiffness: 10.0, damping: 9.0, limit: 12.0, ..Motor::default() };
    // Its spring is wound up when the door is shut.
    let rest = -0.5;
    let mut kernel = Kernel::<f64, 1, 1, 0, 4>::new(); // no contacts, four joint rows
    let scene = kernel.scene_mut();
    scene.set_mass(&Matrix1::new(INERTIA))?;
    let hinge = vector![1.0];
    let friction = scene.push_row(&FRICTION.row(hinge, STEP, 0)?)?;
    let closing = |angle: f64| {
        let ahead = angle - rest;
        Motor { ahead, ..closer }.row(hinge, STEP, 1)
    };
    let closer = scene.push_row(&closing(0.0)?)?;
    let stop = |row, distance, key| JointLimit { distance, ..STOP }.row(row, STEP, key);
    let frame = scene.push_row(&stop(hinge, 0.0, 2)?)?;
    let wall = scene.push_row(&stop(-hinge, OPEN, 3)?)?;

    let (mut angle, mut velocity) = (0.0, 0.0);
    let settings = Settings::new(1e-9);
    let mut angles = Vec::new();
    let mut torques = [const { Vec::new() }; 3];
    let (mut hits, mut shut) = (Vec::new(), None);
    for step in 1..=4000 {
        let time = STEP * f64::from(step);
        let hand = if time < 0.5 { 60.0 } else { 0.0 };
        let scene = kernel.scene_mut();
        scene.set_row_offset(closer, closing(angle)?.offset)?;
        scene.set_row_offset(frame, stop(hinge, angle, 2)?.offset)?;
        scene.set_row_offset(wall, stop(-hinge, OPEN - angle, 3)?.offset)?;
        let push = vector![INERTIA * velocity + STEP * hand];
        let solution = kernel.solve(&push, &settings)?;
        if !solution.is_solved() {
            return Err(format!("{time} s: {}", solution.status).into());
        }
        velocity = solution.velocity[0];
        angle += STEP * velocity;
        let [rubs, closes, walls] = [friction, closer, wall].map(|row| solution.rows[row]);
        if walls.mode == RowMode::AtLimit {
            hits.push((time, walls.impulse));
        }
        if shut.is_none() && time > 1.0 && solution.rows[frame].mode == RowMode::AtLimit {
            shut = Some(time);
        }
        angles.push((time, angle.to_degrees()));
        let [first, second, third] = &mut torques;
        first.push((time, rubs.impulse / STEP));
        second.push((time, closes.impulse / STEP));
        third.push((time, hand));
    }
    let hit: f64 = hits.iter().map(|(_, impulse)| impulse).sum();
    match hits.first() {
        Some((time, _)) => println!("hits the wall after {time:.2} s with {hit:.1} N·m·s"),
        None => println!("does not reach the wall"),
    }
    match shut {
        Some(time) => println!("shut after {time:.2} s"),
        None => println!("stays open at {:.1} degrees", angle.to_degrees()),
    }
    let [rubs, closes, hand] = torques;
    pictures::draw(
        "door",
        &[
            panel("A door that is thrown open", "time (s)", "angle (degrees)", [curve("door", angles)]),
            panel(
                "What acts on it",
                "time (s)",
                "torque (N m)",
                [
                    curve("friction of the hinge", rubs),
                    curve("closer, 12 N m at most", closes),
                    curve("hand", hand),
                ],
            ),
        ],
    )
}
