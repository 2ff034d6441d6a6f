//! A body that rolls on a point below it.

use stiction::nalgebra::SMatrix;

/// The Jacobian of a contact at distance `radius` (m) below the origin of a body, of its velocity and angular velocity: normal, two
/// tangents, spin and two rolls, as far as there are `D` rows.
pub fn jacobian<const D: usize>(radius: f64) -> SMatrix<f64, D, 6> {
    let mut jacobian = SMatrix::zeros();
    let entries = [
        (0, 2, 1.0),
        (1, 0, 1.0),
        (1, 4, -radius),
        (2, 1, 1.0),
        (2, 3, radius),
        (3, 5, 1.0),
        (4, 3, 1.0),
        (5, 4, 1.0),
    ];
    for (row, column, entry) in entries.into_iter().filter(|&(row, ..)| row < D) {
        jacobian[(row, column)] = entry;
    }
    jacobian
}
