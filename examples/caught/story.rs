//! The story: the robot stands on the ramp, is pushed onto the ice, slips, and is caught. Or not.

use crate::controller::{Controller, stance};
use crate::plant::{Plant, TICK, Touch};
use nalgebra::Vector3;
use std::ops::Range;
use std::time::Instant;
use stiction::{ContactMode, Error};

/// Ticks of the story, at 1 kHz.
pub(crate) const TICKS: i16 = 1800;
/// Ticks before it, in which the robot comes to rest.
const SETTLING: i16 = 200;
/// Ticks in which somebody pushes the torso downhill, and the push (N).
pub(crate) const PUSH: Range<i16> = 300..500;
pub(crate) const FORCE: f32 = 18.0;

/// What is seen in a tick.
pub(crate) struct Tick {
    /// Time at its beginning (s).
    pub(crate) time: f32,
    /// Feet on the floor: front left, front right, rear left, rear right.
    pub(crate) touches: [Touch; 4],
    /// Places of thigh hinge, knee and foot of each leg (m).
    pub(crate) legs: [[Vector3<f32>; 3]; 4],
    /// Place of the torso downhill (m), and its speed (m/s).
    pub(crate) place: f32,
    pub(crate) speed: f32,
    /// Push on the torso downhill (N).
    pub(crate) push: f32,
    /// Whether the controller moves the torso uphill.
    pub(crate) leans: bool,
    /// Time that the controller takes (µs).
    pub(crate) took: f32,
}

impl Tick {
    /// Returns whether all feet stick.
    pub(crate) fn sticks(&self) -> bool {
        self.touches.iter().all(|touch| touch.mode == ContactMode::Stick)
    }

    /// Returns the friction as a share of the most that the floor can give.
    pub(crate) fn used(&self) -> f32 {
        let force = self.touches.iter().map(|touch| touch.force.yz().norm()).sum::<f32>();
        force / self.touches.iter().map(|touch| touch.limit).sum::<f32>()
    }
}

/// Tells the story, with the catch or without.
pub(crate) fn tell(catches: bool) -> Result<Vec<Tick>, Error> {
    let (mut plant, mut controller) = (Plant::new(stance(0.0)), Controller::new(catches));
    let mut ticks = Vec::new();
    for tick in -SETTLING..TICKS {
        let (sensors, lean) = (plant.sense(), controller.lean);
        let start = Instant::now();
        let torques = controller.tick(&sensors)?;
        let took = start.elapsed().as_secs_f32() * 1e6;
        let push = if PUSH.contains(&tick) { FORCE } else { 0.0 };
        plant.tick(&torques, push)?;
        if tick < 0 {
            continue;
        }
        ticks.push(Tick {
            time: f32::from(tick) * TICK,
            touches: plant.touches,
            legs: plant.legs(),
            place: plant.place.x,
            speed: plant.speed(),
            push,
            leans: controller.lean < lean - 5e-5,
            took,
        });
    }
    Ok(ticks)
}

#[cfg(test)]
mod tests {
    use super::{Tick, tell};
    use stiction::ContactMode;

    /// Speed of a robot that stands (m/s).
    const STILL: f32 = 1e-3;

    #[test]
    fn robot_stands_slips_when_pushed_and_is_caught() {
        let ticks = tell(true).unwrap();
        let (before, after) = ticks.split_at(ticks.iter().position(|tick| tick.push > 0.0).unwrap());
        assert!(before.iter().all(Tick::sticks));
        let slips = |key: usize| after.iter().any(|tick| tick.touches[key].mode == ContactMode::Slip);
        assert!((0..4).all(slips));
        assert!(
            ticks
                .iter()
                .rev()
                .take(200)
                .all(|tick| tick.sticks() && tick.speed < STILL && tick.used() < 0.95)
        );
    }

    #[test]
    fn robot_slides_off_without_the_catch() {
        let ticks = tell(false).unwrap();
        assert!(ticks.iter().rev().take(200).all(|tick| !tick.sticks() && tick.speed > 0.5));
    }
}
