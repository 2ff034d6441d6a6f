//! Trees among ground and each other, and their time step.

use crate::collide::{Point, collide};
use crate::tree::Tree;
use crate::{Base, Body, Failure, Joint};
use indicatif::{ProgressBar, ProgressStyle};
use nalgebra::{SVector, Vector3, vector};
use parry3d_f64::math::Pose;
use std::path::Path;
use std::time::Instant;
use stiction::Surface;
use stiction::time_stepping::{self as law, Motor};
use stiction::{
    Contact, ContactMode, ContactSolution, Kernel, Mixed, RowIndex, RowMode, Settings, Status,
};

/// Length of a step (s).
pub const STEP: f64 = 1e-3;
/// Penetration is undone at this speed (m/s, rad/s) at most.
const RECOVERY: f64 = 0.1;
/// Relaxation time of rubber (s).
const RELAXATION: f64 = 5e-3;
/// Speed (m/s, rad/s) at which nothing here closes.
const REACH: f64 = 20.0;
/// Slots: one for each contact, and one for three joint rows.
const SLOTS: usize = 24;

/// A world of `N` velocities in all.
pub struct World<const N: usize> {
    /// Friction coefficient of all that touches.
    pub mu: f64,
    /// How stiff rubber between all that touches is (N/m); infinite is rigid.
    pub stiffness: f64,
    /// Gains of each motor: of the position (N·m/rad, N/m), and of the velocity (N·m·s/rad, N·s/m).
    pub gains: [f64; 2],
    /// A body that is pushed at the origin of its link, and with which force (N).
    pub push: (usize, Vector3<f64>),
    /// Joints that mimic each other: both of a pair are at the same angle.
    pub mimics: Vec<[&'static str; 2]>,
    /// What may touch: ground, and the shapes of all trees.
    pub bodies: Vec<Body>,
    /// Robots and things.
    pub trees: Vec<Tree>,
    /// Velocities of all trees, one after the other.
    pub velocity: SVector<f64, N>,
    kernel: Box<Kernel<f64, N, 3, SLOTS, Mixed>>,
}

/// A contact that pushes.
pub struct Touch {
    /// The bodies.
    pub pair: [usize; 2],
    /// Where (m).
    pub place: Vector3<f64>,
    /// Force on the second body (N).
    pub force: Vector3<f64>,
    /// Its part along the normal (N).
    pub normal: f64,
    /// Its gap (m), negative in penetration.
    pub gap: f64,
    /// Speed along the surface (m/s).
    pub slip: f64,
    /// Whether it sticks or slips.
    pub mode: ContactMode,
}

/// What happened in a step.
pub struct Tick {
    /// Where the shapes of bodies were, and which line each joint makes from link to link.
    pub(crate) poses: Vec<Pose>,
    pub(crate) bones: Vec<[Vector3<f64>; 2]>,
    /// Where the world was pushed (m), and how (N).
    pub push: [Vector3<f64>; 2],
    /// Contacts that pushed.
    pub touches: Vec<Touch>,
    pub(crate) rows: Vec<RowMode>,
    /// Of dynamics, collision, contact (µs).
    pub(crate) cost: [f64; 3],
    /// How the solve ended.
    pub status: Status,
    /// And its error.
    pub error: f64,
}

impl<const N: usize> World<N> {
    /// An empty world with a friction coefficient and the gains of all motors.
    #[must_use]
    pub fn new(mu: f64, gains: [f64; 2]) -> Self {
        Self {
            mu,
            stiffness: f64::INFINITY,
            gains,
            push: (0, Vector3::zeros()),
            mimics: Vec::new(),
            bodies: Vec::new(),
            trees: Vec::new(),
            velocity: SVector::zeros(),
            kernel: Box::new(Kernel::mixed()),
        }
    }

    /// Adds a block of ground between two corners (m).
    pub fn ground(&mut self, name: &str, from: [f64; 3], to: [f64; 3]) {
        self.bodies.push(Body::ground(name, from.into(), to.into()));
    }

