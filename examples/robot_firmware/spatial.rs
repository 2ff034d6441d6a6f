//! Velocities, momenta and inertias of rigid bodies, all in world axes and about one point, the origin of the torso.

use super::model::{Axis, Body};
use nalgebra::{ArrayStorage, Matrix3, Vector3};

/// Motion of a link.
#[derive(Clone, Copy)]
pub(crate) struct Motion {
    pub(crate) velocity: Spatial,
    pub(crate) acceleration: Spatial,
}

/// Axes of a link: three unit vectors in world axes.
#[derive(Clone, Copy)]
pub(crate) struct Axes(pub(crate) [Vector3<f32>; 3]);

impl Axes {
    /// Turns a vector from the link to the world. It is given for the front left leg; the signs are those of the leg.
    pub(crate) fn vector(&self, [x, y, z]: [f32; 3], [ahead, left]: [f32; 2]) -> Vector3<f32> {
        self.0[0] * (ahead * x) + self.0[1] * (left * y) + self.0[2] * z
    }

    /// Returns the axes of the next link, which is turned by an angle (rad), and the axis of its hinge.
    pub(crate) fn turned(&self, axis: &Axis, angle: f32) -> (Self, Vector3<f32>) {
        let ([x, y, z], (sin, cos)) = (self.0, sin_cos(angle));
        match axis {
            Axis::X => (Self([x, y * cos + z * sin, z * cos - y * sin]), x),
            Axis::Y => (Self([x * cos - z * sin, y, x * sin + z * cos]), y),
        }
    }
}

/// Spatial vector of a rigid body: angular and linear velocity (rad/s, m/s), momentum (N·m·s, N·s), or moment and force (N·m, N). The linear
/// velocity is that of the point of the body at the origin of the torso; moments are about this origin.
#[derive(Clone, Copy)]
pub(crate) struct Spatial {
    pub(crate) angular: Vector3<f32>,
    pub(crate) linear: Vector3<f32>,
}

impl Spatial {
    pub(crate) const fn new(angular: Vector3<f32>, linear: Vector3<f32>) -> Self {
        Self { angular, linear }
    }

    /// Returns the power of a force with this velocity.
    pub(crate) fn dot(&self, other: &Self) -> f32 {
        self.angular.dot(&other.angular) + self.linear.dot(&other.linear)
    }

    /// Adds a multiple of another vector.
    pub(crate) fn plus(&self, other: &Self, factor: f32) -> Self {
        Self { angular: self.angular + other.angular * factor, linear: self.linear + other.linear * factor }
    }

    /// Returns the rate at which a velocity changes because this velocity carries it along.
    pub(crate) fn cross_motion(&self, other: &Self) -> Self {
        Self {
            angular: self.angular.cross(&other.angular),
            linear: self.angular.cross(&other.linear) + self.linear.cross(&other.angular),
        }
    }

    /// Returns the rate at which a momentum changes because this velocity carries it along.
    pub(crate) fn cross_force(&self, other: &Self) -> Self {
        Self {
            angular: self.angular.cross(&other.angular) + self.linear.cross(&other.linear),
            linear: self.angular.cross(&other.linear),
        }
    }

    /// Returns all six numbers, angular ones first.
    pub(crate) fn entries(&self) -> [f32; 6] {
        let ([a, b, c], [x, y, z]) = (self.angular.into(), self.linear.into());
        [a, b, c, x, y, z]
    }
}

/// Inertia of one body, or of several that move as one, about the origin of the torso.
#[derive(Clone, Copy)]
pub(crate) struct Inertia {
    /// Mass (kg).
    mass: f32,
    /// First moment (kg m): mass times centre of mass.
    first: Vector3<f32>,
    /// Moments of inertia (kg m²).
    second: Matrix3<f32>,
}

impl Inertia {
    /// Inertia of nothing.
    pub(crate) const NONE: Self = Self {
        mass: 0.0,
        first: Vector3::from_array_storage(ArrayStorage([[0.0; 3]; 1])),
        second: Matrix3::from_array_storage(ArrayStorage([[0.0; 3]; 3])),
    };

    /// Makes that of a body from the axes of its link and its centre of mass (m), both in the world.
    pub(crate) fn new(body: &Body, axes: &Axes, centre: &Vector3<f32>) -> Self {
        // Exactly symmetric, as `M` is to be: a product of entries comes first.
        let ([x, y, z], [about_x, about_y, about_z]) = (axes.0, body.inertia);
        let square = |v: &Vector3<f32>| v * v.transpose();
        let own = square(&x) * about_x + square(&y) * about_y + square(&z) * about_z;
        let parallel = Matrix3::from_diagonal_element(centre.dot(centre)) - square(centre);
        Self { mass: body.mass, first: centre * body.mass, second: own + parallel * body.mass }
    }

    /// Adds another body, which moves as one with this.
    pub(crate) fn add(&mut self, other: &Self) {
        self.mass += other.mass;
        self.first += other.first;
        self.second += other.second;
    }

    /// Returns the momentum at a velocity, or the force for an acceleration from rest.
    pub(crate) fn momentum(&self, velocity: &Spatial) -> Spatial {
        let Spatial { angular, linear } = velocity;
        Spatial {
            angular: self.second * angular + self.first.cross(linear),
            linear: linear * self.mass - self.first.cross(angular),
        }
    }

    /// Returns the force that a motion takes (equations of Newton and Euler).
    pub(crate) fn force(&self, motion: &Motion) -> Spatial {
        let Motion { velocity, acceleration } = motion;
        let carried = velocity.cross_force(&self.momentum(velocity));
        self.momentum(acceleration).plus(&carried, 1.0)
    }
}

/// Returns sine and cosine of the angle (rad) of a joint, to 1e-7. (`libm` computes them in f64, for which a Cortex-M4F has no hardware.)
#[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss)] // a joint turns a few times at most
pub(crate) fn sin_cos(angle: f32) -> (f32, f32) {
    /// A quarter turn in two parts: small multiples of the first are exact.
    const QUARTER: [f32; 2] = [1.570_312_5, 4.838_268e-4];
    let half = if angle < 0.0 { -0.5 } else { 0.5 };
    let quarters = (angle * core::f32::consts::FRAC_2_PI + half) as i32;
    let x = angle - quarters as f32 * QUARTER[0] - quarters as f32 * QUARTER[1];
    let y = x * x;
    let sin = x + x * y * (-1.0 / 6.0 + y * (1.0 / 120.0 + y * (-1.0 / 5040.0 + y / 362_880.0)));
    let cos = 1.0 + y * (-0.5 + y * (1.0 / 24.0 + y * (-1.0 / 720.0 + y / 40_320.0)));
    match quarters & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}
