//! Rolling resistance of a driven wheel: on its axle it rolls, in its contact it creeps. Two wheels on one axle, whose lateral rows are nearly one.

use crate::support::boxes::GRAVITY;
use crate::support::sizes::bodies;
use nalgebra::{Matrix3, Rotation3, SMatrix, SVector, Vector3, vector};
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

/// Speed of its legs (m/s).
const EXTENDS: f64 = 0.05;

/// Mode, slip (m/s) and use of friction of each wheel.
type Wheels = [(ContactMode, f64, f64); 2];

/// A balancer: 6 kg on two legs that extend, with a wheel of 0.8 kg at each.
struct Balancer {
    mass: SMatrix<f64, 10, 10>,
    weight: SVector<f64, 10>,
    /// Velocity of the lowest point of each wheel, from that of the body (3 + 3), of legs and wheels.
    points: [SMatrix<f64, 3, 10>; 2],
}

impl Balancer {
    /// Tilted sideways by half a hundredth, and level by its legs.
    fn new() -> Self {
        let (roll, half, radius) = (5e-3, 0.18, 0.08);
        let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), roll);
        let mut body = [SMatrix::<f64, 3, 10>::zeros(); 2];
        let [velocity, turns] = &mut body;
        velocity.fixed_columns_mut::<3>(0).fill_with_identity();
        turns.fixed_columns_mut::<3>(3).fill_with_identity();
        let (mut mass, mut weight) = (SMatrix::zeros(), SVector::zeros());
        let mut add = |kg: f64, inertia, [velocity, turns]: &[SMatrix<f64, 3, 10>; 2]| {
            let inertia = turn.matrix() * Matrix3::from_diagonal(&inertia) * turn.matrix().transpose();
            mass += velocity.tr_mul(velocity) * kg + turns.tr_mul(&(inertia * turns));
            weight -= velocity.row(2).transpose() * (GRAVITY * kg);
        };
        add(6.0, vector![0.06, 0.05, 0.04], &body);
        let points = [(1.0, 6, 8), (-1.0, 7, 9)].map(|(side, leg, wheel)| {
            let arm = turn * vector![0.0, side * half, -0.27 - side * half * roll];
            let mut parts = body;
            let [velocity, turns] = &mut parts;
            velocity.fixed_columns_mut::<3>(3).copy_from(&-arm.cross_matrix());
            velocity.set_column(leg, &-(turn * Vector3::z()));
            let axle = turn * Vector3::y();
            turns.set_column(wheel, &axle);
            add(0.8, vector![1.5e-3, 2.6e-3, 1.5e-3], &parts);
            let [velocity, turns] = parts;
            let down = (axle * axle.z - Vector3::z()).normalize() * radius;
            velocity - down.cross_matrix() * turns
        });
        Self { mass, weight, points }
    }

    /// The free impulse: it rolls ahead while one leg extends and the other draws in, so that it tilts about the ground.
    fn push(&self) -> SVector<f64, 10> {
        let tilts = EXTENDS / 0.18;
        let velocity = [0.2, -0.35 * tilts, 0.0, tilts, 0.0, 0.0, EXTENDS, -EXTENDS, 2.5, 2.5];
        self.mass * SVector::from(velocity) + self.weight * STEP
    }

    /// Prints and returns the work of a step to 1e-4, and the wheels.
    fn step(&self, surfaces: [Surface<f64>; 2]) -> Result<(usize, Wheels), Error> {
        let mut kernel = bodies::Kernel::<f64>::new();
        let scene = kernel.scene_mut();
        scene.set_mass(&self.mass)?;
        for ((key, point), surface) in (0..).zip(&self.points).zip(&surfaces) {
            scene.push_on(&Contact::at_point(&Vector3::z(), point, MU, key)?, surface)?;
        }
        for (key, leg, target) in [(0, 6, EXTENDS), (1, 7, -EXTENDS)] {
            let row = SVector::from_fn(|i, _| if i == leg { 1.0 } else { 0.0 });
            let motor =
                Motor { stiffness: 1500.0, damping: 60.0, feedforward: 29.4, target, ..Motor::default() };
            scene.push_row(&motor.row(row, STEP, key)?)?;
        }
        let solution = kernel.solve(&self.push(), &Settings::new(1e-4))?;
        assert!(solution.is_solved());
        let wheels = [0, 1].map(|i| {
            let wheel = &solution.contacts[i];
            let sizes = [wheel.velocity, wheel.impulse].map(|vector| vector[1].hypot(vector[2]));
            (wheel.mode, sizes[0], sizes[1] / (MU * wheel.impulse[0]))
        });
        println!("work {}, {wheels:?}", solution.work.total());
        Ok((solution.work.total(), wheels))
    }
}

/// To stop both wheels takes thousands of times the friction that there is, so one slips by what their rows differ. A little compliance is enough for both,
/// and for an easy solve; or one lateral row for both.
#[test]
fn two_wheels_on_one_axle_want_a_little_compliance() -> Result<(), Error> {
    let balancer = Balancer::new();
    let [left, right] = balancer.points;
    let rows = SMatrix::<f64, 6, 10>::from_fn(|i, j| if i < 3 { left[(i, j)] } else { right[(i - 3, j)] });
    let inverse = balancer.mass.try_inverse().expect("a mass");
    let response = (rows * inverse * rows.transpose()).symmetric_eigen();
    let (least, softness) = response.eigenvalues.argmin();
    let free = rows * inverse * balancer.push();
    let (needed, friction) = (
        response.eigenvectors.column(least).dot(&free).abs() / softness,
        -MU * balancer.weight[2] * STEP / 2.0,
    );
    println!(
        "W {softness:.1e} /kg; to stop it takes {needed:.0} N·s, friction of a wheel is {friction:.3} N·s"
    );
    assert!(softness < 1e-5 && needed > 1_000.0 * friction);

    let surface = Surface::isotropic(MU);
    let (work, wheels) = balancer.step([surface; 2])?;
    assert!(work > 80);
    assert!(wheels.iter().any(|&(mode, slip, _)| mode == ContactMode::Slip && slip > 3e-4));
    for compliance in [3e-2, 1e-1] {
        let (work, wheels) = balancer.step([Surface { compliance: [compliance; 2], ..surface }; 2])?;
        assert!(work < 30);
        assert!(wheels.iter().all(|&(mode, _, used)| mode == ContactMode::Stick && used < 0.5));
    }
    let (work, wheels) = balancer.step([surface, Surface { friction: [MU, 0.0], ..surface }])?;
    assert!(work < 30);
    assert!(wheels.iter().all(|&(mode, _, used)| mode == ContactMode::Stick && used < 0.5));
    Ok(())
}
