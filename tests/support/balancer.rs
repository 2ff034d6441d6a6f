//! A wheeled balancer in its closed loop: a body on two legs that extend, with a wheel on each and a skid at the tail.
//!
//! It has ten velocities: of the body (three along and three about the axes of the world), of the legs and of the wheels. The plant is of
//! another kind than the scenes: springs, dampers and friction without a corner, in eight substeps.

use super::check::Tally;
use super::random::{draws, numbers};
use nalgebra::{Matrix3, RealField, SMatrix, SVector, Vector3, vector};
use stiction::time_stepping::{DryFriction, Gap, JointLimit, Motor, free_impulse};
use stiction::{Contact, Error, JointRow, Kernel, Phases, Real, Settings};

const N: usize = 10;
pub(crate) const TICKS: usize = 2_600;
const STEP: f32 = 1e-3;
const SUBSTEPS: u8 = 8;
const GRAVITY: Vector3<f32> = Vector3::new(0.0, 0.0, -9.81);

/// Of the body and of a wheel (kg, kg·m² about their own axes).
const MASS: [f32; 2] = [6.0, 0.8];
const INERTIA: [Vector3<f32>; 2] = [Vector3::new(0.06, 0.05, 0.04), Vector3::new(0.0015, 0.0026, 0.0015)];
/// Of a wheel, and half the distance between the two (m).
const RADIUS: f32 = 0.08;
const TRACK: f32 = 0.18;
/// Shortest and longest leg (m), and its largest force (N).
const LEG: [f32; 2] = [0.18, 0.38];
const LEG_FORCE: f32 = 120.0;
/// Dry friction of an axle (N·m).
const AXLE: f32 = 0.05;
/// Where the skid is (m), and its friction.
const SKID: Vector3<f32> = Vector3::new(-0.16, 0.0, -0.12);
const SKID_MU: f32 = 0.25;

type Robot<P> = Kernel<f32, N, 3, 3, 6, 0, P>;
type Velocity = SVector<f32, N>;
type Rows = SMatrix<f32, 3, N>;

/// Where the robot is, and how fast.
#[derive(Clone)]
struct State {
    at: Vector3<f32>,
    turn: Matrix3<f32>,
    legs: [f32; 2],
    v: Velocity,
}

/// Mass matrix, forces of weight and rotation, and of each point that may touch its height and Jacobian.
struct Dynamics {
    mass: SMatrix<f32, N, N>,
    force: Velocity,
    points: [(f32, Rows); 3],
}

/// The Jacobian of a point of the body.
fn carried(point: &Vector3<f32>) -> Rows {
    let mut rows = Rows::identity();
    rows.fixed_columns_mut::<3>(3).copy_from(&-point.cross_matrix());
    rows
}

fn axis(i: usize) -> Velocity {
    let mut axis = Velocity::zeros();
    axis[i] = 1.0;
    axis
}

impl State {
    /// Three centimetres above the ground.
    fn new() -> Self {
        let at = vector![0.0, 0.0, 0.3 + RADIUS + 0.03];
        Self { at, turn: Matrix3::identity(), legs: [0.3; 2], v: Velocity::zeros() }
    }

    /// The state as sensors see it.
    fn measured(&self, noise: &[f64]) -> Self {
        let noise = noise.iter().copied().map(f32::literal).collect::<Vec<_>>();
        let mut seen = self.clone();
        seen.v += Velocity::from_column_slice(&noise[..N]) * 0.01;
        seen.legs[0] += 2e-4 * noise[N];
        seen.legs[1] += 2e-4 * noise[N + 1];
        seen.at.z += 3e-4 * noise[N + 2];
        seen
    }

    fn dynamics(&self) -> Dynamics {
        let (y, z) = (self.turn.column(1).into_owned(), self.turn.column(2).into_owned());
        let omega = self.v.fixed_rows::<3>(3).into_owned();
        let (mut mass, mut force) = (SMatrix::zeros(), Velocity::zeros());
        // A part, with its accelerations while no velocity changes.
        let mut add = |part: usize, linear: &Rows, angular: &Rows, bias: [Vector3<f32>; 2]| {
            let inertia = self.turn * Matrix3::from_diagonal(&INERTIA[part]) * self.turn.transpose();
            let spin = angular * self.v;
            mass += linear.tr_mul(linear) * MASS[part] + angular.tr_mul(&(inertia * angular));
            force += linear.tr_mul(&((GRAVITY - bias[0]) * MASS[part]));
            force -= angular.tr_mul(&(inertia * bias[1] + spin.cross(&(inertia * spin))));
        };
        let mut turns = Rows::zeros();
        turns.fixed_columns_mut::<3>(3).copy_from(&Matrix3::identity());
        add(0, &Rows::identity(), &turns, [Vector3::zeros(); 2]);
        let wheels = [(0, TRACK), (1, -TRACK)].map(|(i, side)| {
            let centre = self.turn * vector![0.0, side, -self.legs[i]];
            let mut linear = carried(&centre);
            linear.set_column(6 + i, &-z);
            let mut angular = turns;
            angular.set_column(8 + i, &y);
            let swings = omega.cross(&omega.cross(&centre)) - omega.cross(&z) * (2.0 * self.v[6 + i]);
            add(1, &linear, &angular, [swings, omega.cross(&y) * self.v[8 + i]]);
            // The lowest point of the rim.
            let lowest = (y * y.z - Vector3::z()).normalize() * RADIUS;
            ((self.at + centre + lowest).z, linear - lowest.cross_matrix() * angular)
        });
        let skid = self.turn * SKID;
        Dynamics { mass, force, points: [wheels[0], wheels[1], ((self.at + skid).z, carried(&skid))] }
    }

