//! Solves a scene of any size by default settings, and has a stranger judge the answer.

use super::measure::{self, Law};
use super::scene_file::SceneFile;
use nalgebra::SVector;
use stiction::{Error, Factor, Real, Scene, Settings, Solver, Status};

/// What the kernel said of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// "The error is below the tolerance."
    Solved,
    /// "It is not."
    Unsolved,
    /// "There is no solution", and how strong the proof is by [`measure::proof`].
    Infeasible { proof: f64 },
    /// "This scene cannot be computed with."
    Refused(Error),
}

/// The answer, and what it is worth.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    pub answer: Answer,
    /// Of the returned velocity and impulses, recomputed in f64 from the scene as given.
    pub error: f64,
    /// Iterations, and ten for each Newton step.
    pub work: usize,
}

/// Does a solve do without the resolvent, so that `Factor::update` prepares all it needs? The factor is left as that
/// prepares it, the solver as it was.
///
/// # Errors
/// What the kernel refuses of the scene.
pub fn spares_resolvent<T: Real, const N: usize, const D: usize, const C: usize>(
    scene: &Scene<T, N, D, C>,
    factor: &mut Factor<T, N, D, C>,
    solver: &Solver<T, N, D, C>,
    f: &SVector<T, N>,
    settings: &Settings<T>,
) -> Result<bool, Error> {
    factor.update(scene)?;
    let mut solver = solver.clone();
    let solution = solver.solve(scene, factor, f, settings)?;
    Ok(solution.factorizations == 0)
}

/// Solves with all settings but the tolerance at their defaults.
pub fn solve<T: Real>(scene: &SceneFile, tolerance: f64) -> Outcome {
    let solve = match (scene.dim, scene.n_dof, scene.n_contacts) {
        (2, ..=6, ..=4) => solve_as::<T, 6, 2, 4>,
        (3, ..=6, ..=4) => solve_as::<T, 6, 3, 4>,
        (2, ..=30, ..=12) => solve_as::<T, 30, 2, 12>,
        (3, ..=30, ..=12) => solve_as::<T, 30, 3, 12>,
        (dim, n, contacts) => panic!("no size compiled for {n} dofs, {contacts} x {dim} rows"),
    };
    solve(scene, tolerance).unwrap_or_else(|error| Outcome {
        answer: Answer::Refused(error),
        error: f64::INFINITY,
        work: 0,
    })
}

fn solve_as<T: Real, const N: usize, const D: usize, const C: usize>(
    file: &SceneFile,
    tolerance: f64,
) -> Result<Outcome, Error> {
    let scene = file.scene::<T, N, D, C>()?;
    let factor = Factor::new(&scene)?;
    let mut solver = Solver::new();
    let settings = Settings {
        tolerance: T::literal(tolerance),
        ..Settings::default()
    };
    let solution = solver.solve(&scene, &factor, &file.free_impulse(), &settings)?;
    let double = |x: &T| x.to_subset().unwrap_or(f64::NAN);
    let v: Vec<f64> = solution
        .velocity
        .iter()
        .take(file.n_dof)
        .map(double)
        .collect();
    let impulses = solution.contacts.iter().flat_map(|c| c.impulse.iter());
    let r: Vec<f64> = impulses.map(double).collect();
    Ok(Outcome {
        answer: match solution.status {
            Status::Solved => Answer::Solved,
            Status::Infeasible => {
                let certificate: Vec<f64> = solution.certificate.iter().map(double).collect();
                Answer::Infeasible {
                    proof: measure::proof(file, &certificate),
                }
            }
            _ => Answer::Unsolved,
        },
        error: measure::error(file, &v, &r, Law::Coulomb),
        work: solution.iterations + 10 * solution.newton_steps,
    })
}
