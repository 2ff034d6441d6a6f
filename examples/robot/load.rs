//! Lets the robot of a URDF file stand or fall on a floor for a second, and says in one line how that went, or why it is refused.
//!
//! `cargo run --release -p robot --bin load -- ROBOT.urdf [bolted]`

use robot::{Base, Body, Failure, Tick, Tree, World};
use std::path::Path;
use std::process::ExitCode;

/// Gains of all motors (N m/rad, N m s/rad), which hold each joint where it is in the beginning.
const GAINS: [f64; 2] = [1e3, 30.0];

/// A second of a tree in a world that has room for `N` velocities.
fn run<const N: usize>(tree: Tree, bodies: Vec<Body>) -> Result<Vec<Tick>, Failure> {
    let mut world = World::<N, 48, 160>::with_room(0.8, GAINS);
    world.ground("floor", [-100.0, -100.0, -1.0], [100.0, 100.0, 0.0]);
    world.add(tree, bodies, [0.0; 3]);
    let lowest = world.lowest()?;
    if lowest.is_finite() {
        world.trees[0].place.z = -lowest;
    }
    world.run(1.0, |_, _| Ok(()))
}

/// How the second went.
fn load(file: &Path, base: Base) -> Result<String, Failure> {
    let (tree, bodies) = Tree::load(file, base)?;
    let (size, shapes, weight) = (tree.size(), bodies.len(), tree.weight()?);
    let passive = tree.passive().len();
    let remarks = [
        (shapes == 0).then(|| "; no link has a <collision>: it falls through the floor".to_owned()),
        (passive > 0).then(|| format!("; {passive} joints without a motor (effort 0 or missing)")),
    ];
    // What a world has room for and the robot has not costs time alone; each size takes seconds to compile.
    let ticks = match size {
        0..=18 => run::<18>(tree, bodies),
        19..=36 => run::<36>(tree, bodies),
        37..=64 => run::<64>(tree, bodies),
        65..=112 => run::<112>(tree, bodies),
        _ => Err(format!("{size} velocities, and load.rs has room for 112").into()),
    };
    let file = file.display();
    let ticks = ticks.map_err(|error| format!("{file}: {error}"))?;
    let error = ticks.iter().map(|tick| tick.error).fold(0.0, f64::max);
    let unsolved = ticks.iter().filter(|tick| tick.error > 1e-8).count();
    let last = &ticks[ticks.len() - ticks.len() / 5..];
    let forces = last.iter().flat_map(|tick| &tick.touches).map(|touch| touch.force.z);
    let carried = forces.sum::<f64>() / f64::from(u32::try_from(last.len())?);
    Ok(format!(
        "{file}: {size} velocities, {shapes} shapes, {weight:.1} N, of which the floor carries {carried:.1} N in the last 0.2 s of 1 s; {unsolved} of {} steps unsolved, largest error {error:.1e}{}",
        ticks.len(),
        remarks.into_iter().flatten().collect::<String>()
    ))
}

fn main() -> ExitCode {
    let mut arguments = std::env::args_os().skip(1);
    let line = match (arguments.next(), arguments.next()) {
        (Some(file), None) => load(file.as_ref(), Base::Free),
        (Some(file), Some(word)) if word == "bolted" => load(file.as_ref(), Base::Bolted),
        _ => Err("usage: load ROBOT.urdf [bolted]".into()),
    };
    match line {
        Ok(line) => println!("{line}"),
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}
