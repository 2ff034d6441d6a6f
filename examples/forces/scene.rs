//! The problem as a scene of this crate; `examples/measure` has it, too.

use nalgebra::{SMatrix, SVector};
use stiction::{Contact, Error, Model, Real, Scene, Settings, Surface};

/// Friction coefficient.
pub(crate) const MU: f64 = 0.4;
/// Weight of the robot, N.
pub(crate) const WEIGHT: f64 = 12.0 * 9.81;
/// `S`: 1 for forces and `1 / (0.2 m)²` for moments, since a foot has an arm of about 0.2 m.
pub(crate) const WEIGHTS: [f64; 6] = [1.0, 1.0, 1.0, 25.0, 25.0, 25.0];
/// The feet, from the centre of mass, m.
const FEET: [[f64; 3]; 4] =
    [[0.19, 0.13, -0.28], [0.19, -0.13, -0.28], [-0.19, 0.13, -0.28], [-0.19, -0.13, -0.28]];

/// `M = S⁻¹`, `H = Aᵀ` and compliance `α`, with this coefficient of friction.
pub(crate) fn fill<T: Real>(scene: &mut Scene<T, 6, 3, 4, 0, 4>, alpha: f64, mu: f64) -> Result<(), Error> {
    let masses = SVector::from(WEIGHTS.map(|weight| T::literal(1.0 / weight)));
    scene.set_mass(&SMatrix::from_diagonal(&masses))?;
    for (key, [x, y, z]) in (0..).zip(FEET) {
        // Forces up, forward and to the left; each with its moment.
        let jacobian = SMatrix::<f64, 3, 6>::from_row_slice(&[
            0.0, 0.0, 1.0, y, -x, 0.0, //
            1.0, 0.0, 0.0, 0.0, z, -y, //
            0.0, 1.0, 0.0, -z, 0.0, x,
        ]);
        let foot =
            Contact { jacobian: jacobian.map(T::literal), offset: SVector::zeros(), mu: T::literal(mu), key };
        let surface = Surface { compliance: [T::literal(alpha); 2], ..Surface::isotropic(foot.mu) };
        scene.push_on(&foot, &surface)?;
    }
    Ok(())
}

/// The convex model, to this tolerance.
pub(crate) fn settings<T: Real>(tolerance: f64) -> Settings<T> {
    Settings { model: Model::ConvexRelaxation, ..Settings::new(T::literal(tolerance)) }
}
