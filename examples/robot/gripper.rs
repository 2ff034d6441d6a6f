//! A gripper from a URDF file closes on a bottle, lifts it, is pushed and shaken, and sets the bottle down.
//!
//! The motor of one finger does 20 N, and a joint row makes the other finger do the same, so that the pads share these 20 N and
//! hold `mu F` = 12 N by friction: a bottle of 4.9 N, also while it is pushed, and shaken at 0.5 g. At last the motor yields, and
//! at `weight / mu` the bottle slips. The program draws what happened, and fails if the bottle was not lifted, or slipped.
//!
//! `cargo run --release -p robot --bin gripper [FOLDER]`

use nalgebra::{Vector3, vector};
use robot::{Base, Curve, Failure, Film, STEP, Tick, World};
use std::f64::consts::TAU;
use std::ops::Range;
use std::path::Path;

/// Velocities: the lift and two fingers, and six of the bottle.
type Cell = World<9>;

const MU: f64 = 0.6;
/// Largest force of the finger's motor (N).
const GRIP: f64 = 20.0;
/// How high it is lifted (m).
const LIFT: f64 = 0.1;
/// When the bottle is pushed, when the lift shakes, and when the motor yields (s).
const PUSH: Range<f64> = 3.2..3.7;
const SHAKE: Range<f64> = 4.2..5.2;
const YIELD: Range<f64> = 7.4..8.4;

/// The film.
const MOMENTS: [(f64, &str); 10] = [
    (0.0, "open"),
    (0.9, "grips"),
    (1.7, "lifts"),
    (2.8, "holds"),
    (3.5, "is pushed"),
    (4.42, "is shaken"),
    (6.5, "lowers"),
    (7.9, "yields"),
    (8.08, "too weak: slips"),
    (9.8, "stands"),
];

