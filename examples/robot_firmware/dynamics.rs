//! Kinematics and dynamics of a quadruped of twelve motors: `M`, bias forces, feet and their Jacobians. No allocation, no panic.
//!
//! Composite rigid bodies give `M`, the recursive Newton-Euler algorithm the bias (R. Featherstone, *Rigid Body Dynamics Algorithms*,
//! 2008). All vectors are in world axes, all moments about the origin of the torso: so inertias are added as they are. The 18 velocities
//! `v` are the angular (rad/s) and the linear velocity (m/s) of the torso, then hip, thigh and calf (rad/s) of each leg.
//! The robot is `examples/robot/quadruped.urdf`; that package tests this file against `dynibo`.

use super::model::{FOOT, GRAVITY, LEGS, LINKS, RADIUS, TORSO};
use super::spatial::{Axes, Inertia, Motion, Spatial};
use nalgebra::{ArrayStorage, Matrix3, SMatrix, SVector, UnitQuaternion, Vector3};
use stiction::Contact;

/// Number of velocities.
pub(crate) const N: usize = 18;

/// State of the robot, as encoders, inertial unit and an estimator tell it.
#[derive(Clone, Copy)]
pub(crate) struct State {
    /// Orientation of the torso.
    pub(crate) turn: UnitQuaternion<f32>,
    /// Angles (rad) of hip, thigh and calf of each leg.
    pub(crate) angles: [[f32; 3]; 4],
    /// Velocity `v`.
    pub(crate) velocity: SVector<f32, N>,
}

/// Foot: the point at which it touches level ground.
#[derive(Clone, Copy)]
pub(crate) struct Foot {
    /// Place of the point (m) from the origin of the torso, in world axes.
    pub(crate) point: Vector3<f32>,
    /// Jacobian (m), 3 × 3, from the rates of the joints of its leg to the velocity of the point.
    pub(crate) jacobian: Matrix3<f32>,
}

impl Foot {
    /// Returns the contact of foot `key` with level ground: rows upwards (the normal), ahead and to the left. The offset (m/s) is the
    /// gap over the time step.
    pub(crate) fn contact(&self, offset: f32, mu: f32, key: u32) -> Contact<f32, N, 3> {
        let (mut jacobian, [[x, y, z]]) = (SMatrix::<f32, 3, N>::zeros(), self.point.data.0);
        // Columns of the torso, which turns about x, y and z and moves along them.
        let torso =
            [[y, 0.0, -z], [-x, z, 0.0], [0.0, -y, x], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
        for (column, velocity) in jacobian.data.0.iter_mut().zip(torso) {
            *column = velocity;
        }
        let joints = jacobian.data.0.iter_mut().skip(6 + 3 * key as usize);
        for (column, &[x, y, z]) in joints.zip(&self.jacobian.data.0) {
            *column = [z, x, y];
        }
        let offset = Vector3::new(offset, 0.0, 0.0);
        Contact { jacobian, offset, mu, key }
    }
}

/// Dynamics of a state: `M`, bias and feet.
pub(crate) struct Dynamics {
    /// Mass matrix `M`, 18 × 18 (kg, kg m, kg m²). The blocks between legs are zero.
    pub(crate) mass: SMatrix<f32, N, N>,
    /// Bias (N·m, N): the forces without which weight, Coriolis and centrifugal forces would accelerate the robot.
    pub(crate) bias: SVector<f32, N>,
    /// Feet: front left, front right, rear left, rear right.
    pub(crate) feet: [Foot; 4],
}

impl Dynamics {
    pub(crate) const fn new() -> Self {
        const FOOT: Foot = Foot {
            point: Vector3::from_array_storage(ArrayStorage([[0.0; 3]; 1])),
            jacobian: Matrix3::from_array_storage(ArrayStorage([[0.0; 3]; 3])),
        };
        Self {
            mass: SMatrix::from_array_storage(ArrayStorage([[0.0; N]; N])),
            bias: SVector::from_array_storage(ArrayStorage([[0.0; N]; 1])),
            feet: [FOOT; 4],
        }
    }

