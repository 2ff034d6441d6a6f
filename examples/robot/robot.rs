//! The robot: its description from a URDF file, its dynamics from `dynibo`, and where it is.
//!
//! `dynibo` reads URDF and has `M`, bias forces and Jacobians of a floating base in world coordinates, without allocation;
//! `phyz-rigid` 0.4 has no reader of URDF, allocates its matrices, and turns a free body by a rotation vector.

use dynibo::{BaseState, FloatingRobot, Frame, Twist};
use nalgebra::{SMatrix, SVector, UnitQuaternion, Vector3};
use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::shape::SharedShape;
use std::error::Error;
use std::path::Path;
use urdf_rs::Geometry;

pub(crate) const JOINTS: usize = 12;
/// Generalised velocities: angular and linear of the torso (world), then of the joints.
pub(crate) const N: usize = 6 + JOINTS;
pub(crate) const LEGS: [&str; 4] = ["FL", "FR", "RL", "RR"];
const PARTS: [&str; 4] = ["hip", "thigh", "calf", "foot"];

/// A link that may touch something, and which leg's foot it is; its shape is centred at its frame.
pub(crate) struct Body {
    link: usize,
    pub(crate) foot: Option<usize>,
    pub(crate) shape: SharedShape,
}

/// A joint: its place leg by leg, its range (rad), and the largest torque of its motor (N m).
pub(crate) struct Joint {
    pub(crate) index: usize,
    pub(crate) range: [f64; 2],
    pub(crate) effort: f64,
}

pub(crate) struct Robot {
    model: FloatingRobot,
    pub(crate) joints: Vec<Joint>,
    pub(crate) bodies: Vec<Body>,
    /// The links of each leg, from the hip to the foot.
    legs: [[usize; 4]; 4],
    pub(crate) place: Vector3<f64>,
    pub(crate) turn: UnitQuaternion<f64>,
    pub(crate) angles: [f64; JOINTS],
    pub(crate) velocity: SVector<f64, N>,
}

/// `M`, the bias forces (Coriolis, centrifugal, weight), and of each body its pose and the Jacobian of that.
pub(crate) struct Dynamics {
    pub(crate) mass: SMatrix<f64, N, N>,
    pub(crate) bias: SVector<f64, N>,
    pub(crate) poses: Vec<Pose>,
    pub(crate) jacobians: Vec<SMatrix<f64, 6, N>>,
    /// Joints of each leg from the hip to the foot, to be drawn.
    pub(crate) legs: [[Vector3<f64>; 4]; 4],
}

/// Leg and part that a name such as `FL_hip` stands for.
fn place(name: &str) -> Option<(usize, usize)> {
    let (leg, part) = name.split_once('_')?;
    let leg = LEGS.iter().position(|&name| name == leg)?;
    Some((leg, PARTS.iter().position(|&name| name == part)?))
}

impl Robot {
    pub(crate) fn load(file: &Path) -> Result<Self, Box<dyn Error>> {
        let model = FloatingRobot::from_urdf(file)?;
        let urdf = urdf_rs::read_file(file)?; // dynibo does not tell shapes and efforts
        let (mut bodies, mut joints, mut legs) = (Vec::new(), Vec::new(), [[0; 4]; 4]);
        for link in 0..model.link_count() {
            let name = model.link_name(model.link_id_at(link)?)?;
            if let Some((leg, part)) = place(name) {
                legs[leg][part] = link;
            }
            let described = urdf.links.iter().filter(|link| link.name == name);
            for collision in described.flat_map(|link| &link.collision) {
                let shape = match &collision.geometry {
                    Geometry::Sphere { radius } => SharedShape::ball(*radius),
                    Geometry::Box { size } => {
                        let [x, y, z] = size.map(|length| length / 2.0);
                        SharedShape::cuboid(x, y, z)
                    }
                    other => return Err(format!("no contacts for {other:?}").into()),
                };
                let foot = place(name)
                    .filter(|place| place.1 == 3)
                    .map(|place| place.0);
                bodies.push(Body { link, foot, shape });
            }
        }
        for dof in 0..model.joint_count() {
            let name = model.joint_name(dof)?; // in another order than in the file
            let (leg, part) = place(name).ok_or("an unknown joint")?;
            let joint = urdf.joints.iter().find(|joint| joint.name == name);
            let limit = &joint.ok_or("a joint is missing")?.limit;
            joints.push(Joint {
                index: 3 * leg + part,
                range: [limit.lower, limit.upper],
                effort: limit.effort,
            });
        }
        Ok(Self {
            model,
            joints,
            bodies,
            legs,
            place: Vector3::zeros(),
            turn: UnitQuaternion::identity(),
            angles: [0.0; JOINTS],
            velocity: SVector::zeros(),
        })
    }

    pub(crate) fn dynamics(&mut self) -> dynibo::Result<Dynamics> {
        // `dynibo` stands on another nalgebra than stiction: numbers go across as arrays.
        let array = |vector: Vector3<f64>| <[f64; 3]>::from(vector);
        let part = |first| array(self.velocity.fixed_rows::<3>(first).into()).into();
        let turn = array(self.turn.scaled_axis()).into();
        let frame = Frame::new(array(self.place).into(), turn);
        let base = BaseState::new(frame, Twist::new(part(0), part(3)), Twist::zeros())?;
        let (model, angles) = (&mut self.model, &self.angles);
        let (rates, still) = (&self.velocity.as_slice()[6..], [0.0; JOINTS]);
        let (mut mass, mut bias) = (SMatrix::<f64, N, N>::zeros(), SVector::<f64, N>::zeros());
        model.mass_matrix(&base, angles, mass.as_mut_slice())?;
        model.inverse_dynamics(&base, angles, rates, &still, &[], bias.as_mut_slice())?;
        let mut frames = vec![Frame::identity(); model.link_count()];
        model.forward_kinematics_all(&base, angles, &mut frames)?;
        let (mut poses, mut jacobians) = (Vec::new(), Vec::new());
        for body in &self.bodies {
            let (p, q) = (frames[body.link].translation, frames[body.link].rotation);
            let turn = Rotation::from_xyzw(q.i, q.j, q.k, q.w);
            poses.push(Pose::from_parts(Vector::new(p.x, p.y, p.z), turn));
            let mut jacobian = SMatrix::<f64, 6, N>::zeros();
            let link = model.link_id_at(body.link)?;
            model.jacobian(&base, angles, link, jacobian.as_mut_slice())?;
            jacobians.push(jacobian);
        }
        let at = |link: usize| <[f64; 3]>::from(frames[link].translation.vector).into();
        let legs = self.legs.map(|leg| leg.map(at));
        Ok(Dynamics {
            mass,
            bias,
            poses,
            jacobians,
            legs,
        })
    }

    /// Moves on with the velocities at the end of a step.
    pub(crate) fn advance(&mut self, velocity: SVector<f64, N>, step: f64) {
        self.velocity = velocity;
        let turn = velocity.fixed_rows::<3>(0) * step;
        self.turn = UnitQuaternion::from_scaled_axis(turn) * self.turn;
        self.place += velocity.fixed_rows::<3>(3) * step;
        for (angle, rate) in self.angles.iter_mut().zip(velocity.iter().skip(6)) {
            *angle += rate * step;
        }
    }
}
