//! One step of the robot on its terrain: contacts from `parry3d`, limits and motors as joint rows, solved by stiction.

use crate::gait::Gait;
use crate::robot::{Dynamics, N, Robot};
use nalgebra::{Matrix3, SVector, UnitQuaternion, Vector3, vector};
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};
use parry3d_f64::shape::SharedShape;
use std::error::Error;
use std::time::Instant;
use stiction::time_stepping::{self as law, Motor};
use stiction::{
    Contact, ContactMode, ContactSolution, Kernel, Mixed, RowIndex, RowMode, Settings, Status,
};

/// Length of a step (s).
pub(crate) const STEP: f64 = 1e-3;
/// Where the floor steps up, and by how much (m).
pub(crate) const EDGE: f64 = 0.6;
pub(crate) const RISE: f64 = 0.03;
const MU: f64 = 0.6;
/// Points within this distance (m) become contacts; penetration is undone at 0.1 m/s at most.
const NEAR: f64 = 0.02;
const RECOVERY: f64 = 0.1;
/// Speed (m/s, rad/s) at which nothing here closes.
const REACH: f64 = 20.0;
/// Gains of each motor (N m/rad, N m s/rad).
const MOTOR: Motor<f64> = Motor {
    stiffness: 80.0,
    damping: 3.0,
    feedforward: 0.0,
    limit: 0.0,
};
/// Slots: four of motors, up to four of stops, and 16 contacts.
const SLOTS: usize = 24;

/// What a foot does: its force (N, world), its speed along the ground (m/s), and its gap to it (m).
#[derive(Clone, Copy)]
pub(crate) struct Foot {
    pub(crate) force: Vector3<f64>,
    pub(crate) slip: f64,
    pub(crate) mode: ContactMode,
    pub(crate) gap: f64,
}

impl Foot {
    const OPEN: Self = Self {
        force: Vector3::new(0.0, 0.0, 0.0),
        slip: 0.0,
        mode: ContactMode::Open,
        gap: NEAR,
    };

    /// Adds one of its contacts; it slips if one of them does.
    fn add(&mut self, gap: f64, force: Vector3<f64>, contact: &ContactSolution<f64, 3>) {
        self.gap = self.gap.min(gap);
        if contact.mode != ContactMode::Open {
            self.force += force;
            self.slip = self.slip.max(contact.velocity.yz().norm());
        }
        if contact.mode == ContactMode::Slip || self.mode == ContactMode::Open {
            self.mode = contact.mode;
        }
    }
}

/// What happened in a step.
pub(crate) struct Tick {
    pub(crate) place: Vector3<f64>,
    pub(crate) turn: UnitQuaternion<f64>,
    pub(crate) legs: [[Vector3<f64>; 4]; 4],
    pub(crate) feet: [Foot; 4],
    pub(crate) rows: Vec<RowMode>,
    /// Of dynamics, collision, contact (µs).
    pub(crate) cost: [f64; 3],
    /// Further budgets that the solve was given, how it ended, and its error.
    pub(crate) resumed: usize,
    pub(crate) status: Status,
    pub(crate) error: f64,
}

pub(crate) struct World {
    pub(crate) robot: Robot,
    terrain: [(Pose, SharedShape); 2],
    kernel: Box<Kernel<f64, N, 3, SLOTS, Mixed>>,
}

/// A point of a body near the ground: its normal and tangents as rows, where it is from the body's frame.
struct Point {
    body: usize,
    axes: Matrix3<f64>,
    arm: Vector3<f64>,
    gap: f64,
    key: u32,
}

impl World {
    pub(crate) fn new(robot: Robot) -> Self {
        let slab = |from: f64, to: f64, top: f64| {
            let pose = Pose::from_translation(Vector::new(f64::midpoint(from, to), 0.0, top - 0.5));
            (pose, SharedShape::cuboid((to - from) / 2.0, 4.0, 0.5))
        };
        let terrain = [slab(-4.0, 8.0, 0.0), slab(EDGE, 8.0, RISE)];
        Self {
            robot,
            terrain,
            kernel: Box::new(Kernel::mixed()),
        }
    }

