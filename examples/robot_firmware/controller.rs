//! The controller of the robot: from encoder angles to the torques of the joints, once a tick.

use crate::dynamics::{Dynamics, N, State};
use core::fmt;
use nalgebra::{Matrix3, SVector, UnitQuaternion, Vector3};
use stiction::heapless::Vec;
use stiction::time_stepping::free_impulse;
use stiction::{ContactMode, Error, Kernel, Settings, Status, SweepsOnly};

/// Time step of the prediction (s).
const HORIZON: f32 = 0.02;
/// Inertia (kg m²) that the prediction adds to each joint, so that it holds its angle: several times what the torso has about a knee.
const SERVO: f32 = 0.3;
/// Friction coefficient that the controller counts on.
const MU: f32 = 0.5;
/// The kernel of the controller. Few sweeps are enough for four feet, and their time is bounded best.
type Feet = Kernel<f32, N, 3, 4, 0, 0, SweepsOnly>;
/// Budget of a solve that takes at most 850 of the 1,000 µs of a tick, whatever the sensors say, of a core of 480 MHz without wait states.
const BUDGET: usize = Feet::budget_within(850, 480, 0);
const _: () = assert!(BUDGET > 0, "no budget fits into the tick");
/// The tolerance of a solve is a thousandth of the impulses.
const SETTINGS: Settings<f32> = Settings { budget: BUDGET, ..Settings::new(1e-3) };
/// Error of impulses that are good enough, if the budget ends before they are solved.
const ENOUGH: f32 = 1e-2;
/// Largest plausible impulse of a foot (N·s): it stops the whole robot, 6.4 kg, at 3 m/s. More comes from a sensor that tells garbage.
const PLAUSIBLE: f32 = 6.4 * 3.0;
/// Ticks for which the last good impulses are held. Then the robot stops.
const AGE_LIMIT: u32 = 20;

/// Angles of hip, thigh and calf (rad) of a robot that stands.
pub(crate) const STANCE: [f32; 3] = [0.0, 0.75, -1.5];
/// Gains of each joint: of the angle (N·m/rad), of the rate (N·m·s/rad).
const GAINS: [f32; 2] = [40.0, 1.0];
/// Gain of the rate (N·m·s/rad) after a stop.
const BRAKE: f32 = 2.0;
/// Largest torques of hip, thigh and calf (N·m).
const LIMITS: [f32; 3] = [10.0, 10.0, 12.0];

/// Torques (N·m) of hip, thigh and calf of each leg.
pub(crate) type Torques = [[f32; 3]; 4];

/// Readings of the sensors in a tick.
#[derive(Clone, Copy)]
pub(crate) struct Sensors {
    /// Angles (rad) of the encoders, and their rates (rad/s): hip, thigh and calf of each leg.
    pub(crate) angles: [[f32; 3]; 4],
    pub(crate) rates: [[f32; 3]; 4],
    /// Orientation by the inertial unit, and its angular velocity (rad/s) in the axes of the torso.
    pub(crate) turn: UnitQuaternion<f32>,
    pub(crate) gyro: Vector3<f32>,
    /// Estimate of the velocity of the torso (m/s), in world axes.
    pub(crate) velocity: Vector3<f32>,
    /// Whether the switch of each foot is closed: it touches the ground.
    pub(crate) switches: [bool; 4],
}

impl Sensors {
    /// Returns the state that they tell.
    pub(crate) fn state(&self) -> State {
        let torso = [self.turn * self.gyro, self.velocity];
        let numbers = torso.iter().flatten().chain(self.rates.iter().flatten());
        let mut velocity = SVector::<f32, N>::zeros();
        for (entry, &number) in velocity.iter_mut().zip(numbers) {
            *entry = number;
        }
        let (turn, angles) = (self.turn, self.angles);
        State { turn, angles, velocity }
    }
}

/// Stage of a tick.
#[derive(Clone, Copy)]
pub(crate) enum Stage {
    Dynamics,
    Fill,
    Solve,
    Torques,
}

/// Clock of 1 kHz, which also takes the time of each stage. `()` is one that does neither.
pub(crate) trait Clock {
    /// Returns when the next tick begins.
    fn wait(&mut self);
    /// Notes that a stage is over. In a tick with a fault stages are missing: their time is the next one's.
    fn end(&mut self, stage: Stage);
}

impl Clock for () {
    fn wait(&mut self) {}

    fn end(&mut self, _: Stage) {}
}

/// Reason why a tick has no impulses of its own.
pub(crate) enum Fault {
    /// The kernel refuses the data.
    Data(Error),
    /// The solve ended without a usable solution.
    Solve(Status),
    /// An impulse is larger than any that there can be.
    Implausible,
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        Self::Data(error)
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Data(error) => error.fmt(out),
            Self::Solve(status) => status.fmt(out),
            Self::Implausible => out.write_str("an impulse is implausible"),
        }
    }
}

/// Last good impulse of a foot.
#[derive(Clone, Copy)]
pub(crate) struct Push {
    /// Number of the foot, which is the key of its contact.
    pub(crate) key: u32,
    /// Open, stick or slip.
    pub(crate) mode: ContactMode,
    /// Impulse of the ground on the foot over the horizon (N·s), in world axes.
    impulse: Vector3<f32>,
    /// Jacobian of the foot (m) at that time, by which the impulse acts on the joints of the leg.
    jacobian: Matrix3<f32>,
}

/// Controller. A new one is all zeros, and takes no flash.
pub(crate) struct Controller {
    dynamics: Dynamics,
    kernel: Feet,
    /// Last good impulses. A foot that is not among them was in the air.
    pub(crate) held: Vec<Push, 4>,
    /// Bias (N·m, N) of the tick that they are of.
    bias: SVector<f32, N>,
    /// Age of the impulses: ticks since the last good solution.
    pub(crate) age: u32,
}