    /// One tick of the plant: torques of the wheels, forces of the legs, and a push.
    fn advance(&mut self, drive: f32, legs: [f32; 2], push: &Velocity, mu: f32) {
        let step = STEP / f32::from(SUBSTEPS);
        for _ in 0..SUBSTEPS {
            let Dynamics { mass, mut force, points } = self.dynamics();
            force += push;
            for i in 0..2 {
                force[6 + i] += legs[i];
                let beyond = self.legs[i].clamp(LEG[0], LEG[1]) - self.legs[i];
                if beyond != 0.0 {
                    force[6 + i] += 4e4 * beyond - 60.0 * self.v[6 + i];
                }
                force[8 + i] += drive - AXLE * (self.v[8 + i] / 0.05).clamp(-1.0, 1.0);
            }
            for ((height, rows), mu) in points.iter().zip([mu, mu, SKID_MU]).filter(|point| point.0.0 < 0.0) {
                let u = rows * self.v;
                let normal = (-2e4 * height - 80.0 * u.z).max(0.0);
                let slide = u.xy() * (-mu * normal / u.xy().norm().max(0.02));
                force += rows.tr_mul(&vector![slide.x, slide.y, normal]);
            }
            self.v += mass.cholesky().expect("masses are positive").solve(&force) * step;
            self.at += self.v.fixed_rows::<3>(0) * step;
            let turn = self.turn + (self.v.fixed_rows::<3>(3) * step).cross_matrix() * self.turn;
            let x = turn.column(0).normalize();
            let z = x.cross(&turn.column(1)).normalize();
            self.turn = Matrix3::from_columns(&[x, z.cross(&x), z]);
            for i in 0..2 {
                self.legs[i] += self.v[6 + i] * step;
            }
        }
    }
}

/// Fills the scene of a tick: the free impulse, and the stops of the legs.
fn fill<P: Phases>(
    robot: &mut Robot<P>,
    seen: &State,
    (drive, leg, mu): (f32, f32, f32),
) -> Result<(Velocity, Vec<JointRow<f32, N>>), Error> {
    let Dynamics { mass, mut force, points } = seen.dynamics();
    let scene = robot.scene_mut();
    scene.clear();
    scene.set_mass(&mass)?;
    for (((distance, rows), mu), key) in points.iter().zip([mu, mu, SKID_MU]).zip(0..) {
        let mut contact = Contact::at_point(&Vector3::z(), rows, mu, key)?;
        contact.offset[0] = Gap { distance: *distance, recovery: 0.02, reach: 5.0 }.offset(STEP)?;
        scene.push(&contact)?;
    }
    let mut stops = Vec::new();
    for ((i, length), key) in seen.legs.into_iter().enumerate().zip(0..) {
        force[8 + i] += drive;
        scene.push_row(&DryFriction { torque: AXLE }.row(axis(8 + i), STEP, key)?)?;
        let motor = Motor { stiffness: 1500.0, damping: 60.0, limit: LEG_FORCE, ..Motor::default() };
        let motor = Motor { ahead: length - leg, ..motor };
        scene.push_row(&motor.row(axis(6 + i), STEP, 2 + key)?)?;
        for (sign, distance, key) in [(1.0, length - LEG[0], 4 + key), (-1.0, LEG[1] - length, 6 + key)] {
            let limit = JointLimit { distance, recovery: 0.2, reach: 20.0 };
            stops.push(limit.row(axis(6 + i) * sign, STEP, key)?);
        }
    }
    Ok((free_impulse(&mass, &seen.v, &force, STEP), stops))
}

/// Balances for 2,600 ticks of a millisecond, with noise, two pushes and ice; legs are told to go beyond their stops. How the ticks ended.
///
/// The legs have the forces of the last tick that could be used. A cold robot forgets each tick.
pub(crate) fn balance<P: Phases>(phases: P, budget: usize, is_cold: bool) -> Result<Tally, Error> {
    let (mut robot, mut state, mut tally) = (Robot::with_phases(phases), State::new(), Tally::default());
    let settings = Settings { budget, ..Settings::new(1e-4) };
    let mut legs = [0.0; 2];
    for (noise, tick) in draws(numbers(N + 3), TICKS).zip(0..) {
        let mu = if (800..950).contains(&tick) { 0.12 } else { 0.8 };
        let leg = match tick {
            1_700..2_000 => 0.45,
            2_000..2_300 => 0.1,
            _ => 0.3,
        };
        let push = match tick {
            500..520 => vector![40.0, 60.0, 0.0],
            1_300..1_330 => vector![0.0, 0.0, -60.0],
            _ => Vector3::zeros(),
        };
        let wanted = if (700..1_000).contains(&tick) { 1.5 } else { 0.0 };
        let seen = state.measured(&noise);
        let pitch = RealField::atan2(seen.turn[(0, 2)], seen.turn[(2, 2)]);
        let heading = seen.turn.column(0).xy();
        let speed = heading.dot(&seen.v.xy()) / heading.norm().max(1e-3);
        let drive = (28.0 * pitch + 3.0 * seen.v[4] + 2.5 * (speed - wanted)).clamp(-6.0, 6.0);
        if is_cold {
            robot.solver_mut().reset();
        }
        let (free, stops) = fill(&mut robot, &seen, (drive, leg, mu))?;
        let solution = robot.solve_with_limits(&stops, &free, &settings)?;
        if tally.add(solution) {
            legs = [2, 3].map(|key| solution.row_by_key(key).map_or(0.0, |motor| motor.impulse / STEP));
        }
        let mut force = Velocity::zeros();
        force.fixed_rows_mut::<3>(0).copy_from(&push);
        state.advance(drive, legs, &force, mu);
    }
    Ok(tally)
}
