//! A hand that shares out a wrench over its contacts, tick by tick, as "Sharing out forces" in the guide has it. `tests/small` has it, too.

use nalgebra::{SMatrix, SVector, Vector3, vector};
use std::f64::consts::TAU;
use stiction::{Contact, Error, JointRow, Kernel, Model, Real, RowLaw, Settings, Solution, Surface};

/// Friction coefficient.
pub(crate) const MU: f64 = 0.6;
/// `S`: 1 for forces and `1 / (0.04 m)²` for moments.
pub(crate) const WEIGHTS: [f64; 6] = [1.0, 1.0, 1.0, 625.0, 625.0, 625.0];
/// Least normal force of a contact (N).
pub(crate) const LEAST: Vector3<f64> = vector![0.3, 0.0, 0.0];

/// How a tick is solved.
#[derive(Clone, Copy)]
pub(crate) struct Recipe {
    /// Price of forces that differ from those to which they are drawn (`α`).
    pub(crate) alpha: f64,
    /// That share of the last forces.
    pub(crate) drawn: f64,
    /// By what friction is divided.
    pub(crate) reserve: f64,
    /// Largest torque of a joint (N·m).
    pub(crate) limit: Option<f64>,
    /// Mass of a joint whose torque has a limit: hardly any.
    pub(crate) joint: f64,
    pub(crate) tolerance: f64,
    pub(crate) budget: usize,
    /// Error up to which the forces of an unsolved tick are taken. If it is 0, the last ones stay.
    pub(crate) enough: f64,
}

/// That of the guide.
pub(crate) const RECIPE: Recipe = Recipe {
    alpha: 0.1,
    drawn: 0.99,
    reserve: 1.5,
    limit: None,
    joint: 1e-4,
    tolerance: 1e-4,
    budget: 100,
    enough: 0.0,
};

/// Contacts with a thing of 8 cm, in its axes, by fingers of two joints each. `N` is six, and two a finger.
pub(crate) struct Hand<T: Real, const N: usize> {
    kernel: Kernel<T, N, 3, 8, 6, 8>,
    /// With the velocity of the thing, minus that of the finger.
    contacts: Vec<Contact<T, N, 3>>,
    /// Force of each contact (N), normal first.
    pub(crate) forces: Vec<Vector3<T>>,
}

impl<T: Real + Into<f64>, const N: usize> Hand<T, N> {
    /// So many contacts round the thing, those of a finger one above the other, with random places and normals.
    pub(crate) fn random(contacts: u32, uniform: &mut impl FnMut(f64, f64) -> f64) -> Result<Self, Error> {
        let mut hand = Self { kernel: Kernel::new(), contacts: Vec::new(), forces: Vec::new() };
        let joints: Vec<_> = (6..N).collect();
        let mut fingers = (0..).zip(joints.chunks_exact(2)).cycle();
        let (all, mut ring) = (f64::from(u32::try_from(N / 2 - 3).unwrap_or(1)), -1.0);
        for key in 0..contacts {
            let Some((finger, joints)) = fingers.next() else { break };
            if key > 0 && finger == 0 {
                ring += 1.0;
            }
            let (sine, cosine) = ((f64::from(finger) / all + uniform(-0.03, 0.03)) * TAU).sin_cos();
            let (out, along) = (vector![cosine, sine, 0.0], vector![-sine, cosine, 0.0]);
            let point = out * 0.04 + vector![0.0, 0.0, ring * 0.01 + uniform(-2e-3, 2e-3)];
            let tilt = [(); 3].map(|()| uniform(-0.1, 0.1));
            let normal = (Vector3::from(tilt) - out).normalize();
            let mut velocity = SMatrix::<f64, 3, N>::zeros();
            velocity.fixed_columns_mut::<3>(0).fill_with_identity();
            velocity.fixed_columns_mut::<3>(3).copy_from(&-point.cross_matrix());
            for (&joint, [away, up]) in joints.iter().zip([[0.06, -0.10], [0.085, -0.05]]) {
                let arm = point - out * away - vector![0.0, 0.0, up];
                velocity.set_column(joint, &-along.cross(&arm));
            }
            let (normal, velocity) = (normal.map(T::literal), velocity.map(T::literal));
            hand.contacts.push(Contact::at_point(&normal, &velocity, T::ZERO, key)?);
            hand.forces.push(Vector3::zeros());
        }
        Ok(hand)
    }

    /// Of each contact: `Aᵀ`, and behind it minus the Jacobian of the joints.
    pub(crate) fn jacobians(&self) -> impl Iterator<Item = SMatrix<f64, 3, N>> {
        self.contacts.iter().map(|contact| contact.jacobian.map(Into::into))
    }

    /// The wrench of forces, and behind it minus the torques that they take.
    pub(crate) fn effect(&self, forces: impl Iterator<Item = Vector3<f64>>) -> SVector<f64, N> {
        self.jacobians().zip(forces).map(|(jacobian, force)| jacobian.tr_mul(&force)).sum()
    }

    /// Forgets the last solve, but not its forces.
    pub(crate) fn reset(&mut self) {
        self.kernel.reset();
    }

    /// Shares out a wrench. Afterwards the forces are new ones if the tick was solved, and else the last.
    pub(crate) fn share(
        &mut self,
        wrench: &SVector<f64, 6>,
        recipe: &Recipe,
    ) -> Result<&Solution<T, N, 3, 8, 6>, Error> {
        let Recipe { alpha, drawn, reserve, limit, joint, tolerance, budget, enough } = *recipe;
        let scene = self.kernel.scene_mut();
        scene.clear();
        scene.set_velocities(if limit.is_some() { N } else { 6 })?;
        let mass = |i| WEIGHTS.get(i).map_or(joint, |weight| 1.0 / weight);
        scene.set_mass(&SMatrix::from_diagonal(&SVector::from_fn(|i, _| T::literal(mass(i)))))?;
        // The forces beyond the least ones are what is solved for.
        let mut free_impulse = SVector::<T, N>::zeros();
        free_impulse.fixed_rows_mut::<6>(0).copy_from(&-wrench.map(T::literal));
        let (least, mu) = (LEAST.map(T::literal), T::literal(MU / reserve));
        for (contact, last) in self.contacts.iter().zip(&self.forces) {
            free_impulse += contact.jacobian.tr_mul(&least);
            let offset = (least - last * T::literal(drawn)) * T::literal(alpha);
            let surface = Surface { compliance: [T::literal(alpha); 2], ..Surface::isotropic(mu) };
            scene.push_on(&Contact { offset, mu, ..contact.clone() }, &surface)?;
        }
        for (key, joint) in (0..).zip(6..N) {
            if let Some(torque) = limit.map(T::literal) {
                let row = SVector::from_fn(|i, _| if i == joint { T::ONE } else { T::ZERO });
                let law = RowLaw::Box { lower: -torque, upper: torque };
                scene.push_row(&JointRow { row, offset: T::ZERO, law, compliance: T::ZERO, key })?;
            }
        }
        let settings =
            Settings { model: Model::ConvexRelaxation, budget, ..Settings::new(T::literal(tolerance)) };
        let solution = self.kernel.solve(&free_impulse, &settings)?;
        if solution.is_solved() || enough > 0.0 && solution.is_usable(T::literal(enough)) {
            for (force, contact) in self.forces.iter_mut().zip(&solution.contacts) {
                *force = contact.impulse + least;
            }
        }
        Ok(solution)
    }
}
