//! An answer for every question: sweeps over soft contacts and rows in the convex relaxation, whatever their number.

use crate::problem::{Answer, Dynamics, Friction, Problem};
use nalgebra::{Cholesky, DMatrix, DVector, SVector};
use stiction::FrictionCone;

/// Sweeps that are done.
pub(super) const SWEEPS: usize = 200;

/// Sweeps over a problem whose rows are all compliant. Each step goes downhill in a convex energy, so impulses stay bounded.
pub(super) fn sweep(problem: &Problem<'_, f64>) -> Answer<f64> {
    let (n, dim, contacts) = (problem.n, problem.dim, problem.contacts());
    let mut answer = Answer::default();
    answer.out([n, contacts, dim, problem.rows.lower.len()]);
    let Dynamics::Mass(mass, jacobian, impulse) = problem.dynamics else { return answer };
    let Some(factor) = Cholesky::new(DMatrix::from_row_slice(n, n, mass)) else { return answer };
    let mut velocity = factor.solve(&DVector::from_row_slice(impulse));
    let rows = jacobian.chunks_exact(n.max(1)).chain(problem.rows.jacobian.chunks_exact(n.max(1)));
    // What an impulse along each row moves, and how much along the row itself.
    let moves: Vec<(DVector<f64>, DVector<f64>)> = rows
        .map(|row| {
            let row = DVector::from_row_slice(row);
            let moved = factor.solve(&row);
            (row, moved)
        })
        .collect();
    let (of_contacts, of_rows) = moves.split_at(contacts * dim);
    let Some(cone) = FrictionCone::new(1.0) else { return answer };
    for _ in 0..SWEEPS {
        for (i, rows) in of_contacts.chunks_exact(dim).enumerate() {
            let compliance = problem.compliance.get(2 * i..2 * i + 2).unwrap_or(&[0.0; 2]);
            // In rows that are scaled by their coefficients the cone is that of mu = 1.
            let scale = |k: usize| match problem.friction {
                _ if k == 0 => 1.0,
                Friction::Round(mu) => mu[i],
                Friction::Shaped(mu) => mu[i * (dim - 1) + k - 1],
            };
            let soft = |k: usize| compliance[usize::from(k > 0)];
            let stiffness = rows.iter().enumerate().map(|(k, (row, moved))| (row.dot(moved) + soft(k)) * scale(k).powi(2));
            let stiffness: f64 = stiffness.sum();
            if stiffness <= 0.0 {
                continue;
            }
            let own = &mut answer.r[i * dim..][..dim];
            let mut wanted = SVector::<f64, 6>::zeros();
            for (k, (row, _)) in rows.iter().enumerate().filter(|&(k, _)| scale(k) > 0.0) {
                let speed = row.dot(&velocity) + problem.offsets[i * dim + k] + soft(k) * own[k];
                wanted[k] = own[k] / scale(k) - scale(k) * speed / stiffness;
            }
            let wanted = cone.project(&wanted);
            for (k, (_, moved)) in rows.iter().enumerate() {
                let wanted = scale(k) * wanted[k];
                velocity.axpy(wanted - own[k], moved, 1.0);
                own[k] = wanted;
            }
        }
        for (j, (row, moved)) in of_rows.iter().enumerate() {
            let soft = problem.rows.compliance.get(j).copied().unwrap_or(0.0);
            let stiffness = row.dot(moved) + soft;
            if stiffness <= 0.0 {
                continue;
            }
            let own = answer.rows[0][j];
            let wanted = own - (row.dot(&velocity) + problem.rows.offset[j] + soft * own) / stiffness;
            let wanted = wanted.clamp(problem.rows.lower[j], problem.rows.upper[j]);
            velocity.axpy(wanted - own, moved, 1.0);
            answer.rows[0][j] = wanted;
        }
    }
    answer.v.copy_from_slice(velocity.as_slice());
    answer
}
