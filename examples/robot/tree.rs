//! A tree of links from a URDF file, a robot or a thing: its dynamics from `dynibo`, and where it is.
//!
//! `dynibo` reads URDF and has `M`, bias forces and Jacobians of a floating base in world coordinates;
//! `phyz-rigid` 0.4 has no reader of URDF, and turns a free body by a rotation vector.

use crate::{Body, Failure};
use dynibo::FloatingRobot;
use nalgebra::{UnitQuaternion, Vector3};
use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::shape::SharedShape;
use std::ops::Range;
use std::path::Path;
use urdf_rs::Geometry;

/// Gravity of `dynibo` (m/s²).
pub const GRAVITY: f64 = 9.80665;

/// How the root link of a tree stands in the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Base {
    /// It is free: six velocities, angular and then linear (world), stand before those of the joints.
    Free,
    /// It is bolted down. (Its mass, though without effect, has to be positive.)
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
    /// Reads a tree and the bodies that its links have for collisions.
    pub(crate) fn load(file: &Path, base: Base) -> Result<(Self, Vec<Body>), Failure> {
        let named = |error: &dyn std::fmt::Display| format!("{}: {error}", file.display());
        let model = FloatingRobot::from_urdf(file).map_err(|error| named(&error))?;
        let urdf = urdf_rs::read_file(file).map_err(|error| named(&error))?; // dynibo does not tell shapes and efforts
        let (mut bodies, mut joints, mut bones) = (Vec::new(), Vec::new(), Vec::new());
        let mut links = Vec::new();
        for link in 0..model.link_count() {
            links.push(model.link_name(model.link_id_at(link)?)?.to_owned()); // in another order than in the file
        }
        let index = |name: &str| links.iter().position(|link| link == name);
        for link in &urdf.links {
            for collision in &link.collision {
                let ([x, y, z], [roll, pitch, yaw]) = (*collision.origin.xyz, *collision.origin.rpy);
                let turn = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
                let (shape, turn) = match &collision.geometry {
                    Geometry::Sphere { radius } => (SharedShape::ball(*radius), turn),
                    Geometry::Box { size } => {
                        let [x, y, z] = size.map(|length| length / 2.0);
                        (SharedShape::cuboid(x, y, z), turn)
                    }
                    Geometry::Cylinder { radius, length } => {
                        let upright = Vector3::x() * std::f64::consts::FRAC_PI_2; // parry's lie along y
                        let shape = SharedShape::cylinder(length / 2.0, *radius);
                        (shape, turn * UnitQuaternion::from_scaled_axis(upright))
                    }
                    other => return Err(named(&format!("no contacts for {other:?}")).into()),
                };
                bodies.push(Body {
                    name: link.name.clone(),
                    link: index(&link.name).unwrap_or(0),
                    tree: 0,
                    local: pose(Vector3::new(x, y, z), &turn),
                    shape,
                });
            }
        }
        for joint in &urdf.joints {
            let bone = index(&joint.parent.link).zip(index(&joint.child.link));
            let shaped = |link| bodies.iter().any(|body: &Body| body.link == link);
            bones.extend(bone.filter(|&(parent, _)| !shaped(parent)).map(<[usize; 2]>::from));
        }
        for dof in 0..model.joint_count() {
            let name = model.joint_name(dof)?;
            let joint = urdf.joints.iter().find(|joint| joint.name == name);
            let [lower, upper] = [model.joint_lower_limit(dof)?, model.joint_upper_limit(dof)?];
            let effort = joint.map_or(0.0, |joint| joint.limit.effort);
            if lower >= upper {
                let wrong = format!(
                    "joint {name} cannot move: its <limit> is missing, or no range from lower to upper"
                );
                return Err(named(&wrong).into());
            }
            if !(effort.is_finite() && effort >= 0.0) {
                let wrong = format!("joint {name} has an effort of {effort}, not 0 or a positive number");
                return Err(named(&wrong).into());
            }
            joints.push(Joint {
                name: name.to_owned(),
                angle: 0.0,
                range: [lower, upper],
                effort,
                target: [0.0; 2],
            });
        }
        let (place, turn) = (Vector3::zeros(), UnitQuaternion::identity());
        Ok((Self { model, base, joints, bones, place, turn }, bodies))
    }

    /// The joints without a motor.
    pub(crate) fn passive(&self) -> Vec<&str> {
        let passive = self.joints.iter().filter(|joint| joint.effort == 0.0);
        passive.map(|joint| &*joint.name).collect()
    }

    /// Which of six velocities of a base and those of the joints it has.
    pub(crate) fn kept(&self) -> Range<usize> {
        let skip = if self.base == Base::Bolted { 6 } else { 0 };
        skip..6 + self.joints.len()
    }

    /// How many velocities it has.
    pub(crate) fn size(&self) -> usize {
        self.kept().len()
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

/// A pose in the types of parry.
fn pose(place: Vector3<f64>, turn: &UnitQuaternion<f64>) -> Pose {
    let q = turn.coords;
    let place = Vector::new(place.x, place.y, place.z);
    Pose::from_parts(place, Rotation::from_xyzw(q.x, q.y, q.z, q.w))
}
