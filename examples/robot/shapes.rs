//! Shapes of links for collisions, in the form that `parry3d` takes: meshes become their convex hulls.

use crate::collide::pose;
use crate::{Failure, urdf};
use mesh_loader::Loader;
use nalgebra::{UnitQuaternion, Vector3};
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::shape::SharedShape;
use std::path::{Path, PathBuf};
use urdf_rs::{Collision, Geometry};

/// The shape of a link for collisions, and where it is in the link. Meshes are looked for around the robot's file.
pub(crate) fn shape(collision: &Collision, robot: &Path) -> Result<(SharedShape, Pose), Failure> {
    let origin = urdf::isometry(&collision.origin);
    let (place, turn) = (origin.translation.vector, origin.rotation);
    let shape = match &collision.geometry {
        Geometry::Sphere { radius } => SharedShape::ball(*radius),
        Geometry::Box { size } => {
            let [x, y, z] = size.map(|length| length / 2.0);
            SharedShape::cuboid(x, y, z)
        }
        Geometry::Capsule { radius, length } => SharedShape::capsule_z(length / 2.0, *radius),
        Geometry::Cylinder { radius, length } => {
            let upright = UnitQuaternion::from_scaled_axis(Vector3::x() * std::f64::consts::FRAC_PI_2);
            let shape = SharedShape::cylinder(length / 2.0, *radius); // parry's lies along y
            return Ok((shape, pose(place, &(turn * upright))));
        }
        Geometry::Mesh { filename, scale } => {
            let scale = scale.map_or([1.0; 3], |scale| *scale);
            hull(filename, scale, robot).map_err(|error| format!("mesh {filename}: {error}"))?
        }
    };
    Ok((shape, pose(place, &turn)))
}

/// The convex hull of a mesh.
fn hull(name: &str, scale: [f64; 3], robot: &Path) -> Result<SharedShape, Failure> {
    let file = find(name, robot)?;
    let mut bytes = std::fs::read(&file)?;
    // A binary STL file may begin as one of text does: with "solid". Its length tells.
    if let Some(&[a, b, c, d]) = bytes.get(80..84)
        && bytes.len() as u64 == 84 + 50 * u64::from(u32::from_le_bytes([a, b, c, d]))
    {
        bytes[..80].fill(0);
    }
    let scene = Loader::default().load_from_slice(&bytes, &file)?;
    let scaled = |point: &[f32; 3]| {
        let [x, y, z] = point.map(f64::from);
        Vector::new(x * scale[0], y * scale[1], z * scale[2])
    };
    let points: Vec<_> = scene.meshes.iter().flat_map(|mesh| mesh.vertices.iter().map(scaled)).collect();
    let hull = points.iter().all(|point| point.is_finite()).then(|| SharedShape::convex_hull(&points));
    hull.flatten().ok_or_else(|| "its points have no convex hull".into())
}

/// The file of a mesh. That of `package://name/…` is looked for beside each folder in which the robot's file is.
fn find(name: &str, robot: &Path) -> Result<PathBuf, Failure> {
    let robot = robot.canonicalize()?;
    let mut around = robot.ancestors().skip(1);
    if let Some(inside) = name.strip_prefix("package://") {
        let mut places = around.map(|folder| folder.join(inside.trim_start_matches('/')));
        return places
            .find(|place| place.is_file())
            .ok_or_else(|| "no folder around the file holds it".into());
    }
    let place = name.strip_prefix("file://").unwrap_or(name);
    Ok(around.next().map_or(place.into(), |folder| folder.join(place)))
}
