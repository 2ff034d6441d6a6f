//! Bodies followed from step to step by Moreau-Jean stepping.

use super::boxes::{Cuboid, GRAVITY};
use super::pad;
use nalgebra::{Matrix3, SVector, matrix, vector};
use stiction::time_stepping as law;
use stiction::{Contact, Error, Factor, Real, Scene, Settings, Solver, Status};

/// No contact here closes faster, m/s.
pub(crate) const REACH: f64 = 5.0;

/// A system of constant mass and contact directions under constant forces.
pub(crate) struct Motion<T: Real, const N: usize, const D: usize, const C: usize> {
    pub(crate) scene: Scene<T, N, D, C>,
    pub(crate) factor: Factor<T, N, D, C>,
    pub(crate) solver: Solver<T, N, D, C>,
    pub(crate) settings: Settings<T>,
    pub(crate) force: SVector<T, N>,
    pub(crate) step: T,
    /// Generalised position since the start, and velocity.
    pub(crate) position: SVector<T, N>,
    pub(crate) velocity: SVector<T, N>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Motion<T, N, D, C> {
    pub(crate) fn new(
        scene: Scene<T, N, D, C>,
        force: SVector<f64, N>,
        step: f64,
        tolerance: f64,
    ) -> Result<Self, Error> {
        Ok(Self {
            factor: Factor::new(&scene)?,
            scene,
            solver: Solver::new(),
            settings: Settings::new(T::literal(tolerance)),
            force: force.map(T::literal),
            step: T::literal(step),
            position: SVector::zeros(),
            velocity: SVector::zeros(),
        })
    }

    /// Sets the normal offset of a contact.
    pub(crate) fn offset(&mut self, contact: usize, normal: T) -> Result<(), Error> {
        let mut offset = SVector::zeros();
        offset[0] = normal;
        self.scene.set_offset(contact, &offset)
    }

    /// One step, from the offsets that were set.
    pub(crate) fn advance(&mut self) -> Result<(), Error> {
        let mass = self.scene.mass();
        let push = law::free_impulse(mass, &self.velocity, &self.force, self.step);
        let solver = &mut self.solver;
        let solution = solver.solve(&self.scene, &self.factor, &push, &self.settings)?;
        // Of a body that grazes, `H v` cancels to less than its rounding: the error, which is
        // relative to a small impulse, is one of the last bits of the momentum.
        let impulses = solution.contacts.iter().map(|contact| contact.impulse.norm());
        let impulse = impulses.fold(T::ZERO, |sum, impulse| sum + impulse);
        let rounding = T::EPSILON * T::literal(64.0) * (mass * self.velocity).norm();
        let limited = solution.status == Status::PrecisionLimit;
        let grazes = limited && solution.error * impulse <= rounding;
        let solved = grazes || solution.status == Status::Solved;
        assert!(solved, "{:?}: {:?}", solution.status, solution.error);
        self.velocity = solution.velocity;
        self.position += self.velocity * self.step;
        Ok(())
    }

    /// Kinetic energy, and the work against the forces with the position half a step back, where
    /// this scheme is that of the midpoint: a falling body keeps the sum.
    pub(crate) fn energy(&self) -> f64 {
        let double = |x: T| x.to_subset().unwrap_or(f64::NAN);
        let [velocity, position, force] = [self.velocity, self.position, self.force].map(|x| x.map(double));
        let mass = self.scene.mass().map(double);
        let midpoint = position - velocity * (double(self.step) / 2.0);
        velocity.dot(&(mass * velocity)) / 2.0 - force.dot(&midpoint)
    }
}

/// A solid ball over a floor; dofs forward, up, and the spin that turns its top backward.
#[derive(Clone, Copy)]
pub(crate) struct Ball {
    pub(crate) mass: f64,
    pub(crate) radius: f64,
    pub(crate) mu: f64,
    pub(crate) restitution: f64,
}

pub(crate) const BALL: Ball = Ball { mass: 0.6, radius: 0.12, mu: 0.3, restitution: 0.9 };

impl Ball {
    pub(crate) fn motion<T: Real>(&self, step: f64, tolerance: f64) -> Result<Motion<T, 6, 2, 4>, Error> {
        let inertia = 0.4 * self.mass * self.radius * self.radius;
        let mut scene = Scene::new();
        let mass = Matrix3::from_diagonal(&vector![self.mass, self.mass, inertia]);
        scene.set_mass(&pad::mass(&mass.map(T::literal)))?;
        let jacobian = matrix![0.0, 1.0, 0.0; 1.0, 0.0, self.radius].map(T::literal);
        scene.push(&Contact {
            jacobian: pad::jacobian(&jacobian),
            offset: SVector::zeros(),
            mu: T::literal(self.mu),
            key: 0,
        })?;
        let weight = SVector::ith(1, -self.mass * GRAVITY);
        Motion::new(scene, weight, step, tolerance)
    }

    /// One step of a ball whose lowest point is at `position.y`.
    pub(crate) fn advance<T: Real>(&self, ball: &mut Motion<T, 6, 2, 4>) -> Result<(), Error> {
        let threshold = T::literal(4.0 * GRAVITY) * ball.step;
        let gap = law::Gap { distance: ball.position.y, recovery: T::ZERO, reach: T::literal(REACH) }
            .offset(ball.step)?;
        let coefficient = T::literal(self.restitution);
        let law = law::Restitution { coefficient, threshold };
        ball.offset(0, law.offset(ball.velocity.y, gap)?)?;
        ball.advance()
    }
}

/// A box on a plane that it does not leave; dofs as in [`super::boxes`].
pub(crate) fn box_on_slope(
    cuboid: &Cuboid,
    mu: f64,
    slope: f64,
    step: f64,
) -> Result<Motion<f64, 6, 3, 4>, Error> {
    let force = cuboid.free_impulse::<f64>(slope, 1.0);
    Motion::new(cuboid.on_plane(mu)?, force, step, 1e-10)
}
