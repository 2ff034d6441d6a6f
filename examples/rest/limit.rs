//! The largest load that friction can hold, by Clarabel.

use crate::body::{Body, Brake};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use nalgebra::DVector;

/// The largest `s` with `Hᵀ r + brakes + weight + s direction = 0`, `|r_T| <= share mu r_N` and brakes at no more than `share` of
/// their torque, beside `|r|`. `None` if there is no largest one.
pub(crate) fn largest_load(body: &Body, share: f64, direction: &DVector<f64>) -> Option<(f64, f64)> {
    let (n, m, b) = (direction.len(), 3 * body.mu.len(), body.brakes.len());
    let size = body.weight.norm();
    let mut columns: Vec<Vec<(usize, f64)>> = vec![Vec::new(); m + b + 1];
    let sparse = |column: &mut Vec<(usize, f64)>, values: &mut dyn Iterator<Item = f64>| {
        column.extend(values.enumerate().filter(|(_, value)| *value != 0.0));
    };
    for (i, column) in columns.iter_mut().take(m).enumerate() {
        sparse(column, &mut body.jacobian.row(i).iter().copied());
    }
    for (j, brake) in body.brakes.iter().enumerate() {
        columns[m + j].push((brake.column, 1.0));
    }
    sparse(&mut columns[m + b], &mut direction.iter().copied());
    let mut bounds: Vec<f64> = body.weight.iter().map(|w| -w / size).collect();
    let mut cones = vec![SupportedConeT::ZeroConeT(n)];
    for (i, mu) in body.mu.iter().enumerate() {
        for (k, factor) in [share * mu, 1.0, 1.0].into_iter().enumerate() {
            columns[3 * i + k].push((bounds.len(), -factor));
            bounds.push(0.0);
        }
        cones.push(SupportedConeT::SecondOrderConeT(3));
    }
    let finite = |(_, brake): &(usize, &Brake)| brake.torque.is_finite();
    for (j, brake) in body.brakes.iter().enumerate().filter(finite) {
        for sign in [1.0, -1.0] {
            columns[m + j].push((bounds.len(), sign));
            bounds.push(share * brake.torque / size);
        }
        cones.push(SupportedConeT::NonnegativeConeT(2));
    }
    let mut starts = vec![0];
    for column in &columns {
        starts.push(starts.last().copied().unwrap_or(0) + column.len());
    }
    let (indices, values) = columns.into_iter().flatten().unzip();
    let count = m + b + 1;
    let rows = CscMatrix::new(bounds.len(), count, starts, indices, values);
    let mut linear = vec![0.0; count];
    linear[m + b] = -1.0;
    let settings = DefaultSettings {
        verbose: false,
        max_threads: 1,
        tol_gap_abs: 1e-9,
        tol_gap_rel: 1e-9,
        tol_feas: 1e-9,
        ..DefaultSettings::default()
    };
    let nothing = CscMatrix::zeros((count, count));
    let solver = DefaultSolver::new(&nothing, &linear, &rows, &bounds, &cones, settings);
    let mut solver = solver.expect("the sizes agree");
    solver.solve();
    let x = &solver.solution.x;
    let force = x.iter().take(m).map(|r| r * r).sum::<f64>().sqrt();
    (solver.solution.status == SolverStatus::Solved).then(|| (x[m + b] * size, force * size))
}

/// Can `share` of friction hold the weight with no load, as it is between loads along the direction and against it?
pub(crate) fn holds_weight(body: &Body, share: f64, direction: &DVector<f64>) -> bool {
    [1.0, -1.0].into_iter().all(|sign| {
        let largest = largest_load(body, share, &(direction * sign));
        largest.is_some_and(|(largest, _)| largest > 0.0)
    })
}
