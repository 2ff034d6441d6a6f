//! A simulated robot in place of a real one: the same dynamics, and the same crate for its contacts. A controller that runs against its own
//! model shows that the loop closes and what it costs. It does not show that the model is right.

use crate::controller::{STANCE, Sensors, Torques};
use crate::dynamics::{Dynamics, N, State};
use nalgebra::{ArrayStorage, Quaternion, SVector, UnitQuaternion, Vector3};
use stiction::time_stepping::{Gap, free_impulse};
use stiction::{ContactMode, Error, Kernel, Settings};

/// Length of a time step, and of a tick of the controller (s).
const STEP: f32 = 1e-3;
/// Friction coefficient of the ground.
const MU: f32 = 0.7;
/// Height of the torso at the beginning (m): the feet are 3 cm above the ground.
const HEIGHT: f32 = 0.282;
/// Distance below which a foot is a contact of the scene (m).
const NEAR: f32 = 0.02;

/// Simulated robot.
pub(crate) struct Plant {
    /// Place of the torso (m).
    pub(crate) place: Vector3<f32>,
    state: State,
    switches: [bool; 4],
    dynamics: Dynamics,
    kernel: Kernel<f32, N, 3, 4>,
}

impl Plant {
    /// Makes a robot at rest above the ground.
    pub(crate) const fn new() -> Self {
        Self {
            place: Vector3::new(0.0, 0.0, HEIGHT),
            state: State {
                turn: UnitQuaternion::new_unchecked(Quaternion::new(1.0, 0.0, 0.0, 0.0)),
                angles: [STANCE; 4],
                velocity: SVector::from_array_storage(ArrayStorage([[0.0; N]; 1])),
            },
            switches: [false; 4],
            dynamics: Dynamics::new(),
            kernel: Kernel::new(),
        }
    }

    /// Returns what sensors without faults tell.
    pub(crate) fn sense(&self) -> Sensors {
        let State { turn, angles, velocity } = self.state;
        let [[a, b, c, x, y, z, joints @ ..]] = velocity.data.0;
        let mut rates = [[0.0; 3]; 4];
        for (rate, &joint) in rates.as_flattened_mut().iter_mut().zip(&joints) {
            *rate = joint;
        }
        Sensors {
            angles,
            rates,
            turn,
            gyro: turn.inverse() * Vector3::new(a, b, c),
            velocity: Vector3::new(x, y, z),
            switches: self.switches,
        }
    }

    /// Moves the robot by a time step, with torques and a force on the torso (N).
    pub(crate) fn step(&mut self, torques: &Torques, push: &Vector3<f32>) -> Result<(), Error> {
        self.dynamics.update(&self.state);
        let mut force = -self.dynamics.bias;
        let applied = [&[0.0; 3], &push.data.0[0]].into_iter().chain(torques);
        for (force, applied) in force.iter_mut().zip(applied.flatten()) {
            *force += applied;
        }
        let scene = self.kernel.scene_mut();
        scene.clear();
        scene.set_mass(&self.dynamics.mass)?;
        for (key, foot) in (0..).zip(&self.dynamics.feet) {
            let distance = self.place.z + foot.point.z;
            let gap = Gap { distance, recovery: 0.1, reach: 10.0 };
            if distance < NEAR {
                scene.push(&foot.contact(gap.offset(STEP)?, MU, key))?;
            }
        }
        let impulse = free_impulse(&self.dynamics.mass, &self.state.velocity, &force, STEP);
        let solution = self.kernel.solve(&impulse, &Settings::new(1e-4))?;

        let State { turn, angles, velocity } = &mut self.state;
        *velocity = solution.velocity;
        let [[a, b, c, x, y, z, rates @ ..]] = velocity.data.0;
        self.place += Vector3::new(x, y, z) * STEP;
        let spin = Quaternion::new(0.0, a, b, c) * turn.into_inner() * (STEP / 2.0);
        *turn = UnitQuaternion::new_normalize(turn.into_inner() + spin);
        for (angle, rate) in angles.as_flattened_mut().iter_mut().zip(rates) {
            *angle += rate * STEP;
        }
        for (key, switch) in (0..).zip(&mut self.switches) {
            let contact = solution.contact_by_key(key);
            *switch = contact.is_some_and(|contact| contact.mode != ContactMode::Open);
        }
        Ok(())
    }
}
