//! A tree of links from a URDF file, a robot or a thing: its joints, and where it is.
//!
//! Its dynamics are those of `dynibo`, which has `M`, bias forces and Jacobians of a floating base in world coordinates;
//! `phyz-rigid` 0.4 turns a free body by a rotation vector.

use crate::{Body, Failure, shapes, urdf};
use dynibo::FloatingRobot;
use nalgebra::{UnitQuaternion, Vector3};
use std::ops::Range;
use std::path::Path;
use urdf_rs::Robot;

/// Gravity of `dynibo` (m/s²).
pub const GRAVITY: f64 = 9.80665;

/// How the root link of a tree stands in the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Base {
    /// It is free: six velocities, angular and then linear (world), stand before those of the joints. A root link of the name
    /// `world` is not: in ROS that is the world, and so it is bolted down.
    Free,
    /// It is bolted down.
    Bolted,
}

/// A joint, and the motor that drives it if its effort is not 0.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Its name in the file.
    pub name: String,
    /// Where it is (rad, m).
    pub angle: f64,
    /// Its stops (rad, m).
    pub range: [f64; 2],
    /// Largest torque of its motor (N·m, N).
    pub effort: f64,
    /// Where its motor is to bring it (rad, m), and how fast that moves (rad/s, m/s).
    pub target: [f64; 2],
    /// The joint of its tree that it mimics.
    pub(crate) mimic: Option<Mimic>,
}

/// A joint is where another one, times a ratio, and an offset put it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mimic {
    pub(crate) leader: usize,
    pub(crate) ratio: f64,
    pub(crate) offset: f64,
}

/// A tree of links: its joints in the order of its velocities, and where its root is.
#[derive(Debug)]
pub struct Tree {
    pub(crate) model: FloatingRobot,
    base: Base,
    /// The joints.
    pub joints: Vec<Joint>,
    /// Lines to be drawn, from links that have no shape to their children.
    pub(crate) bones: Vec<[usize; 2]>,
    /// Place of the root (m).
    pub place: Vector3<f64>,
    /// Orientation of the root.
    pub turn: UnitQuaternion<f64>,
}

impl Tree {
    /// Reads a tree and the bodies that its links have for collisions. Each joint is at 0, or at the end of its range that is
    /// nearest to 0, or where the joint has it that it mimics.
    pub fn load(file: &Path, base: Base) -> Result<(Self, Vec<Body>), Failure> {
        let load = || {
            let robot = urdf::read(file)?;
            let model = urdf::dynamics(&robot)?;
            let index: Vec<_> = (0..model.link_count())
                .map(|link| Ok(model.link_name(model.link_id_at(link)?)?.to_owned())) // in another order than in the file
                .collect::<Result<_, Failure>>()?;
            let index = |name: &str| index.iter().position(|link| link == name).unwrap_or(0);
            let mut bodies = Vec::new();
            for link in &robot.links {
                for collision in &link.collision {
                    let shape = shapes::shape(collision, file);
                    let (shape, local) = shape.map_err(|error| format!("link {}: {error}", link.name))?;
                    bodies.push(Body {
                        name: link.name.clone(),
                        link: index(&link.name),
                        tree: 0,
                        local,
                        shape,
                    });
                }
            }
            let bones =
                robot.joints.iter().map(|joint| [&joint.parent, &joint.child].map(|end| index(&end.link)));
            let shaped = |link| bodies.iter().any(|body| body.link == link);
            let bones = bones.filter(|&[parent, _]| !shaped(parent)).collect();
            let joints = joints(&robot, &model)?;
            let world = robot.links[urdf::root(&robot)].name == "world";
            let base = if world { Base::Bolted } else { base };
            let (place, turn) = (Vector3::zeros(), UnitQuaternion::identity());
            Ok((Self { model, base, joints, bones, place, turn }, bodies))
        };
        load().map_err(|error: Failure| format!("{}: {error}", file.display()).into())
    }

