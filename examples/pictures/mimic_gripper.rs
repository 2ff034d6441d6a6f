//! A gripper whose fingers mimic each other, and whose motor saturates: it closes on a block, is lifted, and drops the block
//! when it is jerked upward.
//!
//! The motor can do 20 N and moves one finger; a joint row makes the other one do the same. Two pads hold
//! `2 mu F / 2` between them, since the force of the motor is shared out over both: with mu = 0.6 a block of 0.5 kg is held up to
//! 24 m/s² of gravity and acceleration.
//!
//! `cargo run --release -p pictures --bin mimic_gripper [FILE.svg]`

use nalgebra::{Matrix4, SMatrix, vector};
use pictures::{curve, dots, panel};
use std::error::Error;
use stiction::time_stepping::{ClosedLoop, Gap, Motor};
use stiction::{Contact, ContactMode, Kernel, RowMode, Settings};

const STEP: f64 = 1e-3;
const FINGER: f64 = 0.1;
const BLOCK: f64 = 0.5;
const HALF: f64 = 0.03;
const MU: f64 = 0.6;
const LIMIT: f64 = 20.0;
/// A penetration is pushed out at 0.1 m/s at most; nothing closes faster than 10 m/s.
const GAP: Gap<f64> = Gap { distance: 0.0, recovery: 0.1, reach: 10.0 };

/// What the block weighs in the moving hand (m/s²): at rest, then lifted faster and faster.
fn weight(time: f64) -> f64 {
    9.81 + (time - 0.4).max(0.0) * 40.0
}

fn main() -> Result<(), Box<dyn Error>> {
    // Dofs: left and right finger, inward; the block across and up, as the hand sees it.
    let masses = vector![FINGER, FINGER, BLOCK, BLOCK];
    let mut kernel = Kernel::<f64, 4, 2, 2, 2>::new();
    let scene = kernel.scene_mut();
    scene.set_mass(&Matrix4::from_diagonal(&masses))?;
    for (key, finger, side) in [(0, 0, 1.0), (1, 1, -1.0)] {
        let mut jacobian = SMatrix::<f64, 2, 4>::zeros();
        jacobian[(0, finger)] = -1.0;
        jacobian[(0, 2)] = side;
        jacobian[(1, 3)] = 1.0;
        scene.push(&Contact { jacobian, offset: vector![0.0, 0.0], mu: MU, key })?;
    }
    let motor = Motor { stiffness: 3e3, damping: 60.0, limit: LIMIT, ..Motor::default() };
    let drives = |x: f64| {
        let ahead = x - 0.02; // asked to close beyond the block
        Motor { ahead, ..motor }.row(vector![1.0, 0.0, 0.0, 0.0], STEP, 0)
    };
    let mimics = |drift: f64| {
        let recovery = 0.1;
        ClosedLoop { drift, recovery }.row(vector![1.0, -1.0, 0.0, 0.0], STEP, 1)
    };
    let drive = scene.push_row(&drives(-0.01)?)?;
    let gear = scene.push_row(&mimics(0.0)?)?;

    // The fingers are a centimetre away from the block at first.
    let mut position = vector![-0.01, -0.01, 0.0, 0.0];
    let mut velocity = vector![0.0, 0.0, 0.0, 0.0];
    let settings = Settings::new(1e-9);
    let (mut forces, mut slides, mut loads) = (Vec::new(), Vec::new(), Vec::new());
    let (mut full, mut slips) = (None, None);
    for step in 1..=1000 {
        let time = STEP * f64::from(step);
        let scene = kernel.scene_mut();
        for (finger, side) in [(0, 1.0), (1, -1.0)] {
            let distance = side * position[2] - position[finger];
            let offset = vector![Gap { distance, ..GAP }.offset(STEP)?, 0.0];
            scene.set_offset(finger, &offset)?;
        }
        scene.set_row_offset(drive, drives(position[0])?.offset)?;
        scene.set_row_offset(gear, mimics(position[0] - position[1])?.offset)?;
        let mut push = masses.component_mul(&velocity);
        // A table carries it until the gripper is closed.
        let carried = time < 0.3;
        push[3] -= if carried { 0.0 } else { STEP * BLOCK * weight(time) };
        let solution = kernel.solve(&push, &settings)?;
        if !solution.is_solved() {
            return Err(format!("{time} s: {}", solution.status).into());
        }
        velocity = solution.velocity;
        position += velocity * STEP;
        let motor = &solution.rows[drive];
        if motor.mode == RowMode::AtUpper && position[0] > -1e-6 {
            full.get_or_insert(time);
        }
        if solution.contacts[0].mode == ContactMode::Slip && time > 0.4 {
            slips.get_or_insert(time);
        }
        forces.push((time, motor.impulse / STEP));
        loads.push((time, BLOCK * if carried { 0.0 } else { weight(time) }));
        slides.push((time, (1e3 * position[3]).max(-HALF * 1e3)));
    }
    let expected = 0.4 + (MU * LIMIT / BLOCK - 9.81) / 40.0;
    let show = |time: Option<f64>| time.map_or("never".into(), |time| format!("{time:.3} s"));
    println!("grips with all it has at {}", show(full));
    println!("slips at {}; on paper {expected:.3} s", show(slips));
    pictures::draw(
        "mimic_gripper",
        &[
            panel(
                "A gripper of two fingers that mimic each other",
                "time (s)",
                "force (N)",
                [
                    curve("motor, 20 N at most", forces),
                    curve("weight of the block", loads),
                    dots("slips on paper", vec![(expected, MU * LIMIT)]),
                ],
            ),
            panel("The block in the hand", "time (s)", "height (mm)", [curve("block", slides)]),
        ],
    )
}
