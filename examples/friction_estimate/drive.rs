//! A skid that is pulled from concrete onto ice, and the estimator that watches it through a noisy sensor.

use crate::estimator::{Estimator, Skid};
use core::fmt;
use nalgebra::Vector3;
use stiction::Error;

/// Coefficients of the two floors, and the step at which the second begins.
const FLOORS: [f32; 2] = [0.6, 0.25];
const ICE: u32 = 200;
pub(crate) const STEPS: u32 = 400;

pub(crate) struct Drive {
    skid: Skid,
    pub(crate) estimator: Estimator,
    velocity: Vector3<f32>,
    measured: Vector3<f32>,
    step: u32,
    random: u32,
}

/// What is known after some steps.
pub(crate) struct Line {
    step: u32,
    pub(crate) truth: f32,
    pub(crate) estimate: f32,
    speed: f32,
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { step, truth, estimate, speed } = self;
        write!(f, "step {step:3}: {speed:5.2} m/s, friction {truth:.2}, estimated {estimate:.3}")
    }
}

impl Drive {
    pub(crate) const fn new() -> Self {
        Self {
            skid: Skid::new(),
            estimator: Estimator::new(0.4),
            velocity: Vector3::new(0.0, 0.0, 0.0),
            measured: Vector3::new(0.0, 0.0, 0.0),
            step: 0,
            random: 1,
        }
    }

    pub(crate) fn begin(&mut self) -> Result<(), Error> {
        self.skid.place()?;
        self.estimator.place()
    }

    /// An error of the sensor (m/s): nearly normal, with a deviation of 2 mm/s.
    fn noise(&mut self) -> f32 {
        let mut sum = -2.0;
        for _ in 0..4 {
            self.random = self.random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            sum += f32::from((self.random >> 16) as u16) / 65_536.0;
        }
        sum * 2e-3 * 1.732
    }

    /// Goes on for some steps.
    pub(crate) fn go_on(&mut self, steps: u32) -> Result<Line, Error> {
        let mut truth = 0.0;
        for _ in 0..steps {
            // Tugs of a second: 15 N for six tenths of it, so that the skid comes to rest between them, or nearly.
            let pulls = self.step % 200 < 120;
            let pull = if pulls { [15.0, 2.0] } else { [0.0, 0.0] };
            truth = if self.step < ICE { FLOORS[0] } else { FLOORS[1] };
            self.velocity = self.skid.step(truth, &self.velocity, pull)?;
            let before = self.measured;
            self.measured = self.velocity + Vector3::new(self.noise(), self.noise(), 0.0);
            self.estimator.learn(&before, &self.measured, pull)?;
            self.step += 1;
        }
        let (estimate, speed) = (self.estimator.mu, self.velocity.norm());
        Ok(Line { step: self.step, truth, estimate, speed })
    }
}
