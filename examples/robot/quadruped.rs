//! A small quadruped from a URDF file drops, stands, is pushed, and trots up a step, for ten seconds.
//!
//! It draws what happened, and fails if the robot has fallen.
//!
//! `cargo run --release -p robot [FOLDER]`

mod gait;

use gait::Gait;
use nalgebra::{Vector3, vector};
use robot::{Base, Curve, Failure, Film, Tick, World};
use std::path::Path;

/// Velocities: six of the torso and twelve joints.
type Robot = World<18>;

/// Where the floor steps up, and by how much (m).
const EDGE: f64 = 0.6;
const RISE: f64 = 0.03;
/// When the robot is pushed, and when it trots (s), at which speed (m/s).
const PUSH: std::ops::Range<f64> = 1.5..1.65;
const TROT: std::ops::Range<f64> = 2.8..9.2;
const SPEED: f64 = 0.35;
const FEET: [&str; 4] = ["FL_foot", "FR_foot", "RL_foot", "RR_foot"];

/// The film.
const MOMENTS: [(f64, &str); 10] = [
    (0.0, "dropped"),
    (0.16, "lands"),
    (1.4, "stands"),
    (1.6, "is pushed and slides"),
    (2.5, "stands again"),
    (3.4, "trots"),
    (4.9, "a foot on the step"),
    (6.0, "hind feet follow"),
    (8.1, "trots on"),
    (9.9, "stands on the step"),
];

/// Lets a robot whose motors have this share of their torque live for ten seconds.
fn run(torque: f64) -> Result<(Robot, Vec<Tick>), Failure> {
    let mut world = Robot::new(0.6, [80.0, 3.0]);
    world.ground("floor", [-4.0, -4.0, -1.0], [8.0, 4.0, 0.0]);
    world.ground("step", [EDGE, -4.0, -1.0], [8.0, 4.0, RISE]);
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("quadruped.urdf");
    world.load(&file, Base::Free, [0.0, 0.0, 0.36])?;
    let (torso, mut gait) = (world.body("torso")?, Gait::standing());
    for (name, angle) in gait.angles() {
        let joint = world.joint(&name)?;
        (joint.angle, joint.target[0]) = (angle, angle);
        joint.effort *= torque;
    }
    let ticks = world.run(10.0, |world, time| {
        let trot = TROT.contains(&time).then_some(time - TROT.start);
        gait.advance(world, trot, SPEED * (time - TROT.start).clamp(0.0, 1.0));
        for (name, angle) in gait.angles() {
            world.aim(&name, angle)?;
        }
        let push = f64::from(u8::from(PUSH.contains(&time)));
        world.push = (torso, vector![55.0, 15.0, 0.0] * push);
        Ok(())
    })?;
    Ok((world, ticks))
}

/// What cannot be if the robot has fallen, or physics is wrong.
fn check(world: &Robot, ticks: &[Tick]) -> Result<(), Failure> {
    let (standing, end) = (&ticks[1400], &ticks[ticks.len() - 1]); // before the push, on the step
    let weight = world.trees[0].weight()?;
    for tick in [standing, end] {
        let carried: Vector3<f64> = tick.touches.iter().map(|touch| touch.force).sum();
        if (carried - Vector3::z() * weight).norm() > 0.01 * weight {
            return Err(format!("feet carry {carried:?}, not {weight:.2} N").into());
        }
    }
    let climbed = end.push[0].z - standing.push[0].z;
    let upright = (world.trees[0].turn * Vector3::z()).z;
    let deepest =
        ticks.iter().flat_map(|tick| &tick.touches).fold(0.0, |deepest, touch| touch.gap.min(deepest));
    if upright < 0.99 || (climbed - RISE).abs() > 0.02 || deepest < -2e-3 {
        return Err(
            format!("climbed {climbed:.3} m, upright {upright:.3}, a foot {:.1e} m deep", -deepest).into()
        );
    }
    Ok(())
}

fn main() -> Result<(), Failure> {
    let (world, ticks) = run(1.0)?;
    robot::report(&ticks);
    check(&world, &ticks)?;
    let [x, _, z] = world.trees[0].place.into();
    println!("it stands {x:.2} m ahead of where it fell, {z:.3} m high");
    let (middle, moments) = (|tick: &Tick| tick.push[0].x, &MOMENTS);
    let film = Film { moments, middle, size: [0.58, 0.5], bottom: -0.05, arrow: 3e-3 };
    world.film("robot.svg", &ticks, &film)?;
    let slip: Curve = ("fastest slip (m/s)", 0.8, &Tick::slip);
    let bands = [(PUSH, "push"), (TROT, "trot")];
    world.plots("robot_forces.svg", &ticks, (&FEET, 130.0), slip, &bands)
}

#[test]
fn stands_at_the_end_and_not_with_weak_motors() {
    let (world, ticks) = run(1.0).unwrap();
    check(&world, &ticks).unwrap();
    assert!(run(0.1).and_then(|(world, ticks)| check(&world, &ticks)).is_err());
}
