//! What the joints are told: to stand, or to trot with feet that land where they catch the torso.

use nalgebra::{Vector2, Vector3, vector};
use robot::{STEP, World};
use std::f64::consts::PI;

const PERIOD: f64 = 0.4;
/// Share of the period in which a foot is in the air, and how high it is lifted (m).
const SWING: f64 = 0.42;
const LIFT: f64 = 0.075;
/// Share of the swing in which it moves ahead; then it moves with the ground, on which it is to land.
const AHEAD: f64 = 0.8;
/// Height of the torso above its feet's centres, length of a thigh and of a shank (m).
const HEIGHT: f64 = 0.23;
const LENGTH: f64 = 0.16;
/// Hip of the front left leg, and from there to the plane of the leg (m).
const HIP: [f64; 2] = [0.17, 0.07];
const OUT: f64 = 0.05;

/// Feet's targets in the torso's frame.
pub(crate) struct Gait {
    feet: [Vector3<f64>; 4],
}

const LEGS: [&str; 4] = ["FL", "FR", "RL", "RR"];
const PARTS: [&str; 3] = ["hip", "thigh", "calf"];

/// +1 for legs ahead and at the left, -1 for the others.
const SIGNS: [[f64; 2]; 4] = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];

/// Where a foot stands.
fn neutral(leg: usize) -> Vector3<f64> {
    let [ahead, left] = SIGNS[leg];
    vector![ahead * HIP[0], left * (HIP[1] + OUT), -HEIGHT]
}

/// Hip, thigh and knee angles that bring the foot there.
fn angles(leg: usize, foot: &Vector3<f64>) -> [f64; 3] {
    let [ahead, left] = SIGNS[leg];
    let (x, y, z) = (foot.x - ahead * HIP[0], foot.y - left * HIP[1], foot.z);
    let down = (y * y + z * z - OUT * OUT).max(1e-4).sqrt();
    let hip = z.atan2(y) - (-down).atan2(left * OUT);
    let bend = ((x * x + down * down) / (2.0 * LENGTH * LENGTH) - 1.0).clamp(-1.0, 1.0);
    let knee = -bend.acos();
    [hip, (-x).atan2(down) - knee / 2.0, knee]
}

impl Gait {
    pub(crate) fn standing() -> Self {
        Self { feet: [0, 1, 2, 3].map(neutral) }
    }

    /// Moves the targets on by one step: `trot` seconds into a trot at `speed` (m/s), or standing.
    pub(crate) fn advance<const N: usize>(&mut self, world: &World<N>, trot: Option<f64>, speed: f64) {
        if let Some(time) = trot {
            let (torso, velocity) = (&world.trees[0], world.velocity.fixed_rows::<3>(3));
            let yaw = torso.turn.euler_angles().2;
            let flat = torso.turn.inverse() * Vector3::from(velocity);
            let wish = vector![speed, (-torso.place.y - speed * yaw).clamp(-0.1, 0.1)];
            let turn = (-2.0 * yaw).clamp(-0.5, 0.5);
            for (leg, foot) in self.feet.iter_mut().enumerate() {
                let home = neutral(leg);
                let along: Vector2<f64> = wish + turn * vector![-home.y, home.x];
                let pair = if leg == 0 || leg == 3 { 0.0 } else { 0.5 };
                let swung = (time / PERIOD + pair).fract() / SWING;
                let mut to = foot.xy() - along * STEP; // with the ground
                if swung < AHEAD {
                    let catch = (flat.xy() - wish) * 0.12;
                    let land = home.xy() + along * (PERIOD * (1.0 - SWING) / 2.0) + catch;
                    let left = (AHEAD - swung) * SWING * PERIOD;
                    to = foot.xy() + (land - foot.xy()) * (STEP / left).min(1.0);
                }
                let lift = LIFT * (PI * swung.min(1.0)).sin().powi(2);
                *foot = vector![to.x, to.y, -HEIGHT + lift];
            }
        }
    }

    /// What each joint has to be for the feet to be at their targets, by name.
    pub(crate) fn angles(&self) -> Vec<(String, f64)> {
        let leg = |leg: usize| {
            PARTS.map(|part| format!("{}_{part}", LEGS[leg])).into_iter().zip(angles(leg, &self.feet[leg]))
        };
        (0..4).flat_map(leg).collect()
    }
}
