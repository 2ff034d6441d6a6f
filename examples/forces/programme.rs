//! The same for Clarabel: with cones, or with pyramids as a quadratic programme.

use crate::scene::{ALPHA, MU, WEIGHTS};
use crate::{Forces, Grasp, Wrench};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SupportedConeT};
use nalgebra::{DMatrix, SMatrix};

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
        let settings = DefaultSettings {
            verbose: false,
            max_threads: 1,
            tol_gap_abs: tolerance,
            tol_gap_rel: tolerance,
            tol_feas: tolerance,
            ..DefaultSettings::default()
        };
        let bounds = vec![0.0; self.rows.m];
        let solver =
            DefaultSolver::new(&self.hessian, linear.as_slice(), &self.rows, &bounds, &self.cones, settings);
        let mut solver = solver.expect("the sizes agree");
        solver.solve();
        Forces::from_column_slice(&solver.solution.x)
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
