//! A gripper holds a block above a table: sliders for the squeeze (N at each finger), the friction, and the mass of the block (kg).
//!
//! Velocities: the block across, up and turning, then the left and the right finger, inward. One motor moves the left finger, a
//! closed loop makes the right one mimic it.

use crate::{GRAVITY, Given, STEP, Scene, Touch, Vector, of_body, turned};
use nalgebra::{SMatrix, vector};
use stiction::time_stepping::{ClosedLoop, Motor};
use stiction::{Error, heapless};

/// Half the width and half the height of the block, half the height of a pad, and the table below the middle of the hand.
const HALF: [f64; 2] = [0.05, 0.07];
const PAD: f64 = 0.03;
const TABLE: f64 = 0.22;
const FINGER: f64 = 0.1;
/// A motor asked to close 2 cm beyond the face of the block: `squeeze` bounds it.
const MOTOR: Motor<f64> =
    Motor { stiffness: 5e3, damping: 60.0, limit: 0.0, feedforward: 0.0, ahead: 0.0, target: 0.0 };

pub(crate) const SCENE: Scene = Scene {
    numbers: [HALF[0], HALF[1], PAD, TABLE, FINGER, 0.0],
    rates: [f64::INFINITY; 3],
    starts: [0.0; 3],
    turns: true,
    spring: 200.0,
    begin: |_| Vector::zeros(),
    given,
};

fn given(q: &Vector, _: &Vector, [squeeze, mu, mass]: [f64; 3]) -> Result<Given, Error> {
    let [w, h] = HALF;
    let middle = q.fixed_rows::<2>(0);
    let inertia = mass * (w * w + h * h) / 3.0;
    let mut touches = heapless::Vec::new();
    for (finger, side) in [(3, 1.0), (4, -1.0)] {
        for height in [-PAD, PAD] {
            let point = vector![side * (q[finger] - w), height];
            let lever = point - middle;
            let in_block = turned(-q[2], [lever.x, lever.y]);
            if in_block.y.abs() > h {
                continue; // above or below the block
            }
            let mut jacobian = of_body(&lever);
            jacobian[(0, finger)] = -side;
            let normal = turned(q[2], [side, 0.0]);
            let key = u32::from(side < 0.0) + if height > 0.0 { 2 } else { 0 };
            let distance = -w - side * in_block.x;
            let _ = touches.push(Touch::new(key, [point, normal], &jacobian, mu, distance)?);
        }
    }
    for (key, corner) in (4..).zip([[-w, -h], [w, -h], [w, h], [-w, h]]) {
        let lever = turned(q[2], corner);
        let point = middle + lever;
        let distance = point.y + TABLE;
        let _ = touches.push(Touch::new(key, [point, vector![0.0, 1.0]], &of_body(&lever), mu, distance)?);
    }
    let motor = Motor { limit: 2.0 * squeeze, ahead: q[3] - 0.02, ..MOTOR };
    let mimic = ClosedLoop { drift: q[3] - q[4], recovery: 0.1 };
    let mut rows = heapless::Vec::new();
    let _ = rows.push(motor.row(vector![0.0, 0.0, 0.0, 1.0, 0.0], STEP, 0)?);
    let _ = rows.push(mimic.row(vector![0.0, 0.0, 0.0, 1.0, -1.0], STEP, 1)?);
    Ok(Given {
        velocities: 5,
        mass: SMatrix::from_diagonal(&vector![mass, mass, inertia, FINGER, FINGER]),
        force: vector![0.0, -mass * GRAVITY, 0.0, 0.0, 0.0],
        touches,
        rows,
    })
}