    /// Adds a robot or a thing from a URDF file, with its root at a place (m).
    pub fn load(&mut self, file: &Path, base: Base, place: [f64; 3]) -> Result<(), Failure> {
        let (mut tree, bodies) = Tree::load(file, base)?;
        tree.place = place.into();
        let index = self.trees.len();
        let owned = bodies.into_iter().map(|body| Body {
            tree: index,
            ..body
        });
        self.bodies.extend(owned);
        self.trees.push(tree);
        Ok(())
    }

    /// The joint of a name.
    pub fn joint(&mut self, name: &str) -> Result<&mut Joint, Failure> {
        let mut joints = self.trees.iter_mut().flat_map(|tree| &mut tree.joints);
        let found = joints.find(|joint| joint.name == name);
        found.ok_or_else(|| format!("there is no joint {name}").into())
    }

    /// The first body of a link of this name.
    pub fn body(&self, name: &str) -> Result<usize, Failure> {
        let found = self.bodies.iter().position(|body| body.name == name);
        found.ok_or_else(|| format!("there is no body {name}").into())
    }

    /// Tells the motor of a joint where to be after the next step (rad, m).
    pub fn aim(&mut self, name: &str, angle: f64) -> Result<(), Failure> {
        let joint = self.joint(name)?;
        joint.target = [angle, (angle - joint.target[0]) / STEP];
        Ok(())
    }

    /// Lets `seconds` pass, with a progress bar; `control` aims and pushes before each step, which it is told the time of (s).
    pub fn run(
        &mut self,
        seconds: f64,
        mut control: impl FnMut(&mut Self, f64) -> Result<(), Failure>,
    ) -> Result<Vec<Tick>, Failure> {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let steps = (seconds / STEP).round() as u32;
        let style = ProgressStyle::with_template("{wide_bar} {pos} of {len} steps, {eta} left")?;
        let progress = ProgressBar::new(steps.into()).with_style(style);
        let mut ticks = Vec::new();
        for step in 0..steps {
            let time = f64::from(step) * STEP;
            control(self, time)?;
            let tick = self.step();
            ticks.push(tick.map_err(|error| format!("at {time:.3} s: {error}"))?);
            progress.inc(1);
        }
        progress.finish_and_clear();
        Ok(ticks)
    }

    /// One time step: dynamics, collisions, contacts and rows, their solution, new places.
    pub fn step(&mut self) -> Result<Tick, Failure> {
        let mut begin = Instant::now();
        let mut lap = || {
            let before = std::mem::replace(&mut begin, Instant::now());
            (begin - before).as_secs_f64() * 1e6
        };
        let dynamics = self.dynamics()?;
        let dynamics_cost = lap();
        let points = collide(&self.bodies, &dynamics.poses)?;
        let collision_cost = lap();

        let scene = self.kernel.scene_mut();
        scene.set_mass(&dynamics.mass)?;
        scene.clear_contacts();
        let normal = law::compliance(self.stiffness, RELAXATION, STEP);
        let surface = Surface {
            compliance: [normal, 0.0],
            ..Surface::isotropic(self.mu)
        };
        for point in &points {
            let [a, b] = point.pair.map(|body| dynamics.jacobian(body, &point.place));
            let rigid = law::gap(point.gap, STEP, RECOVERY, REACH);
            let soft = law::compliant_gap(point.gap, RELAXATION, STEP, REACH);
            let contact = Contact {
                jacobian: point.axes * (b - a),
                offset: vector![
                    if surface.compliance[0] > 0.0 {
                        soft
                    } else {
                        rigid
                    },
                    0.0,
                    0.0
                ],
                mu: self.mu,
                key: point.key,
            };
            scene.push_on(&contact, &surface)?;
        }
        let rows = self.push_rows()?;
        let (pushed, push) = self.push;
        let force =
            dynamics.force + dynamics.jacobians[pushed].fixed_rows::<3>(3).transpose() * push;
        let impulse = law::free_impulse(&dynamics.mass, &self.velocity, &force, STEP);
        let solution = self.kernel.solve(&impulse, &Settings::new(1e-8))?;
        if !solution.is_usable(1e-3) {
            return Err(format!("{}, error {:.1e}", solution.status, solution.error).into());
        }

        let modes = rows.iter().filter_map(|&row| solution.row(row));
        let pushing = points.iter().zip(&solution.contacts); // rows stand behind contacts
        let tick = Tick {
            rows: modes.map(|row| row.mode).collect(),
            touches: pushing
                .filter_map(|(point, contact)| {
                    (contact.mode != ContactMode::Open).then(|| Touch::new(point, contact))
                })
                .collect(),
            push: [dynamics.origins[pushed], push],
            poses: dynamics.poses,
            bones: dynamics.bones,
            status: solution.status,
            error: solution.error,
            cost: [dynamics_cost, collision_cost, lap()],
        };
        self.velocity = solution.velocity;
        let mut rest = self.velocity.as_slice();
        for tree in &mut self.trees {
            let (own, others) = rest.split_at(tree.size());
            tree.advance(own, STEP);
            rest = others;
        }
        Ok(tick)
    }

