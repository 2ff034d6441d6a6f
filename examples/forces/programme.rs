//! The same for Clarabel: with cones, or with pyramids as a quadratic programme.

use crate::scene::{MU, WEIGHTS};
use crate::{ALPHA, Forces, Grasp, Wrench, recipe};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use nalgebra::{DMatrix, DVector, SMatrix};

/// Where the force of a foot may lie.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Shape {
    Cone,
    /// `|f_x|, |f_y| <= mu f_N`: around the cone.
    Outer,
    /// `|f_x|, |f_y| <= mu f_N / √2`: within the cone.
    Inner,
}

pub(crate) struct Programme {
    hessian: CscMatrix<f64>,
    rows: CscMatrix<f64>,
    cones: Vec<SupportedConeT<f64>>,
    grasp: Grasp,
}

impl Programme {
    pub(crate) fn new(grasp: &Grasp, shape: Shape) -> Self {
        let weighted = grasp.transpose() * SMatrix::from_diagonal(&Wrench::from(WEIGHTS));
        let hessian = weighted * grasp + SMatrix::<f64, 12, 12>::identity() * ALPHA;
        let foot: &[[f64; 3]] = match shape {
            Shape::Cone => &[[MU, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            Shape::Outer => &sides(MU),
            Shape::Inner => &sides(MU / 2.0_f64.sqrt()),
        };
        let n = foot.len();
        let rows = DMatrix::from_fn(4 * n, 12, |i, j| if i / n == j / 3 { -foot[i % n][j % 3] } else { 0.0 });
        let cones = match shape {
            Shape::Cone => vec![SupportedConeT::SecondOrderConeT(3); 4],
            Shape::Outer | Shape::Inner => vec![SupportedConeT::NonnegativeConeT(4 * n)],
        };
        Self {
            hessian: sparse(&DMatrix::from_fn(12, 12, |i, j| if i <= j { hessian[(i, j)] } else { 0.0 })),
            rows: sparse(&rows),
            cones,
            grasp: *grasp,
        }
    }

    pub(crate) fn solve(&self, wanted: &Wrench, tolerance: f64) -> Forces {
        let linear = -self.grasp.transpose() * Wrench::from(WEIGHTS).component_mul(wanted);
        let settings = settings(tolerance);
        let bounds = vec![0.0; self.rows.m];
        let solver =
            DefaultSolver::new(&self.hessian, linear.as_slice(), &self.rows, &bounds, &self.cones, settings);
        let mut solver = solver.expect("the sizes agree");
        solver.solve();
        Forces::from_column_slice(&solver.solution.x)
    }
}

/// The least forces `f` of a hand: `min ½ |A f - b|²_S + ½ α |f|²` with `f - l e_N` in its cone at each contact, and torques of joints within
/// their limit. `rows` has each contact's Jacobian, `Aᵀ` and behind it the joints.
pub(crate) fn least<const N: usize>(
    rows: &[SMatrix<f64, 3, N>],
    wanted: &Wrench,
    mu: f64,
    price: f64,
    limit: Option<f64>,
) -> DVector<f64> {
    let n = 3 * rows.len();
    let all = DMatrix::from_fn(N, n, |i, j| rows[j / 3][(j % 3, i)]);
    let (grasp, torques) = (all.rows(0, 6), all.rows(6, N - 6));
    let weights = DVector::from_column_slice(&recipe::WEIGHTS);
    let weighted = DMatrix::from_fn(n, 6, |i, j| grasp[(j, i)] * weights[j]);
    let hessian = &weighted * grasp + DMatrix::identity(n, n) * price;
    let linear = -&weighted * DVector::from_column_slice(wanted.as_slice());
    let least = DVector::from_fn(n, |i, _| recipe::LEAST[i % 3]);
    let cone = DMatrix::from_fn(n, n, |i, j| if i == j { if i % 3 == 0 { -mu } else { -1.0 } } else { 0.0 });
    // Slack of the cones: `-cone (f - l)`.
    let mut bounds = (&cone * &least).as_slice().to_vec();
    let (mut constraints, mut cones) = (cone, vec![SupportedConeT::SecondOrderConeT(3); rows.len()]);
    if let Some(limit) = limit {
        let joints = N - 6;
        constraints = DMatrix::from_fn(n + 2 * joints, n, |i, j| match i.checked_sub(n) {
            None => constraints[(i, j)],
            Some(k) if k < joints => torques[(k, j)],
            Some(k) => -torques[(k - joints, j)],
        });
        bounds.resize(n + 2 * joints, limit);
        cones.push(SupportedConeT::NonnegativeConeT(2 * joints));
    }
    let upper = DMatrix::from_fn(n, n, |i, j| if i <= j { hessian[(i, j)] } else { 0.0 });
    let solver = DefaultSolver::new(
        &sparse(&upper),
        linear.as_slice(),
        &sparse(&constraints),
        &bounds,
        &cones,
        settings(1e-10),
    );
    let mut solver = solver.expect("the sizes agree");
    solver.solve();
    assert!(matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved));
    DVector::from_column_slice(&solver.solution.x)
}

fn settings(tolerance: f64) -> DefaultSettings<f64> {
    DefaultSettings {
        verbose: false,
        max_threads: 1,
        tol_gap_abs: tolerance,
        tol_gap_rel: tolerance,
        tol_feas: tolerance,
        ..DefaultSettings::default()
    }
}

/// `mu f_N` less or plus one of the tangential forces.
fn sides(mu: f64) -> [[f64; 3]; 4] {
    [[mu, 1.0, 0.0], [mu, -1.0, 0.0], [mu, 0.0, 1.0], [mu, 0.0, -1.0]]
}

/// Column by column, without zeros.
fn sparse(matrix: &DMatrix<f64>) -> CscMatrix<f64> {
    let (mut starts, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
    for column in matrix.column_iter() {
        for (row, &value) in column.iter().enumerate().filter(|(_, value)| **value != 0.0) {
            indices.push(row);
            values.push(value);
        }
        starts.push(values.len());
    }
    CscMatrix::new(matrix.nrows(), matrix.ncols(), starts, indices, values)
}
