//! The story: the robot stands on the ramp, is pushed onto the ice, and is caught. Or not.

use crate::controller::{Controller, stance};
use crate::plant::{EDGE, Plant, Touch};
use nalgebra::Vector3;
use std::ops::Range;
use std::time::Instant;
use stiction::{ContactMode, Error};

/// Ticks of the story, at 1 kHz.
pub(crate) const TICKS: usize = 2500;
/// Ticks in which somebody pushes the torso downhill, and the push (N).
pub(crate) const PUSH: Range<usize> = 500..700;
pub(crate) const FORCE: f32 = 18.0;

/// What was seen in a tick.
pub(crate) struct Tick {
    /// Feet: front left, front right, rear left, rear right.
    pub(crate) touches: [Touch; 4],
    /// Place of the torso, and of each foot (m).
    pub(crate) torso: Vector3<f32>,
    pub(crate) feet: [Vector3<f32>; 4],
    /// Mean speed of the feet downhill (m/s).
    pub(crate) speed: f32,
    /// Whether the controller moves the torso.
    pub(crate) leans: bool,
    /// Time of the controller (µs).
    pub(crate) time: f32,
}

impl Tick {
    /// Returns whether a foot slips.
    pub(crate) fn slips(&self) -> bool {
        self.touches.iter().any(|touch| touch.mode == ContactMode::Slip)
    }

    /// Returns whether all feet stick.
    pub(crate) fn sticks(&self) -> bool {
        self.touches.iter().all(|touch| touch.mode == ContactMode::Stick)
    }

    /// Returns the friction that is used: the share of what the floor can give.
    pub(crate) fn used(&self) -> f32 {
        let [used, limit] = [|touch: &Touch| touch.force.yz().norm(), |touch: &Touch| touch.limit]
            .map(|part| self.touches.iter().map(part).sum::<f32>());
        used / limit
    }

    /// Returns whether a foot is on the ice.
    pub(crate) fn is_on_ice(&self) -> bool {
        self.feet.iter().any(|foot| foot.x > EDGE)
    }
}

/// Tells the story, with the catch or without.
pub(crate) fn tell(catches: bool) -> Result<Vec<Tick>, Error> {
    let (mut plant, mut controller) = (Plant::new(stance(0.0)), Controller::new(catches));
    let mut ticks = Vec::new();
    for tick in 0..TICKS {
        let sensors = plant.sense();
        let (start, lean) = (Instant::now(), controller.lean);
        let torques = controller.tick(&sensors)?;
        let time = start.elapsed().as_secs_f32() * 1e6;
        plant.tick(&torques, if PUSH.contains(&tick) { FORCE } else { 0.0 })?;
        let leans = (controller.lean - lean).abs() > 1e-5;
        ticks.push(Tick { touches: plant.touches, torso: plant.place, feet: plant.feet(), speed: plant.speed(), leans, time });
    }
    Ok(ticks)
}
