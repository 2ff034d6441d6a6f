//! Dynamics that give `W` and `q` and no `M` and `H`: a root of `W` stands for `H`, and a unit matrix for `M`.

use nalgebra::DMatrix;

/// `H` with `H Hᵀ = W`, of so many columns: those of the largest eigenvalues of `W`, whose rows are scaled to a diagonal of 1 first, as
/// their units differ. `W` is symmetric and positive semidefinite, without compliance, and of a rank of at most as many.
///
/// Push contacts and joint rows with these rows, with `q` as offsets, and solve with a mass matrix of 1 and a free impulse of 0. The
/// velocity of the solution has no meaning then, and what "solved" promises is the error for `H Hᵀ`.
pub fn root(delassus: &DMatrix<f64>, columns: usize) -> DMatrix<f64> {
    let scale = delassus.diagonal().map(|own| if own > 0.0 { own.sqrt() } else { 1.0 });
    let scaled =
        DMatrix::from_fn(delassus.nrows(), delassus.ncols(), |i, j| delassus[(i, j)] / (scale[i] * scale[j]));
    let eigen = scaled.symmetric_eigen();
    let mut order: Vec<usize> = (0..delassus.nrows()).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    DMatrix::from_fn(delassus.nrows(), columns, |row, column| {
        order.get(column).map_or(0.0, |&k| {
            let length = eigen.eigenvalues[k].max(0.0).sqrt();
            scale[row] * length * eigen.eigenvectors[(row, k)]
        })
    })
}
