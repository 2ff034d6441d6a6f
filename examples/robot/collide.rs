//! Where bodies are near each other: contact manifolds of `parry3d`.

use crate::Failure;
use nalgebra::{UnitQuaternion, Vector3};
use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::query::{
    ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher, TrackedContact,
};
use parry3d_f64::shape::{PackedFeatureId, SharedShape};

/// Points within this distance (m) become contacts: as far as 5 m/s go in a step.
const NEAR: f64 = 5e-3;

/// Points of a pair that are nearer each other (m) are one.
const MERGED: f64 = 5e-3;

/// Rounding of the edges of a block (m) in front of a hull: where the two just touch, parry may take any face of a sharp block.
const ROUND: f64 = 1e-3;

/// A convex shape of a link, or of the ground.
#[derive(Clone, Debug)]
pub struct Body {
    /// Name of the link.
    pub name: String,
    /// Which tree it belongs to: bodies of one tree do not collide. [`Self::GROUND`] does not move.
    pub tree: usize,
    pub(crate) link: usize,
    /// Where the shape is in its link.
    pub(crate) local: Pose,
    pub(crate) shape: SharedShape,
}

impl Body {
    /// The tree of what does not move.
    pub const GROUND: usize = usize::MAX;

    /// A block of ground between two corners (m).
    pub(crate) fn ground(name: &str, from: Vector3<f64>, to: Vector3<f64>) -> Self {
        let (centre, half) = ((from + to) / 2.0, (to - from) / 2.0);
        Self {
            name: name.into(),
            tree: Self::GROUND,
            link: 0,
            local: Pose::from_translation(Vector::new(centre.x, centre.y, centre.z)),
            shape: SharedShape::cuboid(half.x, half.y, half.z),
        }
    }

    /// Its shape; in front of a hull a block is rounded, with faces where they were.
    fn facing(&self, other: &Self) -> SharedShape {
        let hull = other.shape.as_convex_polyhedron().is_some();
        match self.shape.as_cuboid() {
            Some(block) if hull && block.half_extents.min_element() > ROUND => {
                let [x, y, z] = <[f64; 3]>::from(block.half_extents).map(|half| half - ROUND);
                SharedShape::round_cuboid(x, y, z, ROUND)
            }
            _ => self.shape.clone(),
        }
    }
}

/// A point at which two bodies are near each other.
pub(crate) struct Point {
    pub(crate) pair: [usize; 2],
    /// Where it is in the world.
    pub(crate) place: Vector3<f64>,
    /// The normal, from the first body to the second.
    pub(crate) normal: Vector3<f64>,
    pub(crate) gap: f64,
    pub(crate) key: u32,
}

/// A pose in the types of parry.
pub(crate) fn pose(place: Vector3<f64>, turn: &UnitQuaternion<f64>) -> Pose {
    let q = turn.coords;
    let place = Vector::new(place.x, place.y, place.z);
    Pose::from_parts(place, Rotation::from_xyzw(q.x, q.y, q.z, q.w))
}

/// A vector in the types of nalgebra.
pub(crate) fn vector(vector: Vector) -> Vector3<f64> {
    <[f64; 3]>::from(vector).into()
}

/// All points of bodies of different trees, for shapes at these poses, of which one at least can move: what is bolted down and
/// stands on the ground is no contact.
pub(crate) fn collide(
    bodies: &[Body],
    poses: &[Pose],
    can_move: impl Fn(usize) -> bool,
) -> Result<Vec<Point>, Failure> {
    let (mut points, mut key) = (Vec::new(), 0);
    let mut manifolds: Vec<ContactManifold<(), ()>> = Vec::new();
    for (a, first) in bodies.iter().enumerate() {
        for (b, second) in bodies.iter().enumerate().skip(a + 1) {
            if first.tree == second.tree || !(can_move(a) || can_move(b)) {
                continue;
            }
            key += 1; // the points of a pair follow one another
            let (relative, dispatcher) = (poses[a].inv_mul(&poses[b]), DefaultQueryDispatcher);
            manifolds.clear();
            let (one, other) = (first.facing(second), second.facing(first));
            dispatcher
                .contact_manifolds(&relative, &*one, &*other, NEAR, &mut manifolds, &mut None)
                .map_err(|error| error.to_string())?;
            for manifold in &manifolds {
                let normal = vector(poses[a].rotation * manifold.local_n1);
                // Beside the corners of what two faces or edges share, parry gives a point between them.
                let corner = |point: &&TrackedContact<()>| point.fid1 != PackedFeatureId::UNKNOWN;
                let shared = manifold.points.iter().filter(corner).count() >= 2;
                for point in manifold.points.iter().filter(|point| point.dist < NEAR) {
                    if shared && !corner(&point) {
                        continue;
                    }
                    let place = vector(poses[b] * point.local_p2);
                    let same = |other: &Point| other.key == key && (other.place - place).norm() < MERGED;
                    if points.iter().any(same) {
                        continue; // cylinders have some twice
                    }
                    points.push(Point { pair: [a, b], place, normal, gap: point.dist, key });
                }
            }
        }
    }
    Ok(points)
}