impl Controller {
    pub(crate) const fn new() -> Self {
        let dynamics = Dynamics::new();
        Self {
            bias: dynamics.bias,
            dynamics,
            kernel: Feet::with_phases(SweepsOnly),
            held: Vec::new(),
            age: 0,
        }
    }

    /// Returns whether the impulses are too old. Then the robot has stopped, until somebody starts it again.
    pub(crate) const fn has_stopped(&self) -> bool {
        self.age > AGE_LIMIT
    }

    /// Does the work of a tick. Returns the torques, and a fault if the impulses are those of an earlier tick.
    pub(crate) fn tick(&mut self, sensors: &Sensors, clock: &mut impl Clock) -> (Torques, Option<Fault>) {
        let mut fault = None;
        if !self.has_stopped() {
            fault = self.predict(sensors, clock).err();
            self.age = if fault.is_some() { self.age + 1 } else { 0 };
        }
        let torques = if self.has_stopped() { brake(sensors) } else { self.torques(sensors) };
        clock.end(Stage::Torques);
        (torques, fault)
    }

    /// Predicts the impulses of the feet over the horizon. After a fault the last good ones stay.
    fn predict(&mut self, sensors: &Sensors, clock: &mut impl Clock) -> Result<(), Fault> {
        let state = sensors.state();
        self.dynamics.update(&state);
        clock.end(Stage::Dynamics);
        let free_impulse = self.fill(&state, sensors.switches)?;
        clock.end(Stage::Fill);
        let solution = self.kernel.solve(&free_impulse, &SETTINGS)?;
        clock.end(Stage::Solve);
        if !solution.is_usable(ENOUGH) {
            return Err(Fault::Solve(solution.status));
        }
        let pushes = solution.contacts.iter().map(|contact| contact.impulse[0]);
        if pushes.fold(0.0, f32::max) > PLAUSIBLE {
            return Err(Fault::Implausible);
        }
        self.bias = self.dynamics.bias;
        self.held.clear();
        let feet = (0..).zip(&self.dynamics.feet);
        for (key, foot) in feet {
            if let Some(contact) = solution.contact_by_key(key) {
                let [[normal, x, y]] = contact.impulse.data.0;
                let _ = self.held.push(Push {
                    key,
                    mode: contact.mode,
                    impulse: Vector3::new(x, y, normal),
                    jacobian: foot.jacobian,
                }); // there is room
            }
        }
        Ok(())
    }

    /// Fills the scene, and returns the free impulse (N·s). After an error the scene is incomplete, and no solve takes it: the
    /// next tick fills it anew.
    fn fill(&mut self, state: &State, switches: [bool; 4]) -> Result<SVector<f32, N>, Error> {
        let Dynamics { mass, bias, feet } = &mut self.dynamics;
        let free_impulse = free_impulse(mass, &state.velocity, &-*bias, HORIZON);
        for (joint, column) in mass.data.0.iter_mut().enumerate().skip(6) {
            if let Some(inertia) = column.get_mut(joint) {
                *inertia += SERVO;
            }
        }
        let scene = self.kernel.scene_mut();
        scene.clear();
        scene.set_mass(mass)?;
        for ((key, foot), is_closed) in (0..).zip(feet).zip(switches) {
            if is_closed {
                scene.push(&foot.contact(0.0, MU, key))?;
            }
        }
        Ok(free_impulse)
    }

    /// Returns torques that bear the forces of the feet, and bring the joints to the stance.
    fn torques(&self, sensors: &Sensors) -> Torques {
        let mut torques = self.feed_forward();
        let [angles, rates] = [&sensors.angles, &sensors.rates].map(|legs| legs.as_flattened());
        let joints = torques.as_flattened_mut().iter_mut().zip(angles).zip(rates);
        let wanted = STANCE.iter().zip(LIMITS).cycle();
        for (((torque, angle), rate), (target, limit)) in joints.zip(wanted) {
            let feedback = GAINS[0] * (target - angle) - GAINS[1] * rate;
            *torque = limited(*torque + or_zero(feedback), limit);
        }
        torques
    }

    /// Returns torques that bear the weight of the legs and the forces of the feet: bias minus `Jᵀ r / h`. The ground pushes the foot
    /// with `r / h`, and the motors hold against that.
    fn feed_forward(&self) -> Torques {
        let [[_, _, _, _, _, _, bias @ ..]] = &self.bias.data.0;
        let mut torques = Torques::default();
        for (torque, &bias) in torques.as_flattened_mut().iter_mut().zip(bias) {
            *torque = bias;
        }
        for push in &self.held {
            if let Some(leg) = torques.get_mut(push.key as usize) {
                let force = push.impulse / HORIZON;
                *leg = (Vector3::from(*leg) - push.jacobian.tr_mul(&force)).into();
            }
        }
        torques
    }
}

/// Returns torques that only damp.
fn brake(sensors: &Sensors) -> Torques {
    let torque = |rate| limited(or_zero(-BRAKE * rate), LIMITS[0]);
    sensors.rates.map(|leg| leg.map(torque))
}

/// Returns the torque, or the limit that it exceeds. (`f32::clamp` panics if its limits are in the wrong order.)
const fn limited(torque: f32, limit: f32) -> f32 {
    if torque > limit {
        limit
    } else if torque < -limit {
        -limit
    } else {
        torque
    }
}

/// Returns the number, or 0 if it is not finite: of a joint whose encoder is broken there is no feedback.
const fn or_zero(number: f32) -> f32 {
    if number.is_finite() { number } else { 0.0 }
}
