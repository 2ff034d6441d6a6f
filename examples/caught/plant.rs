//! The plant: a simulated quadruped on a ramp whose lower part is ice. Its world axes lie along the ramp: x points downhill.

use crate::dynamics::{Dynamics, N, State};
use crate::model::{GRAVITY, LEGS, LINKS};
use nalgebra::{Quaternion, SVector, UnitQuaternion, Vector3};
use stiction::time_stepping::{Gap, free_impulse};
use stiction::{ContactMode, Error, Kernel, Settings};

/// Slope of the ramp (rad): 16 degrees. The controller has it from its inertial unit.
pub(crate) const SLOPE: f32 = 0.28;
/// Friction coefficients of the rough part of the ramp, and of the ice.
const ROUGH: f32 = 0.5;
const ICE: f32 = 0.1;
/// Place on the middle line at which the ice begins (m): ahead of the front feet. Its edge is oblique: at the left it begins sooner.
pub(crate) const EDGE: f32 = 0.185;
const OBLIQUE: f32 = 0.1;
/// Length of a tick of the controller, and of a time step of the plant (s).
pub(crate) const TICK: f32 = 1e-3;
const STEP: f32 = TICK / 2.0;

/// Torques (N·m) of hip, thigh and calf of each leg.
pub(crate) type Torques = [[f32; 3]; 4];

/// Readings of the sensors.
pub(crate) struct Sensors {
    /// State by encoders, inertial unit and an estimator.
    pub(crate) state: State,
    /// Forces on the feet by load cells (N): upwards, downhill and to the left.
    pub(crate) forces: [Vector3<f32>; 4],
}

/// Foot on the floor, as nobody but the plant knows it.
#[derive(Clone, Copy)]
pub(crate) struct Touch {
    /// Open, stick or slip.
    pub(crate) mode: ContactMode,
    /// Force of the floor (N): upwards, downhill and to the left.
    pub(crate) force: Vector3<f32>,
    /// Largest friction force (N): the coefficient times the normal force.
    pub(crate) limit: f32,
}

/// Simulated robot.
pub(crate) struct Plant {
    /// Place of the torso (m).
    pub(crate) place: Vector3<f32>,
    pub(crate) state: State,
    pub(crate) touches: [Touch; 4],
    dynamics: Dynamics,
    kernel: Kernel<f32, N, 3, 4>,
}

impl Plant {
    /// Makes a robot at rest, with its feet on the floor.
    pub(crate) fn new(angles: [[f32; 3]; 4]) -> Self {
        let state = State { turn: UnitQuaternion::identity(), angles, velocity: SVector::zeros() };
        let mut dynamics = Dynamics::new();
        dynamics.update(&state);
        let place = Vector3::new(0.0, 0.0, -dynamics.feet[0].point.z);
        let touch = Touch { mode: ContactMode::Open, force: Vector3::zeros(), limit: 0.0 };
        Self { place, state, touches: [touch; 4], dynamics, kernel: Kernel::new() }
    }

    /// Returns what the sensors tell.
    pub(crate) fn sense(&self) -> Sensors {
        Sensors { state: self.state, forces: self.touches.map(|touch| touch.force) }
    }

    /// Returns the places of thigh hinge, knee and foot of each leg (m).
    pub(crate) fn legs(&self) -> [[Vector3<f32>; 3]; 4] {
        let turned = |axis, angle| UnitQuaternion::from_axis_angle(&axis, angle);
        let legs = LEGS.iter().zip(&self.state.angles).zip(&self.dynamics.feet);
        let mut places = [[Vector3::zeros(); 3]; 4];
        for (((signs, [hip, thigh, _]), foot), places) in legs.zip(&mut places) {
            let signs = Vector3::new(signs[0], signs[1], 1.0);
            let [first, second, third] =
                LINKS.each_ref().map(|link| Vector3::from(link.hinge).component_mul(&signs));
            let hip = self.state.turn * turned(Vector3::x_axis(), *hip);
            let hinge = self.place + self.state.turn * first + hip * second;
            let knee = hinge + hip * turned(Vector3::y_axis(), *thigh) * third;
            *places = [hinge, knee, self.place + foot.point];
        }
        places
    }

    /// Returns the speed of the torso (m/s).
    pub(crate) fn speed(&self) -> f32 {
        self.state.velocity.fixed_rows::<3>(3).norm()
    }

    /// Moves the robot by a tick, with torques and a push on the torso downhill (N).
    pub(crate) fn tick(&mut self, torques: &Torques, push: f32) -> Result<(), Error> {
        self.step(torques, push)?;
        self.step(torques, push)
    }

    fn step(&mut self, torques: &Torques, push: f32) -> Result<(), Error> {
        self.dynamics.update(&self.state);
        let mut force = weight(&self.dynamics);
        force[3] += push;
        for (force, torque) in force.iter_mut().skip(6).zip(torques.as_flattened()) {
            *force += torque;
        }
        let scene = self.kernel.scene_mut();
        scene.clear();
        scene.set_mass(&self.dynamics.mass)?;
        let mut coefficients = [0.0; 4];
        for ((key, foot), mu) in (0..).zip(&self.dynamics.feet).zip(&mut coefficients) {
            let point = self.place + foot.point;
            *mu = friction(&point);
            let gap = Gap { distance: point.z, recovery: 0.1, reach: 10.0 };
            scene.push(&foot.contact(gap.offset(STEP)?, *mu, key))?;
        }
        let impulse = free_impulse(&self.dynamics.mass, &self.state.velocity, &force, STEP);
        let solution = self.kernel.solve(&impulse, &Settings::new(1e-4))?;
        assert!(solution.is_solved(), "the plant is not physics: {}", solution.status);

        for ((contact, mu), touch) in solution.contacts.iter().zip(coefficients).zip(&mut self.touches) {
            let force = contact.impulse / STEP;
            *touch = Touch { mode: contact.mode, force, limit: mu * force[0] };
        }
        let State { turn, angles, velocity } = &mut self.state;
        *velocity = solution.velocity;
        let [[a, b, c, x, y, z, rates @ ..]] = velocity.data.0;
        self.place += Vector3::new(x, y, z) * STEP;
        let spin = Quaternion::new(0.0, a, b, c) * turn.into_inner() * (STEP / 2.0);
        *turn = UnitQuaternion::new_normalize(turn.into_inner() + spin);
        for (angle, rate) in angles.as_flattened_mut().iter_mut().zip(rates) {
            *angle += rate * STEP;
        }
        Ok(())
    }
}

/// Returns the friction coefficient of the floor at a place.
pub(crate) fn friction(place: &Vector3<f32>) -> f32 {
    if place.x + OBLIQUE * place.y < EDGE { ROUGH } else { ICE }
}

/// Returns the forces (N·m, N) of weight and motion on the ramp. `Dynamics` knows level ground: there the negative bias. The ramp turns
/// the acceleration by weight, from straight down to partly ahead, and `M` times this difference is a force.
pub(crate) fn weight(dynamics: &Dynamics) -> SVector<f32, N> {
    let (sin, cos) = SLOPE.sin_cos();
    let [ahead, up] = [3, 5].map(|axis| dynamics.mass.column(axis));
    ahead * (GRAVITY * sin) + up * (GRAVITY * (1.0 - cos)) - dynamics.bias
}