    /// The joints that nothing drives.
    #[must_use]
    pub fn passive(&self) -> Vec<&str> {
        let passive = self.joints.iter().filter(|joint| joint.effort == 0.0 && joint.mimic.is_none());
        passive.map(|joint| &*joint.name).collect()
    }

    /// Which of six velocities of a base and those of the joints it has.
    pub(crate) fn kept(&self) -> Range<usize> {
        let skip = if self.base == Base::Bolted { 6 } else { 0 };
        skip..6 + self.joints.len()
    }

    /// How many velocities it has.
    #[must_use]
    pub fn size(&self) -> usize {
        self.kept().len()
    }

    /// What a velocity moves, in words.
    pub(crate) fn velocity_name(&self, velocity: usize) -> String {
        match (velocity + self.kept().start).checked_sub(6) {
            Some(joint) => format!("joint {}", self.joints[joint].name),
            None => "a free base".into(),
        }
    }

    /// What it weighs (N).
    pub fn weight(&self) -> Result<f64, Failure> {
        let mut mass = 0.0;
        for link in 0..self.model.link_count() {
            mass += self.model.link_mass(self.model.link_id_at(link)?)?;
        }
        Ok(mass * GRAVITY)
    }

    /// Moves it with the velocities at the end of a step.
    pub(crate) fn advance(&mut self, velocity: &[f64], step: f64) {
        let (base, rates) = velocity.split_at(velocity.len() - self.joints.len());
        if let &[a, b, c, x, y, z] = base {
            self.turn = UnitQuaternion::from_scaled_axis(Vector3::new(a, b, c) * step) * self.turn;
            self.place += Vector3::new(x, y, z) * step;
        }
        for (joint, rate) in self.joints.iter_mut().zip(rates) {
            joint.angle += rate * step;
        }
    }
}

/// The joints of a robot that move, in the order of the model.
fn joints(robot: &Robot, model: &FloatingRobot) -> Result<Vec<Joint>, Failure> {
    let names: Vec<_> =
        (0..model.joint_count()).map(|dof| model.joint_name(dof)).collect::<Result<_, _>>()?;
    let mut joints = Vec::new();
    for (dof, name) in names.iter().enumerate() {
        let joint = robot.joints.iter().find(|joint| joint.name == *name);
        let joint = joint.ok_or_else(|| format!("joint {name} is not in the file"))?;
        let (range, effort) =
            ([model.joint_lower_limit(dof)?, model.joint_upper_limit(dof)?], joint.limit.effort);
        if range[0] >= range[1] {
            return Err(format!(
                "joint {name} cannot move: its <limit> is missing, or no range from lower to upper (what turns without end has type=\"continuous\")"
            )
            .into());
        }
        if !(effort.is_finite() && effort >= 0.0) {
            return Err(format!("joint {name} has an effort of {effort}, not 0 or a positive number").into());
        }
        let mut mimic = None;
        if let Some(file) = &joint.mimic {
            let leader = names.iter().position(|other| *other == file.joint && other != name);
            let leader = leader.ok_or_else(|| {
                format!("joint {name} mimics {}, which is no other joint that moves", file.joint)
            })?;
            let (ratio, offset) = (file.multiplier.unwrap_or(1.0), file.offset.unwrap_or(0.0));
            mimic = Some(Mimic { leader, ratio, offset });
        }
        let angle = 0.0_f64.clamp(range[0], range[1]);
        let (range, effort) = match mimic {
            Some(_) => ([f64::NEG_INFINITY, f64::INFINITY], 0.0), // its leader's
            None => (range, effort),
        };
        joints.push(Joint { name: (*name).to_owned(), angle, range, effort, target: [angle, 0.0], mimic });
    }
    for _ in 0..joints.len() {
        for follower in 0..joints.len() {
            if let Some(mimic) = joints[follower].mimic {
                joints[follower].angle = mimic.ratio * joints[mimic.leader].angle + mimic.offset;
            }
        }
    }
    Ok(joints)
}
