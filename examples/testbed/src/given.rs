//! Scenes of which `W` and `q` are given: their solve, and what a stranger says of it.

use crate::generate::Given;
use crate::measure::{double, error_given};
use nalgebra::{SMatrix, SVector};
use stiction::{Contact, Error, Factor, Real, Scene, Settings, Solver, Status};

/// What the kernel said, and the error as a stranger measures it.
#[derive(Clone, Debug)]
pub struct Outcome {
    pub status: Status,
    pub work: usize,
    pub error: f64,
    pub certificate: Vec<f64>,
}

/// Solves a scene of up to four contacts of three rows and a rank of up to 6, rounded to a number type.
///
/// # Errors
/// Those of the kernel.
pub fn solve<T: Real>(scene: &Given, settings: &Settings<f64>) -> Result<Outcome, Error> {
    const D: usize = 3;
    let settings = Settings {
        tolerance: T::literal(settings.tolerance),
        budget: settings.budget,
        model: settings.model,
    };
    let round = |x: f64| double(&T::literal(x));
    let mut kernel = Scene::<T, 6, D, 4>::new();
    for (i, &mu) in scene.mu.iter().enumerate() {
        kernel.push(&Contact {
            jacobian: SMatrix::zeros(),
            offset: SVector::from_fn(|k, _| T::literal(scene.q[D * i + k])),
            mu: T::literal(mu),
            key: 0,
        })?;
    }
    let entry = |i: usize, j: usize| scene.delassus.get(i).and_then(|row| row.get(j));
    let entry = |i: usize, j: usize| T::literal(entry(i, j).copied().unwrap_or(0.0));
    let size = D * scene.mu.len();
    let delassus: Vec<T> = (0..size * size)
        .map(|place| entry(place / size, place % size))
        .collect();
    kernel.set_delassus(&delassus)?;
    let (factor, mut solver) = (Factor::new(&kernel)?, Solver::new());
    let solution = solver.solve(&kernel, &factor, &SVector::zeros(), &settings)?;
    let r: Vec<f64> = solution
        .contacts
        .iter()
        .flat_map(|c| c.impulse.iter().map(double))
        .collect();
    let rounded = |row: &Vec<f64>| row.iter().map(|&x| round(x)).collect();
    let delassus: Vec<_> = scene.delassus.iter().map(rounded).collect();
    let [q, mu] = [&scene.q, &scene.mu].map(|x| x.iter().map(|&x| round(x)).collect::<Vec<_>>());
    Ok(Outcome {
        status: solution.status,
        work: solution.work.total(),
        error: error_given(&delassus, &q, &mu, &r),
        certificate: solution.certificate.iter().map(|d| double(&d[0])).collect(),
    })
}
