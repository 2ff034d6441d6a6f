//! The variants that the library has.

use crate::outcome::Outcome;
use crate::support::measure::{self, Law};
use crate::support::scene_file::SceneFile;
use stiction::{AdmmSolver, Error, Factor, Settings, SlipUpdate, Solver, Status};

#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Method {
    Plain,
    Fast,
    Restart,
    Default,
}

impl Method {
    pub(crate) const ALL: [Self; 4] = [Self::Plain, Self::Fast, Self::Restart, Self::Default];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain ADMM",
            Self::Fast => "Algorithm 1",
            Self::Restart => "Algorithm 2",
            Self::Default => "default",
        }
    }
}

/// Solves a scene cold, with the default penalty; a Newton step counts as ten iterations.
pub(crate) fn solve(file: &SceneFile, method: Method, settings: &Settings<f64>) -> Outcome {
    match file.dim {
        2 => solve_as::<6, 2, 4>(file, method, settings),
        _ => solve_as::<24, 3, 12>(file, method, settings),
    }
    .expect("bundled scenes are valid")
}

/// The default penalty `rho` of a scene.
pub(crate) fn penalty(file: &SceneFile) -> f64 {
    match file.dim {
        2 => penalty_as::<6, 2, 4>(file),
        _ => penalty_as::<24, 3, 12>(file),
    }
    .expect("bundled scenes are valid")
}

fn penalty_as<const N: usize, const D: usize, const C: usize>(
    file: &SceneFile,
) -> Result<f64, Error> {
    let factor = Factor::new(&file.scene::<f64, N, D, C>()?)?;
    Ok(factor.penalty())
}

fn solve_as<const N: usize, const D: usize, const C: usize>(
    file: &SceneFile,
    method: Method,
    settings: &Settings<f64>,
) -> Result<Outcome, Error> {
    let scene = file.scene::<f64, N, D, C>()?;
    let factor = Factor::new(&scene)?;
    let f = file.free_impulse();
    let (mut solver, mut admm) = (Solver::new(), AdmmSolver::new());
    let solution = match method {
        Method::Plain => admm.solve_plain(&scene, &factor, &f, settings)?,
        Method::Fast => admm.solve_fast(&scene, &factor, &f, settings)?,
        Method::Restart => admm.solve_restart(&scene, &factor, &f, settings)?,
        Method::Default => solver.solve(&scene, &factor, &f, settings)?,
    };
    let v = solution.velocity.as_slice();
    let v = v.get(..file.n_dof).unwrap_or(v);
    let impulses = solution.contacts.iter().flat_map(|c| c.impulse.iter());
    let r: Vec<f64> = impulses.copied().collect();
    let law = match settings.slip {
        SlipUpdate::Never => Law::Relaxed,
        _ => Law::Coulomb,
    };
    let claimed = solution.status == Status::Solved;
    Ok(Outcome {
        solved: claimed && measure::error(file, v, &r, law) <= settings.tolerance,
        iterations: solution.iterations + 10 * solution.newton_steps,
        coulomb_error: measure::error(file, v, &r, Law::Coulomb),
        impulse: r,
    })
}
