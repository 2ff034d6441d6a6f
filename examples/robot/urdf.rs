//! What a URDF file says, and the dynamics of it in the form that `dynibo` takes.

use crate::Failure;
use dynibo::FloatingRobot;
use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use roxmltree::Document;
use std::io::Write;
use std::path::Path;
use urdf_rs::{Inertia, Inertial, JointType, Link, Mass, Pose, Robot, Vec3};

/// An inertia below this times the mass (m²) is what rounding left of 0, and may be negative.
const NOISE: f64 = 1e-15;

/// Reads a file, without what is only to be seen: faults there do not matter.
pub(crate) fn read(file: &Path) -> Result<Robot, Failure> {
    let text = std::fs::read_to_string(file)?;
    let document = Document::parse(&text)?;
    let seen = document.root_element().descendants().filter(|node| {
        let material = node.has_tag_name("material") && node.parent() == Some(document.root_element());
        material || node.has_tag_name("visual")
    });
    let ranges: Vec<_> = seen.map(|node| node.range()).collect();
    let mut text = text.clone();
    for range in ranges.into_iter().rev() {
        text.replace_range(range, "");
    }
    let robot = urdf_rs::read_from_string(&text)?;
    if robot.links.is_empty() {
        return Err("it has no links".into());
    }
    Ok(robot)
}

/// The dynamics of a robot, without its `<mimic>`, which `dynibo` does not take.
pub(crate) fn dynamics(robot: &Robot) -> Result<FloatingRobot, Failure> {
    let mut plain = robot.clone();
    plain.links.iter_mut().for_each(|link| link.collision.clear());
    plain.joints.iter_mut().for_each(|joint| joint.mimic = None);
    lump(&mut plain)?;
    let mass = &mut plain.links[root(robot)].inertial.mass.value;
    if *mass == 0.0 {
        *mass = f64::MIN_POSITIVE; // dynibo wants a mass; added to any other, this one is lost in rounding
    }
    let mut file = tempfile::NamedTempFile::new()?; // dynibo reads files only
    file.write_all(urdf_rs::write_to_string(&plain)?.as_bytes())?;
    Ok(FloatingRobot::from_urdf(file.path())?)
}

/// The link that is no joint's child; of several, as of none, the first link.
pub(crate) fn root(robot: &Robot) -> usize {
    let free = |link: &Link| !robot.joints.iter().any(|joint| joint.child.link == link.name);
    robot.links.iter().position(free).unwrap_or(0)
}

/// Gives a link the mass and inertia of all that is fixed to it, since what is rigid has one inertia. So a root may be without
/// mass, and the inertia of a small part not positive.
fn lump(robot: &mut Robot) -> Result<(), Failure> {
    let mut parts = Vec::new();
    for Link { name, inertial, .. } in &robot.links {
        let mass = inertial.mass.value;
        if !(mass.is_finite() && mass >= 0.0) {
            return Err(format!("link {name} has a mass of {mass}, not 0 or a positive number").into());
        }
        let (carrier, place) = carrier(robot, name);
        let place = place * isometry(&inertial.origin);
        let Inertia { ixx, ixy, ixz, iyy, iyz, izz } = inertial.inertia;
        let own = Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz);
        let turn = place.rotation.to_rotation_matrix();
        let own = if own.amax() < NOISE * mass { Matrix3::zeros() } else { turn * own * turn.inverse() };
        parts.push((carrier, mass, place.translation.vector, own));
    }
    for link in &mut robot.links {
        let parts = || parts.iter().filter(|(carrier, ..)| *carrier == link.name);
        let value: f64 = parts().map(|(_, mass, ..)| mass).sum();
        let moment: Vector3<f64> = parts().map(|(_, mass, centre, _)| centre * *mass).sum();
        let centre = if value > 0.0 { moment / value } else { moment };
        let about = |(_, mass, place, own): &(_, f64, Vector3<f64>, Matrix3<f64>)| {
            let arm = (place - centre).cross_matrix();
            own - arm * arm * *mass
        };
        let [[ixx, ..], [ixy, iyy, _], [ixz, iyz, izz]] = parts().map(about).sum::<Matrix3<f64>>().data.0;
        let origin = Pose { xyz: Vec3(centre.into()), rpy: Vec3::default() };
        let inertia = Inertia { ixx, ixy, ixz, iyy, iyz, izz };
        link.inertial = Inertial { origin, mass: Mass { value }, inertia };
    }
    Ok(())
}

/// The link to which a link is fixed, over any number of joints, and where the second is in the first.
fn carrier(robot: &Robot, link: &str) -> (String, Isometry3<f64>) {
    let (mut carrier, mut place) = (link, Isometry3::identity());
    for _ in &robot.joints {
        let fixed = robot
            .joints
            .iter()
            .find(|joint| joint.child.link == carrier && joint.joint_type == JointType::Fixed);
        let Some(joint) = fixed else { break };
        (carrier, place) = (&joint.parent.link, isometry(&joint.origin) * place);
    }
    (carrier.to_owned(), place)
}

/// A pose of a file.
pub(crate) fn isometry(pose: &Pose) -> Isometry3<f64> {
    let ([x, y, z], [roll, pitch, yaw]) = (*pose.xyz, *pose.rpy);
    let turn = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    Isometry3::from_parts(Translation3::new(x, y, z), turn)
}
