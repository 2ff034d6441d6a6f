//! A leg on a test stand squats three times: the least that a robot of your own takes.
//!
//! `cargo run --release -p robot --bin leg [FOLDER]`

use robot::{Base, Curve, Failure, Film, Tick, World};
use std::{f64::consts::TAU, path::Path};

fn main() -> Result<(), Failure> {
    // Four velocities (rail, hip, knee, ankle); friction coefficient; gains of motors (N m/rad, N m s/rad).
    let mut world = World::<4>::new(0.8, [60.0, 1.0]);
    world.ground("floor", [-1.0, -1.0, -0.5], [1.0, 1.0, 0.0]);
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("leg.urdf");
    world.load(&file, Base::Bolted, [0.0, 0.0, 0.36])?;
    let ticks = world.run(3.0, |world, time| {
        let bend = 0.4 - 0.4 * (TAU * time).cos();
        world.aim("hip", -bend)?;
        world.aim("knee", 2.0 * bend)?;
        world.aim("ankle", -bend)
    })?;
    robot::report(&ticks);
    let film = Film {
        moments: &[(0.2, "lands"), (0.5, "is down"), (0.75, "rises"), (1.0, "is up")],
        middle: |_| 0.0,
        size: [0.5, 0.5],
        bottom: -0.05,
        arrow: 5e-3,
    };
    world.film("leg.svg", &ticks, &film)?;
    let slip: Curve = ("fastest slip (m/s)", 0.1, &Tick::slip);
    world.plots("leg_forces.svg", &ticks, (&["foot"], 60.0), slip, &[])
}
