//! A step of a scene through the kernel, in either number type.

use crate::{C, Given, N, R, Vector};
use nalgebra::{Vector2, vector};
use stiction::{
    Contact, ContactMode, Error, JointRow, Kernel, Real, RowLaw, Settings, contact_frame, heapless,
};

/// A solution in `f64`.
pub(crate) struct Answer {
    pub(crate) velocity: Vector,
    /// Impulse of each contact in the axes of the scene (N·s), and its mode: 0 open, 1 stick, 2 slip.
    pub(crate) impulses: heapless::Vec<(Vector2<f64>, f64), C>,
    pub(crate) rows: [f64; R],
    pub(crate) error: f64,
    pub(crate) solved: bool,
}

/// Solves to `tolerance`.
pub(crate) fn solve<T: Real>(
    kernel: &mut Kernel<T, N, 2, C, R>,
    given: &Given,
    free_impulse: &Vector,
    tolerance: f64,
) -> Result<Answer, Error> {
    let double = |x: T| -> f64 { x.to_subset_unchecked() };
    let scene = kernel.scene_mut();
    scene.set_velocities(given.velocities)?;
    scene.clear();
    scene.set_mass(&given.mass.map(T::literal))?;
    for touch in &given.touches {
        let Contact { jacobian, offset, mu, key } = &touch.contact;
        let (jacobian, offset) = (jacobian.map(T::literal), offset.map(T::literal));
        scene.push(&Contact { jacobian, offset, mu: T::literal(*mu), key: *key })?;
    }
    for row in &given.rows {
        let law = match row.law {
            RowLaw::Limit => RowLaw::Limit,
            RowLaw::Equality => RowLaw::Equality,
            RowLaw::Box { lower, upper } => {
                RowLaw::Box { lower: T::literal(lower), upper: T::literal(upper) }
            }
        };
        let (offset, compliance) = (T::literal(row.offset), T::literal(row.compliance));
        scene.push_row(&JointRow { row: row.row.map(T::literal), offset, law, compliance, key: row.key })?;
    }
    let settings = Settings::new(T::literal(tolerance));
    let solution = kernel.solve(&free_impulse.map(T::literal), &settings)?;
    let mut answer = Answer {
        velocity: solution.velocity.map(double),
        impulses: heapless::Vec::new(),
        rows: [0.0; R],
        error: double(solution.error),
        solved: solution.is_solved(),
    };
    for (touch, contact) in given.touches.iter().zip(&solution.contacts) {
        let [normal, tangent] = contact.impulse.map(double).into();
        let mode = match contact.mode {
            ContactMode::Open => 0.0,
            ContactMode::Stick => 1.0,
            ContactMode::Slip => 2.0,
        };
        let impulse = contact_frame(&touch.normal)? * vector![normal, tangent];
        // There is room: both hold `C`.
        let _ = answer.impulses.push((impulse, mode));
    }
    for (impulse, row) in answer.rows.iter_mut().zip(&solution.rows) {
        *impulse = double(row.impulse);
    }
    Ok(answer)
}
