//! A box with four corner contacts on a plane.

use nalgebra::{SMatrix, SVector, Vector3, matrix, vector};
use stiction::{Contact, Error, Real, Scene};

/// Velocity of the centre, then angular velocity, along (down the slope, across, out of the plane).
pub(crate) type BoxScene<T> = Scene<T, 6, 3, 4>;

/// Acceleration of gravity, m/s².
pub(crate) const GRAVITY: f64 = 9.81;

/// A homogeneous box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cuboid {
    /// kg
    pub(crate) mass: f64,
    /// Half edges along (down the slope, across, out of the plane), m.
    pub(crate) half: [f64; 3],
}

/// 2 kg, twice as long as high.
pub(crate) const BRICK: Cuboid = Cuboid { mass: 2.0, half: [0.1, 0.08, 0.05] };

/// The contact of a block in a plane, which moves along (x, height), with the floor.
pub(crate) fn planar_floor<T: Real>(mu: f64, key: u32) -> Contact<T, 2, 2> {
    Contact {
        jacobian: matrix![T::ZERO, T::ONE; T::ONE, T::ZERO],
        offset: SVector::zeros(),
        mu: T::literal(mu),
        key,
    }
}

impl Cuboid {
    pub(crate) fn mass_matrix(&self) -> SMatrix<f64, 6, 6> {
        let [a, b, c] = self.half.map(|half| half * half);
        let inertia = vector![b + c, c + a, a + b] * (self.mass / 3.0);
        let [x, y, z] = inertia.into();
        SMatrix::from_diagonal(&vector![self.mass, self.mass, self.mass, x, y, z])
    }

    /// Where the box touches the plane, from its centre.
    pub(crate) fn corners(&self) -> [Vector3<f64>; 4] {
        let [a, b, c] = self.half;
        [(a, b), (a, -b), (-a, b), (-a, -b)].map(|(x, y)| vector![x, y, -c])
    }

    /// The box at rest on a plane.
    pub(crate) fn on_plane<T: Real>(&self, mu: f64) -> Result<BoxScene<T>, Error> {
        let mut scene = Scene::new();
        scene.set_mass(&self.mass_matrix().map(T::literal))?;
        for corner in self.corners() {
            scene.push(&Contact {
                jacobian: point_jacobian(&corner).map(T::literal),
                offset: SVector::zeros(),
                mu: T::literal(mu),
                key: 0,
            })?;
        }
        Ok(scene)
    }

    /// The free impulse of a step in which the box, at rest before, feels gravity on a slope.
    pub(crate) fn free_impulse<T: Real>(&self, slope: f64, step: f64) -> SVector<T, 6> {
        let impulse = self.mass * GRAVITY * step;
        let (down, into) = (impulse * slope.sin(), -impulse * slope.cos());
        vector![down, 0.0, into, 0.0, 0.0, 0.0].map(T::literal)
    }
}

/// Velocity of a point of a body, normal `z` first, then `x` and `y`.
pub(crate) fn point_jacobian(p: &Vector3<f64>) -> SMatrix<f64, 3, 6> {
    matrix![
        0.0, 0.0, 1.0, p.y, -p.x, 0.0;
        1.0, 0.0, 0.0, 0.0, p.z, -p.y;
        0.0, 1.0, 0.0, -p.z, 0.0, p.x
    ]
}