    /// Computes them. What is not finite in the state comes out as what is not finite.
    pub(crate) fn update(&mut self, state: &State) {
        let [[a, b, c, _, _, _, rates @ ..]] = state.velocity.data.0;
        let [x, y, z] = state.turn.to_rotation_matrix().into_inner().data.0;
        let axes = Axes([x.into(), y.into(), z.into()]);
        // The bias does not depend on the linear velocity. Weight is an acceleration upwards.
        let motion = Motion {
            velocity: Spatial::new(Vector3::new(a, b, c), Vector3::zeros()),
            acceleration: Spatial::new(Vector3::zeros(), Vector3::z() * GRAVITY),
        };
        let mut inertia = Inertia::new(&TORSO, &axes, &axes.vector(TORSO.centre, [1.0; 2]));
        let mut force = inertia.force(&motion);

        let joints = state.angles.iter().zip(rates.as_chunks().0);
        let feet = LEGS.iter().zip(&mut self.feet);
        for (index, ((angles, rates), (&signs, foot))) in joints.zip(feet).enumerate() {
            let leg = Leg::new(signs, &axes, &motion, angles, rates);
            inertia.add(&leg.inertia);
            force = force.plus(&leg.force, 1.0);
            leg.set(index, &mut self.mass, &mut self.bias);
            *foot = leg.foot;
        }
        set(self.bias.as_mut_slice(), 0, &force.entries());
        // Columns of the torso: momenta of the whole robot as one body that turns about an axis or moves along it.
        let units = Matrix3::<f32>::identity().data.0.map(Vector3::from);
        let turns = units.map(|axis| Spatial::new(axis, Vector3::zeros()));
        let moves = units.map(|axis| Spatial::new(Vector3::zeros(), axis));
        let columns = self.mass.data.0.iter_mut();
        for (column, velocity) in columns.zip(turns.iter().chain(&moves)) {
            set(column, 0, &inertia.momentum(velocity).entries());
        }
    }
}

/// Part of a leg in the dynamics.
struct Leg {
    foot: Foot,
    inertia: Inertia,
    /// Force that moves it as the torso and the rates of its joints tell.
    force: Spatial,
    /// Bias of its joints (N·m).
    bias: [f32; 3],
    /// Momentum of it at a rate of 1 of each joint: the blocks of `M` between leg and torso.
    momenta: [[f32; 6]; 3],
    /// Block of `M` of its own joints.
    block: [[f32; 3]; 3],
}

impl Leg {
    fn new(signs: [f32; 2], torso: &Axes, motion: &Motion, angles: &[f32; 3], rates: &[f32; 3]) -> Self {
        // From torso to foot: places, velocities, accelerations, and the force that each link takes.
        let (mut axes, mut place, mut motion) = (*torso, Vector3::zeros(), *motion);
        let mut joints = [Spatial::new(Vector3::zeros(), Vector3::zeros()); 3];
        let mut forces = joints;
        let mut inertias = LINKS.each_ref().map(|_| Inertia::NONE);
        let outputs = joints.iter_mut().zip(forces.iter_mut().zip(&mut inertias));
        for (((link, &angle), &rate), (joint, (force, inertia))) in
            LINKS.iter().zip(angles).zip(rates).zip(outputs)
        {
            place += axes.vector(link.hinge, signs);
            let (turned, axis) = axes.turned(&link.axis, angle);
            axes = turned;
            *joint = Spatial::new(axis, place.cross(&axis));
            let carried = motion.velocity.cross_motion(joint);
            motion.acceleration = motion.acceleration.plus(&carried, rate);
            motion.velocity = motion.velocity.plus(joint, rate);
            let centre = place + axes.vector(link.body.centre, signs);
            *inertia = Inertia::new(&link.body, &axes, &centre);
            *force = inertia.force(&motion);
        }
        let point = place + axes.vector(FOOT, signs) - Vector3::z() * RADIUS;
        let jacobian = joints.map(|joint| joint.linear + joint.angular.cross(&point));

        // From foot to torso: each joint moves all links beyond it as one body, and bears their forces.
        let mut leg = Self {
            foot: Foot { point, jacobian: Matrix3::from_columns(&jacobian) },
            inertia: Inertia::NONE,
            force: Spatial::new(Vector3::zeros(), Vector3::zeros()),
            bias: [0.0; 3],
            momenta: [[0.0; 6]; 3],
            block: [[0.0; 3]; 3],
        };
        let outputs = leg.momenta.iter_mut().zip(&mut leg.block);
        let bodies = inertias.iter().zip(&forces);
        let links = joints.iter().zip(bodies).zip(leg.bias.iter_mut().zip(outputs));
        for ((joint, (inertia, force)), (bias, (momentum, row))) in links.rev() {
            leg.inertia.add(inertia);
            leg.force = leg.force.plus(force, 1.0);
            *bias = joint.dot(&leg.force);
            let moved = leg.inertia.momentum(joint);
            *momentum = moved.entries();
            *row = joints.each_ref().map(|other| other.dot(&moved)); // those beyond the diagonal are not right yet
        }
        let [[_, a, b], [below_a, _, c], [below_b, below_c, _]] = &mut leg.block;
        (*a, *b, *c) = (*below_a, *below_b, *below_c);
        leg
    }

    /// Writes its rows and columns of `M`, and its bias.
    fn set(&self, index: usize, mass: &mut SMatrix<f32, N, N>, bias: &mut SVector<f32, N>) {
        let first = 6 + 3 * index;
        set(bias.as_mut_slice(), first, &self.bias);
        let columns = mass.data.0.iter_mut().skip(first);
        for ((column, momentum), row) in columns.zip(&self.momenta).zip(&self.block) {
            set(column, 0, momentum);
            set(column, first, row);
        }
        let [first_row, second_row, third_row] = self.momenta;
        let rows = first_row.into_iter().zip(second_row).zip(third_row);
        for (column, ((hip, thigh), calf)) in mass.data.0.iter_mut().zip(rows) {
            set(column, first, &[hip, thigh, calf]);
        }
    }
}

/// Writes values into a column, from its entry `first` on.
fn set(column: &mut [f32], first: usize, values: &[f32]) {
    for (entry, &value) in column.iter_mut().skip(first).zip(values) {
        *entry = value;
    }
}
