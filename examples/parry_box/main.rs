//! A box falls on its edge and comes to rest; `parry3d` finds the contacts.
//!
//! The collision library gives a contact manifold: a normal and points with their distances. Each
//! point becomes a contact of the scene, with its gap as offset, so that contacts may be found
//! before they close. The points' feature ids are the keys that a warm start follows.
//!
//! `cargo run --release -p parry_box [FILE.svg]`

use nalgebra::{Matrix3, SMatrix, SVector, UnitQuaternion, Vector3, vector};
use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};
use parry3d_f64::shape::Cuboid;
use pictures::{curve, panel};
use std::error::Error;
use stiction::time_stepping::{Gap, free_impulse};
use stiction::{Contact, Factor, Scene, Settings, Solver, Status};

const STEP: f64 = 1e-3;
const MASS: f64 = 2.0;
const HALF: Vector3<f64> = Vector3::new(0.1, 0.08, 0.05);
const MU: f64 = 0.4;
/// A penetration is pushed out at 0.1 m/s at most; nothing closes faster than 10 m/s.
const GAP: Gap<f64> = Gap { distance: 0.0, recovery: 0.1, reach: 10.0 };

/// The body: where it is and how it moves, in world coordinates.
struct Body {
    centre: Vector3<f64>,
    orientation: UnitQuaternion<f64>,
    /// Of the centre, then angular.
    velocity: SVector<f64, 6>,
}

impl Body {
    fn pose(&self) -> Pose {
        let [x, y, z] = self.centre.into();
        let q = self.orientation.coords;
        Pose::from_parts(Vector::new(x, y, z), Rotation::from_xyzw(q.x, q.y, q.z, q.w))
    }

    /// Mass matrix, and weight with the gyroscopic moment `-w x I w`.
    fn dynamics(&self) -> (SMatrix<f64, 6, 6>, SVector<f64, 6>) {
        let squares = HALF.component_mul(&HALF);
        let inertia = (Vector3::repeat(squares.sum()) - squares) * (MASS / 3.0);
        let turn = self.orientation.to_rotation_matrix();
        let inertia = turn * Matrix3::from_diagonal(&inertia) * turn.inverse();
        let mut mass = SMatrix::<f64, 6, 6>::identity() * MASS;
        mass.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia);
        let spin = Vector3::from(self.velocity.fixed_rows::<3>(3));
        let moment = -spin.cross(&(inertia * spin));
        (mass, vector![0.0, 0.0, -9.81 * MASS, moment.x, moment.y, moment.z])
    }

    fn advance(&mut self, velocity: SVector<f64, 6>) {
        self.velocity = velocity;
        self.centre += velocity.fixed_rows::<3>(0) * STEP;
        let spin = velocity.fixed_rows::<3>(3) * STEP;
        self.orientation = UnitQuaternion::from_scaled_axis(spin) * self.orientation;
    }
}

/// Velocity of the point of the body at `arm` from its centre.
fn point_jacobian(arm: &Vector3<f64>) -> SMatrix<f64, 3, 6> {
    let mut jacobian = SMatrix::<f64, 3, 6>::identity();
    let mut turning = jacobian.fixed_view_mut::<3, 3>(0, 3);
    turning.copy_from(&-arm.cross_matrix());
    jacobian
}

fn main() -> Result<(), Box<dyn Error>> {
    let floor = Cuboid::new(Vector::new(2.0, 2.0, 0.5));
    let below = Pose::from_translation(Vector::new(0.0, 0.0, -0.5));
    let cuboid = Cuboid::new(Vector::new(HALF.x, HALF.y, HALF.z));
    let mut manifolds: Vec<ContactManifold<(), ()>> = Vec::new();

    let mut body = Body {
        centre: vector![-0.4, 0.0, 0.3],
        orientation: UnitQuaternion::from_euler_angles(0.3, 0.6, 0.0),
        velocity: vector![1.2, 0.3, 0.0, 0.0, 4.0, 2.0],
    };
    let mut scene = Scene::<f64, 6, 3, 8>::new();
    let mut factor = Factor::empty();
    let mut solver = Solver::new();
    let settings = Settings::new(1e-9);
    let (mut height, mut speed, mut touching) = (Vec::new(), Vec::new(), Vec::new());
    for step in 1..=800 {
        let pose = body.pose();
        let relative = below.inv_mul(&pose);
        let (near, dispatcher) = (0.02, DefaultQueryDispatcher);
        dispatcher
            .contact_manifolds(&relative, &floor, &cuboid, near, &mut manifolds, &mut None)
            .map_err(|error| error.to_string())?;

        let (mass, force) = body.dynamics();
        scene.set_mass(&mass)?;
        scene.clear_contacts();
        for manifold in &manifolds {
            let normal = Vector3::from(<[f64; 3]>::from(below.rotation * manifold.local_n1));
            for point in &manifold.points {
                let place = Vector3::from(<[f64; 3]>::from(pose * point.local_p2));
                let velocity = point_jacobian(&(place - body.centre));
                let distance = point.dist;
                scene.push(&Contact {
                    offset: vector![Gap { distance, ..GAP }.offset(STEP)?, 0.0, 0.0],
                    ..Contact::at_point(&normal, &velocity, MU, point.fid2.0)?
                })?;
            }
        }

        factor.prepare(&scene)?;
        let push = free_impulse(&mass, &body.velocity, &force, STEP);
        let solution = solver.solve(&scene, &factor, &push, &settings)?;
        if solution.status != Status::Solved {
            return Err(format!("step {step}: {:?}", solution.status).into());
        }
        let pressed = solution.contacts.iter().filter(|c| c.impulse[0] > 0.0);
        let time = STEP * f64::from(step);
        touching.push((time, f64::from(u32::try_from(pressed.count())?)));
        body.advance(solution.velocity);
        height.push((time, body.centre.z));
        speed.push((time, body.velocity.fixed_rows::<3>(0).norm()));
    }
    let [x, y, z] = body.centre.into();
    let left = body.velocity.norm();
    println!("rests at ({x:.3}, {y:.3}, {z:.4}) m, velocity {left:.1e}");
    let height = panel(
        "A box thrown on its edge, contacts from parry3d",
        "time (s)",
        "height of the centre (m)",
        [curve("", height)],
    );
    let speed = panel("Its speed", "time (s)", "speed (m/s)", [curve("", speed)]);
    let (title, carrying) = ("What carries it", "contacts with an impulse");
    let touching = panel(title, "time (s)", carrying, [curve("", touching)]);
    pictures::draw("parry_box", &[height, speed, touching])
}