    /// One step towards the targets of a gait, while a force (N) pushes the torso.
    pub(crate) fn step(&mut self, gait: &Gait, push: Vector3<f64>) -> Result<Tick, Box<dyn Error>> {
        let since = |begin: Instant| begin.elapsed().as_secs_f64() * 1e6;
        let begin = Instant::now();
        let dynamics = self.robot.dynamics()?;
        let dynamics_cost = since(begin);
        let begin = Instant::now();
        let points = self.find_contacts(&dynamics)?;
        let collision_cost = since(begin);
        let begin = Instant::now();
        let scene = self.kernel.scene_mut();
        scene.set_mass(&dynamics.mass)?;
        scene.clear_contacts();
        for point in &points {
            let jacobian = &dynamics.jacobians[point.body];
            let (angular, linear) = (jacobian.fixed_rows::<3>(0), jacobian.fixed_rows::<3>(3));
            scene.push(&Contact {
                jacobian: point.axes * (linear - point.arm.cross_matrix() * angular),
                offset: vector![law::gap(point.gap, STEP, RECOVERY, REACH), 0.0, 0.0],
                mu: MU,
                key: point.key,
            })?;
        }
        let rows = self.push_rows(gait)?;
        let mut force = -dynamics.bias;
        let mut pushed = force.fixed_rows_mut::<3>(3);
        pushed += push;
        let impulse = law::free_impulse(&dynamics.mass, &self.robot.velocity, &force, STEP);
        let settings = Settings::new(1e-8);
        let mut solution = self.kernel.solve(&impulse, &settings)?;
        let mut resumed = 0;
        while solution.status == Status::OutOfBudget && resumed < 3 {
            resumed += 1;
            solution = self.kernel.resume(&impulse, &settings)?;
        }
        let cost = [dynamics_cost, collision_cost, since(begin)];
        if !solution.is_usable(1e-3) {
            return Err(format!("{}, error {:.1e}", solution.status, solution.error).into());
        }

        let mut tick = Tick {
            place: self.robot.place,
            turn: self.robot.turn,
            legs: dynamics.legs,
            feet: [Foot::OPEN; 4],
            rows: rows
                .iter()
                .filter_map(|&row| solution.row(row))
                .map(|row| row.mode)
                .collect(),
            cost,
            resumed,
            status: solution.status,
            error: solution.error,
        };
        for (point, contact) in points.iter().zip(&solution.contacts) {
            if let Some(foot) = self.robot.bodies[point.body].foot {
                let force = point.axes.transpose() * contact.impulse / STEP;
                tick.feet[foot].add(point.gap, force, contact);
            }
        }
        self.robot.advance(solution.velocity, STEP);
        Ok(tick)
    }

    /// All points of the robot that are near the terrain.
    fn find_contacts(&self, dynamics: &Dynamics) -> Result<Vec<Point>, Box<dyn Error>> {
        let (mut points, mut key) = (Vec::new(), 0);
        let mut manifolds: Vec<ContactManifold<(), ()>> = Vec::new();
        for (body, pose) in dynamics.poses.iter().enumerate() {
            for (ground, shape) in &self.terrain {
                let (relative, below) = (ground.inv_mul(pose), &*self.robot.bodies[body].shape);
                manifolds.clear();
                DefaultQueryDispatcher
                    .contact_manifolds(&relative, &**shape, below, NEAR, &mut manifolds, &mut None)
                    .map_err(|error| error.to_string())?;
                key += 1; // the points of a pair follow one another
                for manifold in &manifolds {
                    let normal = ground.rotation * manifold.local_n1;
                    let normal: Vector3<f64> = <[f64; 3]>::from(normal).into();
                    let ahead = Vector3::y().cross(&normal).normalize(); // no wall faces sideways
                    let rows = [normal, ahead, normal.cross(&ahead)].map(|axis| axis.transpose());
                    for point in manifold.points.iter().filter(|point| point.dist < NEAR) {
                        let arm = <[f64; 3]>::from(pose.rotation * point.local_p2).into();
                        let (axes, gap) = (Matrix3::from_rows(&rows), point.dist);
                        points.push(Point {
                            body,
                            axes,
                            arm,
                            gap,
                            key,
                        });
                    }
                }
            }
        }
        Ok(points)
    }

    /// The motors, and the stops that a joint may reach within the step.
    fn push_rows(&mut self, gait: &Gait) -> Result<Vec<RowIndex>, stiction::Error> {
        let (mut rows, mut key) = (Vec::new(), 0);
        let scene = self.kernel.scene_mut();
        for (dof, joint) in self.robot.joints.iter().enumerate() {
            let (angle, mut row) = (self.robot.angles[dof], SVector::<f64, N>::zeros());
            row[6 + dof] = 1.0;
            let motor = Motor {
                limit: joint.effort,
                ..MOTOR
            };
            let (ahead, rate) = (angle - gait.angles[joint.index], gait.rates[joint.index]);
            rows.push(scene.push_row(&law::motor(row, &motor, ahead, rate, STEP, key))?);
            let [lower, upper] = joint.range;
            for (row, distance) in [(row, angle - lower), (-row, upper - angle)] {
                key += 1;
                if distance < REACH * STEP {
                    let stop = law::joint_limit(row, distance, STEP, 1.0, REACH, key);
                    rows.push(scene.push_row(&stop)?);
                }
            }
            key += 1;
        }
        Ok(rows)
    }
}
