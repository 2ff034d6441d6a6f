//! A friction coefficient that follows measured velocities, step by step, in f32 and without allocation.
//!
//! A Kalman filter of one number: the solve predicts the velocity at the end of a step, its derivative says how that moves with the
//! coefficient, and what was measured corrects it. While the contact sticks or is open the derivative is 0, and nothing is learned.

use nalgebra::{Matrix3, Vector3};
use stiction::time_stepping::free_impulse;
use stiction::{Contact, Error, Inputs, Kernel, Settings};

type Vector = Vector3<f32>;

/// h (s)
const STEP: f32 = 5e-3;
const MASS: f32 = 2.0; // kg
const WEIGHT: f32 = MASS * 9.81; // N
const SETTINGS: Settings<f32> = Settings::new(1e-5);
/// Squares of what a velocity sensor errs by (m/s), twice, as predictions start from measured velocities; and of how much the floor
/// changes in a step.
const NOISE: f32 = 2.0 * 2e-3 * 2e-3;
const DRIFT: f32 = 1e-2 * 1e-2;

/// A skid that is pulled over a floor: three velocities, one contact.
pub(crate) struct Skid(Kernel<f32, 3, 3, 1>);

impl Skid {
    pub(crate) const fn new() -> Self {
        Self(Kernel::new())
    }

    /// Puts it on the floor.
    pub(crate) fn place(&mut self) -> Result<(), Error> {
        let scene = self.0.scene_mut();
        scene.set_mass(&(Matrix3::identity() * MASS))?;
        let jacobian = Matrix3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
        let (offset, mu, key) = (Vector::zeros(), 0.5, 0);
        scene.push(&Contact { jacobian, offset, mu, key })?;
        Ok(())
    }

    /// The velocity a step later, with this friction and pulled by this force along the floor.
    pub(crate) fn step(&mut self, mu: f32, velocity: &Vector, pull: [f32; 2]) -> Result<Vector, Error> {
        let [x, y] = pull;
        self.0.scene_mut().set_friction(0, mu)?;
        let mass = *self.0.scene().mass();
        let push = free_impulse(&mass, velocity, &Vector::new(x, y, -WEIGHT), STEP);
        Ok(self.0.solve(&push, &SETTINGS)?.velocity)
    }
}

/// What is known of the friction.
pub(crate) struct Estimator {
    skid: Skid,
    pub(crate) mu: f32,
    variance: f32,
}

impl Estimator {
    pub(crate) const fn new(mu: f32) -> Self {
        let skid = Skid::new();
        Self { skid, mu, variance: 0.1 }
    }

    pub(crate) fn place(&mut self) -> Result<(), Error> {
        self.skid.place()
    }

    /// Learns from the velocities measured before and after a step in which the skid was pulled.
    pub(crate) fn learn(&mut self, before: &Vector, after: &Vector, pull: [f32; 2]) -> Result<(), Error> {
        let predicted = self.skid.step(self.mu, before, pull)?;
        let mut change = Inputs::zero();
        change.friction = [1.0];
        let slope = self.skid.0.derivative(&SETTINGS)?.forward(&change).velocity;
        self.variance += DRIFT;
        let gain = slope * (self.variance / (NOISE + self.variance * slope.norm_squared()));
        self.mu = (self.mu + gain.dot(&(after - predicted))).max(0.0);
        self.variance *= 1.0 - gain.dot(&slope);
        Ok(())
    }
}
