//! Rolling resistance of a driven wheel: on its axle it rolls, in its contact it creeps.

use crate::support::boxes::GRAVITY;
use nalgebra::{SMatrix, SVector, vector};
use stiction::time_stepping::{DryFriction, Motor};
use stiction::{Contact, ContactMode, Error, Kernel, Settings, Surface};
use testbed::rolling;

const STEP: f64 = 1e-3;
const MASS: f64 = 8.0;
const RADIUS: f64 = 0.1;
const MU: f64 = 0.8;
/// Coefficient of rolling resistance (m): its torque over the normal force.
const ROLL: f64 = 0.01;
/// Gain of the motor (N·m·s/rad), and its target (rad/s).
const GAIN: f64 = 100.0;
const TARGET: f64 = 5.0;

/// Forces of the weight on a slope of ten degrees (N): along it, and onto it.
fn weight() -> [f64; 2] {
    let slope = 10_f64.to_radians();
    [slope.sin(), slope.cos()].map(|share| MASS * GRAVITY * share)
}

/// A wheel after a second in which its motor drives it up the slope.
struct Wheel {
    /// Turns (rad/s).
    turns: f64,
    /// Velocity of its contact over the ground (m/s).
    creeps: f64,
    mode: ContactMode,
    /// Torque of the motor (N·m).
    torque: f64,
}

/// Drives a wheel whose contact has `D` rows, with the Jacobian `x, y, z` and rotations about them, and dry friction of a torque
/// on its axle.
fn drive<const D: usize>(surface: &Surface<f64>, axle: f64) -> Result<Wheel, Error> {
    let moment = 0.5 * MASS * RADIUS * RADIUS;
    let mass = SMatrix::<f64, 6, 6>::from_diagonal(&vector![MASS, MASS, MASS, moment, moment, moment]);
    let jacobian = rolling::jacobian::<D>(RADIUS);
    let mut kernel = Kernel::<f64, 6, D, 4, 6, 4>::new();
    let scene = kernel.scene_mut();
    scene.set_mass(&mass)?;
    let offset = SVector::zeros();
    let (mu, key) = (MU, 0);
    scene.push_on(&Contact { jacobian, offset, mu, key }, surface)?;
    let spin = vector![0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let motor = Motor { damping: GAIN, target: TARGET, limit: 10.0, ..Motor::default() };
    scene.push_row(&motor.row(spin, STEP, 0)?)?;
    scene.push_row(&DryFriction { torque: axle }.row(spin, STEP, 1)?)?;
    let [along, onto] = weight();
    let force = vector![-along, 0.0, -onto, 0.0, 0.0, 0.0];
    let mut velocity = SVector::zeros();
    for _ in 0..1_000 {
        let push = mass * velocity + force * STEP;
        let solution = kernel.solve(&push, &Settings::new(1e-12))?;
        assert!(solution.is_solved());
        velocity = solution.velocity;
    }
    let solution = kernel.solution();
    Ok(Wheel {
        turns: velocity[4],
        creeps: velocity[0] - RADIUS * velocity[4],
        mode: solution.contacts[0].mode,
        torque: solution.rows[0].impulse / STEP,
    })
}

#[test]
fn a_wheel_with_dry_friction_on_its_axle_rolls() -> Result<(), Error> {
    let [along, onto] = weight();
    let wheel = drive::<3>(&Surface::isotropic(MU), ROLL * onto)?;
    let torque = along * RADIUS + ROLL * onto;
    println!("turns {}, torque {}", wheel.turns, wheel.torque);
    assert_eq!(wheel.mode, ContactMode::Stick);
    assert!(wheel.creeps.abs() < 1e-9);
    assert!((wheel.torque - torque).abs() < 1e-6);
    // The droop of the gain is all that is missing.
    assert!((wheel.turns - (TARGET - torque / GAIN)).abs() < 1e-8);
    Ok(())
}

/// Slip and roll share one cone, so that what rolls against its resistance slides as well, in proportion to how much of the cone each takes.
#[test]
fn a_wheel_with_rolling_resistance_in_its_contact_creeps() -> Result<(), Error> {
    let [along, onto] = weight();
    let surface = Surface { roll: [ROLL, ROLL], ..Surface::isotropic(MU) };
    let wheel = drive::<6>(&surface, 0.0)?;
    let resistance = ROLL * (onto * onto - (along / MU).powi(2)).sqrt();
    let creeps = -wheel.turns * (along / (MU * MU)) / (resistance / (ROLL * ROLL));
    let share = -wheel.creeps / (RADIUS * wheel.turns);
    println!("creeps {share}, torque {}", wheel.torque);
    assert_eq!(wheel.mode, ContactMode::Slip);
    assert!((wheel.creeps - creeps).abs() < 1e-6, "{} {creeps}", wheel.creeps);
    assert!((share - 0.028).abs() < 5e-4);
    assert!((wheel.torque - along * RADIUS - resistance).abs() < 1e-4);
    Ok(())
}