/// From 0 to 1 while `time` goes through a span (s), smoothly.
fn rise(time: f64, from: f64, to: f64) -> f64 {
    let x = ((time - from) / (to - from)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Lets a gripper whose finger has this force (N) live for some time (s).
fn run(grip: f64, seconds: f64) -> Result<(Cell, Vec<Tick>), Failure> {
    let mut world = Cell::new(MU, [5e3, 100.0]);
    world.stiffness = 1e5;
    world.ground("table", [-1.0, -1.0, -0.5], [1.0, 1.0, 0.0]);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    world.load(&folder.join("gripper.urdf"), Base::Bolted, [0.0, 0.0, 0.6])?;
    world.load(&folder.join("bottle.urdf"), Base::Free, [0.0, 0.0, 0.08])?;
    let bottle = world.body("bottle")?;
    let ticks = world.run(seconds, |world, time| {
        let part = |span: &Range<f64>| f64::from(u8::from(span.contains(&time)));
        let shaken = part(&SHAKE) * (1.0 - (TAU * 3.0 * (time - SHAKE.start)).cos());
        let lifted = LIFT * rise(time, 1.2, 2.4) - (LIFT - 0.01) * rise(time, 5.8, 7.2);
        world.aim("lift", lifted + 0.015 * shaken + 0.06 * rise(time, 9.1, 9.7))?;
        world.aim("left", 0.04 * (rise(time, 0.2, 0.8) - rise(time, 8.6, 9.0)))?; // beyond the bottle
        world.joint("left")?.effort = grip * (1.0 - part(&YIELD) * (1.0 - left(time)));
        world.push = (bottle, vector![5.0, 3.0, 0.0] * part(&PUSH));
        Ok(())
    })?;
    Ok((world, ticks))
}

/// Share of its force that the motor has left while it yields.
fn left(time: f64) -> f64 {
    (YIELD.end - time) / (YIELD.end - YIELD.start)
}

/// How fast the bottle slips on a pad (m/s).
fn slip(world: &Cell, tick: &Tick) -> f64 {
    let pads = world.touches(tick, "left_pad").chain(world.touches(tick, "right_pad"));
    pads.map(|touch| touch.slip).fold(0.0, f64::max)
}

/// How far it slips from one tick to another (m).
fn slipped(world: &Cell, ticks: &[Tick]) -> f64 {
    ticks.iter().map(|tick| slip(world, tick) * STEP).sum()
}

/// The last force of the yielding motor at which it does not slip (N).
fn weakest(world: &Cell, ticks: &[Tick]) -> f64 {
    let yields = (0..).map(f64::from).zip(&ticks[7400..8400]);
    let held = yields.take_while(|(_, tick)| slip(world, tick) < 1e-5);
    held.map(|(step, _)| GRIP * left(YIELD.start + step * STEP)).fold(GRIP, f64::min)
}

/// What cannot be if the gripper has lost the bottle, or physics is wrong.
fn check(world: &Cell, ticks: &[Tick]) -> Result<(), Failure> {
    let weight = world.trees[1].weight()?;
    let holds = &ticks[2800];
    let carried: Vector3<f64> = holds.touches.iter().map(|touch| touch.force).sum();
    if (carried - Vector3::z() * weight).norm() > 1e-3 * weight {
        return Err(format!("pads carry {carried:?}, not {weight:.2} N").into());
    }
    let lifted = holds.push[0].z - ticks[0].push[0].z;
    if lifted < LIFT - 0.01 {
        return Err(format!("the bottle is lifted by {lifted:.3} m").into());
    }
    let slipped = slipped(world, &ticks[1000..2800]);
    if slipped > 1e-3 {
        return Err(format!("the bottle slips by {slipped:.3} m").into());
    }
    Ok(())
}

fn main() -> Result<(), Failure> {
    let (world, ticks) = run(GRIP, 10.0)?;
    robot::report(&ticks);
    check(&world, &ticks)?;
    let slipped = 1e3 * slipped(&world, &ticks[1000..7400]);
    let (force, paper) = (weakest(&world, &ticks), world.trees[1].weight()? / MU);
    println!("the bottle slips by {slipped:.1e} mm until the motor yields");
    println!("it is held down to {force:.2} N; on paper {paper:.2} N");
    let film = Film { moments: &MOMENTS, middle: |_| 0.0, size: [0.3, 0.45], bottom: -0.03, arrow: 5e-3 };
    world.film("gripper.svg", &ticks, &film)?;
    let slip: Curve = ("slip on pads (m/s)", 0.2, &|tick| slip(&world, tick));
    let bands = [(PUSH, "pushed"), (SHAKE, "shaken"), (YIELD, "yields")];
    let links = ["left_pad", "right_pad", "table"];
    world.plots("gripper_forces.svg", &ticks, (&links, 15.0), slip, &bands)
}

#[test]
fn the_bottle_is_held_until_the_motor_yields_and_then_stands() {
    let (world, ticks) = run(GRIP, 10.0).unwrap();
    check(&world, &ticks).unwrap();
    assert!(slipped(&world, &ticks[1000..7400]) < 1e-6);
    let paper = world.trees[1].weight().unwrap() / MU;
    assert!((weakest(&world, &ticks) / paper - 1.0).abs() < 3e-3); // it yields by 20 N/s, 0.02 N a step
    let (bottle, end) = (&world.trees[1], &ticks[ticks.len() - 1]);
    assert!((end.push[0] - ticks[0].push[0]).norm() < 2e-3); // back where it stood
    assert!((bottle.turn * Vector3::z()).z > 0.9999);
}

#[test]
fn a_little_more_than_the_force_on_paper_lifts_the_bottle_and_half_of_it_does_not() {
    let paper = 0.5 * robot::GRAVITY / MU;
    let (world, ticks) = run(1.2 * paper, 3.0).unwrap();
    check(&world, &ticks).unwrap();
    let (world, ticks) = run(0.5 * paper, 3.0).unwrap();
    let lost = check(&world, &ticks).unwrap_err().to_string();
    assert!(lost.contains("is lifted by"), "{lost}");
    assert!(slipped(&world, &ticks[1000..2900]) > 0.05);
}
