//! A small quadruped from a URDF file drops, stands, is pushed, and trots over a step, for ten seconds.
//!
//! Description and dynamics: `urdf-rs`, `dynibo`; collisions: `parry3d`; contacts with friction, joint limits and motors with
//! limited torque: stiction. It draws what happened, and fails if the robot has fallen.
//!
//! `cargo run --release -p robot [FOLDER]`

mod draw;
mod gait;
mod robot;
mod world;

use gait::Gait;
use indicatif::{ProgressBar, ProgressStyle};
use nalgebra::{Vector3, vector};
use robot::Robot;
use std::error::Error;
use std::path::{Path, PathBuf};
use stiction::{ContactMode, RowMode, Status};
use world::{RISE, STEP, Tick, World};

/// Steps in all; when the robot is pushed, and when it trots (s).
const TICKS: u32 = 10_000;
const PUSH: std::ops::Range<f64> = 1.5..1.65;
const TROT: std::ops::Range<f64> = 2.8..9.2;
const SPEED: f64 = 0.35;

/// The push at a time (N).
fn push(time: f64) -> Vector3<f64> {
    vector![55.0, 15.0, 0.0] * f64::from(u8::from(PUSH.contains(&time)))
}

/// Lets a robot whose motors have this share of their torque live for ten seconds.
fn run(torque: f64, progress: &ProgressBar) -> Result<(f64, Vec<Tick>), Box<dyn Error>> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("quadruped.urdf");
    let mut robot = Robot::load(&file)?;
    let mut gait = Gait::standing();
    robot.place.z = 0.36;
    for (angle, joint) in robot.angles.iter_mut().zip(&mut robot.joints) {
        *angle = gait.angles[joint.index];
        joint.effort *= torque;
    }
    let weight = robot.dynamics()?.mass[(3, 3)] * 9.81;
    let mut world = World::new(robot);
    let mut ticks = Vec::new();
    for tick in 0..TICKS {
        let time = f64::from(tick) * STEP;
        let trot = TROT.contains(&time).then_some(time - TROT.start);
        let speed = SPEED * (time - TROT.start).clamp(0.0, 1.0);
        gait.advance(&world.robot, trot, speed, STEP);
        let tick = world.step(&gait, push(time));
        ticks.push(tick.map_err(|error| format!("{time:.3} s: {error}"))?);
        progress.inc(1);
    }
    Ok((weight, ticks))
}

/// What cannot be if the robot has fallen, or physics is wrong.
fn check(weight: f64, ticks: &[Tick]) -> Result<(), String> {
    let (standing, end) = (&ticks[1400], &ticks[ticks.len() - 1]); // before the push, on the step
    for tick in [standing, end] {
        let carried: Vector3<f64> = tick.feet.iter().map(|foot| foot.force).sum();
        if (carried - Vector3::z() * weight).norm() > 0.01 * weight {
            return Err(format!("feet carry {carried:?}, not {weight:.2} N"));
        }
    }
    let feet = ticks.iter().flat_map(|tick| tick.feet);
    let deepest = feet.fold(0.0, |gap, foot| foot.gap.min(gap));
    let (upright, height) = ((end.turn * Vector3::z()).z, end.place.z);
    if upright < 0.99 || (height - standing.place.z - RISE).abs() > 0.02 || deepest < -2e-3 {
        let place = format!("{height:.3} m high, upright {upright:.3}");
        return Err(format!("{place}, a foot {:.1e} m deep", -deepest));
    }
    Ok(())
}

/// Prints what the steps cost, and how they were solved.
fn report(ticks: &[Tick]) {
    println!("a step costs (µs)     median    99 %   worst");
    for (part, name) in ["dynamics", "collision", "contact"].into_iter().enumerate() {
        let mut cost: Vec<_> = ticks.iter().map(|tick| tick.cost[part]).collect();
        cost.sort_by(f64::total_cmp);
        let at = |share: usize| cost[(cost.len() - 1) * share / 100];
        println!("{name:18} {:9.1} {:7.1} {:7.1}", at(50), at(99), at(100));
    }
    let count = |kind: &dyn Fn(&Tick) -> bool| ticks.iter().filter(|tick| kind(tick)).count();
    let (all, resumed) = (ticks.len(), count(&|tick| tick.resumed > 0));
    println!("of {all} ticks {resumed} ran out of budget and were resumed at once;");
    let left = count(&|tick| tick.status != Status::Solved);
    let worst = ticks.iter().map(|tick| tick.error).fold(0.0, f64::max);
    println!("{left} stayed unsolved, their best solution was used (largest error {worst:.1e})");
    let motor = [RowMode::AtLower, RowMode::AtUpper];
    let saturated = count(&|tick| tick.rows.iter().any(|mode| motor.contains(mode)));
    let stopped = count(&|tick| tick.rows.contains(&RowMode::AtLimit));
    println!("a motor saturated in {saturated} ticks, a joint was at its stop in {stopped}");
    let slips = |tick: &Tick| tick.feet.iter().any(|foot| foot.mode == ContactMode::Slip);
    println!("a foot slipped in {}", count(&slips));
}

fn main() -> Result<(), Box<dyn Error>> {
    let style = ProgressStyle::with_template("{wide_bar} {pos} of {len} steps, {eta} left")?;
    let progress = ProgressBar::new(TICKS.into()).with_style(style);
    let (weight, ticks) = run(1.0, &progress)?;
    progress.finish_and_clear();
    report(&ticks);
    check(weight, &ticks)?;
    let [x, _, z] = ticks[ticks.len() - 1].place.into();
    println!("it stands {x:.2} m ahead of where it fell, {z:.3} m high");

    let target = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target");
    let folder = std::env::args_os().nth(1).map_or(target, PathBuf::from);
    std::fs::create_dir_all(&folder)?;
    let (film, forces) = (folder.join("robot.svg"), folder.join("robot_forces.svg"));
    draw::film(&film, &ticks, push)?;
    draw::plots(&forces, &ticks, &[(PUSH, "push"), (TROT, "trot")])?;
    println!("drawn in {} and {}", film.display(), forces.display());
    Ok(())
}

#[test]
fn stands_at_the_end_and_not_with_weak_motors() {
    let (weight, ticks) = run(1.0, &ProgressBar::hidden()).unwrap();
    assert_eq!(check(weight, &ticks), Ok(()));
    let weak = run(0.1, &ProgressBar::hidden());
    assert!(weak.is_err() || weak.is_ok_and(|(weight, ticks)| check(weight, &ticks).is_err()));
}