    /// The motors, the stops that a joint may reach within the step, and joints that mimic each other.
    fn push_rows(&mut self) -> Result<Vec<RowIndex>, Failure> {
        let (mut rows, mut key, mut dof) = (Vec::new(), 0, 0);
        let (scene, [stiffness, damping]) = (self.kernel.scene_mut(), self.gains);
        let mut joints = Vec::new();
        for tree in &self.trees {
            dof += tree.size() - tree.joints.len();
            for joint in &tree.joints {
                let mut row = SVector::<f64, N>::zeros();
                row[dof] = 1.0;
                joints.push((&*joint.name, row, joint.angle));
                let motor = Motor {
                    stiffness,
                    damping,
                    feedforward: 0.0,
                    limit: joint.effort,
                };
                if joint.effort > 0.0 {
                    let ahead = joint.angle - joint.target[0];
                    let row = law::motor(row, &motor, ahead, joint.target[1], STEP, key);
                    rows.push(scene.push_row(&row)?);
                }
                let [lower, upper] = joint.range;
                for (row, distance) in [(row, joint.angle - lower), (-row, upper - joint.angle)] {
                    key += 1;
                    if distance < REACH * STEP {
                        let stop = law::joint_limit(row, distance, STEP, 1.0, REACH, key);
                        rows.push(scene.push_row(&stop)?);
                    }
                }
                (key, dof) = (key + 1, dof + 1);
            }
        }
        for names in &self.mimics {
            let find = |name: &str| {
                joints
                    .iter()
                    .position(|joint: &(&str, _, _)| joint.0 == name)
            };
            let [Some(one), Some(other)] = names.map(find) else {
                return Err(format!("there are no joints {names:?}").into());
            };
            let ((_, one, at), (_, other, there)) = (joints[one], joints[other]);
            let gear = law::closed_loop(one - other, at - there, STEP, RECOVERY, key);
            rows.push(scene.push_row(&gear)?);
            key += 1;
        }
        Ok(rows)
    }
}

impl Touch {
    fn new(point: &Point, contact: &ContactSolution<f64, 3>) -> Self {
        Self {
            pair: point.pair,
            place: point.place,
            force: point.axes.transpose() * contact.impulse / STEP,
            normal: contact.impulse[0] / STEP,
            gap: point.gap,
            slip: contact.velocity.yz().norm(),
            mode: contact.mode,
        }
    }
}

impl Tick {
    /// Contacts of a body: all that are shapes of the same link.
    pub fn touches_of<'a>(
        &'a self,
        bodies: &'a [Body],
        name: &'a str,
    ) -> impl Iterator<Item = &'a Touch> {
        self.touches
            .iter()
            .filter(move |touch| touch.pair.iter().any(|&body| bodies[body].name == name))
    }
}
