//! A quadruped standing on ice is pushed sideways: which feet slip, and when they hold again.
//!
//! Replays `tests/sequences/go2_push_ice.json`, 48 steps of 4 ms with `M`, `H` and `f` as a dynamics
//! library gave them. Solved in f32 to 1e-4, as firmware would, each step from the one before.
//!
//! `cargo run --release -p pictures --bin quadruped_on_ice [FILE.svg]`

use pictures::{curve, dots, panel};
use std::error::Error;
use stiction::{ContactMode, Factor, Scene, Settings, Solver, Status};
use testbed::scene_file;

const STEP: f64 = 0.004;
/// In the order of the file's contacts.
const FEET: [&str; 4] = ["front left", "front right", "rear left", "rear right"];

fn main() -> Result<(), Box<dyn Error>> {
    let file = scene_file::repository().join("tests/sequences/go2_push_ice.json");
    let steps = scene_file::read(&file)?;

    let mut factor = Factor::<f32, 18, 3, 4>::empty();
    let mut solver = Solver::new();
    let settings = Settings::new(1e-4);
    let mut slips = [const { Vec::new() }; 4];
    let mut sideways = Vec::new();
    let mut work = 0;
    println!("each foot: = sticks, ~ slips, o open");
    for (k, step) in (1_u32..).zip(&steps) {
        let scene: Scene<f32, 18, 3, 4> = step.scene()?;
        factor.prepare(&scene)?;
        let solution = solver.solve(&scene, &factor, &step.free_impulse(), &settings)?;
        if solution.status != Status::Solved {
            return Err(format!("step {k}: {:?}", solution.status).into());
        }
        work += solution.work.total();

        let time = STEP * f64::from(k);
        let modes = solution.contacts.iter().map(|contact| match contact.mode {
            ContactMode::Stick => '=',
            ContactMode::Slip => '~',
            ContactMode::Open => 'o',
        });
        println!("{time:.3} s  {}", modes.collect::<String>());
        sideways.push((time, f64::from(solution.velocity[1])));
        for (slip, contact) in slips.iter_mut().zip(&solution.contacts) {
            slip.push((time, f64::from(contact.velocity.yz().norm())));
        }
    }
    println!("{} steps cost as much as {work} iterations of ADMM", steps.len());
    let push = [3.0, 13.0].map(|step| (STEP * step, 0.0));
    let feet = FEET.into_iter().zip(slips);
    let feet = feet.map(|(foot, points)| curve(foot, points));
    let title = "A quadruped on ice, mu = 0.2, pushed with 120 N";
    let body = [curve("body", sideways), dots("push: from, to", push.to_vec())];
    pictures::draw(
        "quadruped_on_ice",
        &[
            panel(title, "time (s)", "sideways (m/s)", body),
            panel("Its feet", "time (s)", "slip speed (m/s)", feet),
        ],
    )
}
