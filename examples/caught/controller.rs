//! The controller: it stands, and when feet slip it leans over those that hold. It knows neither floor nor push.
//!
//! In each tick it asks the kernel with which impulses the floor would push the feet in the next 10 ms if the joints held their angles.
//! The answer holds a mode for each foot, and impulses within the friction that the controller counts on. It uses both:
//!
//! 1. **Learn.** A foot that slips shows its friction coefficient: the ratio of friction to normal force in its load cell.
//! 2. **Lean.** The torso moves over the centre of friction, the mean of the feet weighted by their coefficients: where a foot
//!    holds better, more weight gives more friction. This is what catches the robot.
//! 3. **Share out.** The motors bear the impulses. The next ones are within what was learnt, so feet that hold take over: in the end
//!    87 % of the friction is used, 91 % if the kernel goes on with the first coefficient.

use crate::dynamics::{Dynamics, N};
use crate::plant::{Sensors, TICK, Torques, weight};
use nalgebra::{SVector, Vector3};
use stiction::time_stepping::free_impulse;
use stiction::{ContactMode, Error, Kernel, Settings, Solution};

/// Time step of the prediction (s).
const HORIZON: f32 = 0.01;
/// Inertia (kg m²) that the prediction adds to each joint, so that it holds its angle.
const SERVO: f32 = 0.3;
/// Friction coefficient that the controller counts on until a foot shows another.
const FRICTION: f32 = 0.5;
/// Share of a coefficient that the controller uses: what a foot showed may be too much a step further.
const TRUST: f32 = 0.8;
/// Speed of a foot that slides beyond doubt (m/s).
const SLIDING: f32 = 0.01;
/// Error of a solution that is good enough.
const ENOUGH: f32 = 1e-2;
/// Normal force of a foot that touches the floor (N).
const TOUCH: f32 = 1.0;
/// Speed of the torso when it leans (m/s).
const LEAN: f32 = 0.3;
/// Height of the thigh's hinge above the foot (m), and length of thigh and of calf (m).
const HEIGHT: f32 = 0.22;
const LENGTH: f32 = 0.16;
/// Gains of each joint: of the angle (N·m/rad), of the rate (N·m·s/rad). Largest torque (N·m).
const GAINS: [f32; 2] = [60.0, 1.0];
const LIMIT: f32 = 12.0;

/// Controller of the quadruped.
pub(crate) struct Controller {
    /// Whether it does something about slip: learns and leans.
    catches: bool,
    /// Friction coefficient of each foot, as far as it is known.
    friction: [f32; 4],
    /// Place of the torso from the middle of the feet (m), downhill.
    pub(crate) lean: f32,
    /// Torques of the last tick.
    torques: Torques,
    dynamics: Dynamics,
    kernel: Kernel<f32, N, 3, 4>,
}

impl Controller {
    pub(crate) fn new(catches: bool) -> Self {
        let (dynamics, kernel) = (Dynamics::new(), Kernel::new());
        Self { catches, friction: [FRICTION; 4], lean: 0.0, torques: Torques::default(), dynamics, kernel }
    }

    /// Does the work of a tick: from sensors to torques.
    pub(crate) fn tick(&mut self, sensors: &Sensors) -> Result<Torques, Error> {
        self.dynamics.update(&sensors.state);
        let free_impulse = self.fill(sensors)?;
        let solution = self.kernel.solve(&free_impulse, &Settings::new(1e-3))?;
        if !solution.is_usable(ENOUGH) {
            return Ok(self.torques); // `robot_firmware` also stops when they are too old
        }
        let mut torques = feed_forward(&self.dynamics, solution);
        if self.catches {
            learn(&mut self.friction, &self.dynamics, sensors, solution);
            self.lean += (self.centre() - self.lean).clamp(-LEAN * TICK, LEAN * TICK);
        }
        let joints = sensors.state.angles.as_flattened().iter().zip(&sensors.state.velocity.as_slice()[6..]);
        let targets = stance(self.lean);
        for ((torque, (angle, rate)), target) in
            torques.as_flattened_mut().iter_mut().zip(joints).zip(targets.as_flattened())
        {
            *torque += GAINS[0] * (target - angle) - GAINS[1] * rate;
            *torque = torque.clamp(-LIMIT, LIMIT);
        }
        self.torques = torques;
        Ok(torques)
    }

    /// Returns the place of the centre of friction from the middle of the feet (m), downhill.
    fn centre(&self) -> f32 {
        let places = self.dynamics.feet.map(|foot| foot.point.x);
        let weighted = places.iter().zip(self.friction).map(|(place, mu)| place * mu).sum::<f32>();
        weighted / self.friction.iter().sum::<f32>() - places.iter().sum::<f32>() / 4.0
    }

    /// Fills the scene with the feet that touch, and returns the free impulse (N·s).
    fn fill(&mut self, sensors: &Sensors) -> Result<SVector<f32, N>, Error> {
        let force = weight(&self.dynamics);
        let mass = &mut self.dynamics.mass;
        let free_impulse = free_impulse(mass, &sensors.state.velocity, &force, HORIZON);
        for joint in 6..N {
            mass[(joint, joint)] += SERVO;
        }
        let scene = self.kernel.scene_mut();
        scene.clear();
        scene.set_mass(mass)?;
        for (key, foot) in (0..).zip(&self.dynamics.feet) {
            if sensors.forces[key as usize][0] > TOUCH {
                scene.push(&foot.contact(0.0, TRUST * self.friction[key as usize], key))?;
            }
        }
        Ok(free_impulse)
    }
}

/// Learns the coefficients of the feet that slip.
fn learn(friction: &mut [f32; 4], dynamics: &Dynamics, sensors: &Sensors, solution: &Solution<f32, N, 3, 4>) {
    for contact in solution.contacts.iter().filter(|contact| contact.mode == ContactMode::Slip) {
        let foot = contact.key as usize;
        let jacobian = dynamics.feet[foot].contact(0.0, 0.0, contact.key).jacobian;
        let [[_, ahead, left]] = (jacobian * sensors.state.velocity).data.0;
        if ahead.hypot(left) > SLIDING {
            let [[normal, ahead, left]] = sensors.forces[foot].data.0;
            friction[foot] = ahead.hypot(left) / normal;
        }
    }
}

/// Returns torques that bear the weight of the legs and the forces `r / h` of the feet.
fn feed_forward(dynamics: &Dynamics, solution: &Solution<f32, N, 3, 4>) -> Torques {
    let mut torques = Torques::default();
    for (torque, force) in torques.as_flattened_mut().iter_mut().zip(weight(dynamics).iter().skip(6)) {
        *torque = -force;
    }
    for contact in &solution.contacts {
        let ([[up, ahead, left]], leg) = (contact.impulse.data.0, contact.key as usize);
        let force = Vector3::new(ahead, left, up) / HORIZON;
        torques[leg] = (Vector3::from(torques[leg]) - dynamics.feet[leg].jacobian.tr_mul(&force)).into();
    }
    torques
}

/// Returns the angles (rad) of hip, thigh and calf of each leg when the torso is so far downhill of the middle of the feet (m).
pub(crate) fn stance(lean: f32) -> [[f32; 3]; 4] {
    let bend = (lean.hypot(HEIGHT) / (2.0 * LENGTH)).acos();
    [[0.0, lean.atan2(HEIGHT) + bend, -2.0 * bend]; 4]
}
