//! A leg under a body that a guide keeps upright: sliders for a pull at the body (N), the friction, and the height of the body (m).
//!
//! Velocities: the body along and up, hip, knee. The masses of the leg are at knee and foot. Motors with gains hold the angles.

use crate::{GRAVITY, Given, PointJacobian, STEP, Scene, Touch, Vector};
use nalgebra::{SMatrix, Vector2, matrix, vector};
use stiction::time_stepping::Motor;
use stiction::{Error, heapless};

/// Body, knee, foot.
const MASSES: [f64; 3] = [8.0, 0.6, 0.2];
/// Thigh and shank.
const LINK: f64 = 0.35;
/// From the hip down to the underside of the body.
const BELOW: f64 = 0.08;
const MOTOR: Motor<f64> =
    Motor { stiffness: 800.0, damping: 90.0, limit: 100.0, feedforward: 0.0, ahead: 0.0, target: 0.0 };

pub(crate) const SCENE: Scene = Scene {
    numbers: [MASSES[0], MASSES[1], MASSES[2], LINK, BELOW, MOTOR.limit],
    rates: [30.0, f64::INFINITY, 0.3],
    starts: [0.0, 0.0, 0.5],
    turns: false,
    spring: 60.0,
    begin: |[_, _, height]| {
        let [hip, knee] = angles(height);
        vector![0.0, height, hip, knee, 0.0]
    },
    given,
};

/// Hip (from straight down, forward is positive) and knee, with the foot straight below the hip.
fn angles(height: f64) -> [f64; 2] {
    let hip = (height / (2.0 * LINK)).min(1.0).acos();
    [hip, -2.0 * hip]
}

fn given(q: &Vector, v: &Vector, [pull, mu, height]: [f64; 3]) -> Result<Given, Error> {
    // Position, Jacobian, and acceleration at constant joint speeds of hip, knee and foot.
    let link = |angle: f64| LINK * vector![angle.sin(), -angle.cos()];
    let [thigh, shank] = [link(q[2]), link(q[2] + q[3])];
    let hip: Vector2<f64> = vector![q[0], q[1]];
    let (knee, foot) = (hip + thigh, hip + thigh + shank);
    let of_knee: PointJacobian = matrix![1.0, 0.0, -thigh.y, 0.0, 0.0; 0.0, 1.0, thigh.x, 0.0, 0.0];
    let of_foot = of_knee + matrix![0.0, 0.0, -shank.y, -shank.y, 0.0; 0.0, 0.0, shank.x, shank.x, 0.0];
    let knee_turn = -thigh * (v[2] * v[2]);
    let foot_turn = knee_turn - shank * ((v[2] + v[3]) * (v[2] + v[3]));
    let points = [
        (hip, PointJacobian::identity(), vector![0.0, 0.0], BELOW),
        (knee, of_knee, knee_turn, 0.0),
        (foot, of_foot, foot_turn, 0.0),
    ];
    let mut given = Given {
        velocities: 4,
        mass: SMatrix::zeros(),
        force: vector![pull, 0.0, 0.0, 0.0, 0.0],
        touches: heapless::Vec::new(),
        rows: heapless::Vec::new(),
    };
    for (key, ((point, jacobian, turn, below), mass)) in (0..).zip(points.into_iter().zip(MASSES)) {
        given.mass += jacobian.tr_mul(&jacobian) * mass;
        given.force -= jacobian.tr_mul(&(turn + vector![0.0, GRAVITY])) * mass;
        let ground = point - vector![0.0, below];
        let touch = Touch::new(key, [ground, vector![0.0, 1.0]], &jacobian, mu, ground.y)?;
        let _ = given.touches.push(touch);
    }
    for (key, (joint, angle)) in (0..).zip([2, 3].into_iter().zip(angles(height))) {
        let mut row = Vector::zeros();
        row[joint] = 1.0;
        let motor = Motor { ahead: q[joint] - angle, ..MOTOR };
        let _ = given.rows.push(motor.row(row, STEP, key)?);
    }
    Ok(given)
}
