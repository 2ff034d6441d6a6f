//! Equalities that say what others say already: the third row of a planar loop, a second pin of a hinge.

/// What is left of such a row, over the largest row.
const ROUNDING: f64 = 1e-10;

/// Makes the speeds at which equalities close agree where their rows depend on each other. What is open along them is rounding,
/// which no velocity closes: as it stands it would be a contradiction.
pub(super) fn reconcile(rows: &[f64], nv: usize, speeds: &mut [f64]) {
    let norm = |row: &[f64]| row.iter().map(|x| x * x).sum::<f64>().sqrt();
    let largest = rows.chunks_exact(nv).map(norm).fold(0.0, f64::max);
    // Orthonormal rows, each with the speed that the rows so far ask of it (Gram and Schmidt, twice).
    let mut basis: Vec<(Vec<f64>, f64)> = Vec::new();
    for (row, speed) in rows.chunks_exact(nv).zip(speeds) {
        let (mut rest, mut left) = (row.to_vec(), *speed);
        for (unit, own) in basis.iter().chain(&basis) {
            let along: f64 = rest.iter().zip(unit).map(|(a, b)| a * b).sum();
            rest.iter_mut()
                .zip(unit)
                .for_each(|(rest, entry)| *rest -= along * entry);
            left -= along * own;
        }
        let length = norm(&rest);
        if length > ROUNDING * largest {
            let unit = rest.iter().map(|entry| entry / length);
            basis.push((unit.collect(), left / length));
        } else {
            *speed -= left;
        }
    }
}
