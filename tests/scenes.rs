//! The bundled scenes: what is solved, how exactly, in how many iterations.

mod support;

use nalgebra::SVector;
use stiction::{Error, Real, Settings, Status};
use support::measure::{self, Law};
use support::method::Method;
use support::scene_file::{self, SceneFile};

/// One scene solved.
struct Run {
    name: String,
    status: Status,
    /// In iterations; a Newton step counts as ten.
    cost: usize,
    /// Recomputed in f64 from the file.
    error: f64,
}

/// Solves a scene with the smallest of a few compiled sizes that holds it.
fn solve<T: Real>(
    file: &SceneFile,
    method: Method,
    settings: &Settings<f64>,
) -> Result<Run, Error> {
    match (file.dim, file.n_dof, file.n_contacts) {
        (2, ..=6, ..=4) => solve_as::<T, 6, 2, 4>(file, method, settings),
        (3, ..=6, ..=8) => solve_as::<T, 6, 3, 8>(file, method, settings),
        (3, ..=18, ..=12) => solve_as::<T, 18, 3, 12>(file, method, settings),
        (3, ..=24, ..=12) => solve_as::<T, 24, 3, 12>(file, method, settings),
        sizes => panic!("{}: no size for {sizes:?}", file.name),
    }
}

fn solve_as<T: Real, const N: usize, const D: usize, const C: usize>(
    file: &SceneFile,
    method: Method,
    settings: &Settings<f64>,
) -> Result<Run, Error> {
    let (scene, f) = (file.scene::<T, N, D, C>()?, file.free_impulse());
    let settings = Settings {
        tolerance: T::literal(settings.tolerance),
        max_iterations: settings.max_iterations,
        slip: settings.slip,
    };
    let solution = method.solve(&scene, &f, &settings)?;
    let (v, r) = (measure::velocity(&solution), measure::impulses(&solution));
    Ok(Run {
        name: file.name.clone(),
        status: solution.status,
        cost: solution.iterations + 10 * solution.newton_steps,
        error: measure::error(file, &v[..file.n_dof], &r, Law::Coulomb),
    })
}

/// All bundled scenes, or those that have a solution.
fn files(feasible_only: bool) -> Vec<SceneFile> {
    let files = scene_file::bundled();
    let files = files
        .iter()
        .flat_map(|path| scene_file::read(path).expect("a scene file"));
    let wanted = |file: &SceneFile| !feasible_only || !file.name.starts_with("infeasible");
    let files: Vec<_> = files.filter(wanted).collect();
    assert!(files.len() > 40, "the scenes are not where they were");
    files
}

fn solve_feasible<T: Real>(method: Method, tolerance: f64) -> Result<Vec<Run>, Error> {
    let settings = Settings::new(tolerance);
    let files = files(true);
    files
        .iter()
        .map(|file| solve::<T>(file, method, &settings))
        .collect()
}

/// Percentage of the runs that say they are solved, and the names of the others.
fn solved(runs: &[Run]) -> (usize, Vec<&str>) {
    let left = runs.iter().filter(|run| run.status != Status::Solved);
    let left: Vec<_> = left.map(|run| run.name.as_str()).collect();
    (100 * (runs.len() - left.len()) / runs.len(), left)
}

fn median_cost(runs: &[Run]) -> usize {
    let mut costs: Vec<_> = runs.iter().map(|run| run.cost).collect();
    costs.sort_unstable();
    costs[costs.len() / 2]
}

#[test]
fn restarted_admm_solves_every_feasible_scene_to_a_thousandth() -> Result<(), Error> {
    let runs = solve_feasible::<f64>(Method::Restart, 1e-3)?;
    let (share, left) = solved(&runs);
    assert!(share == 100, "{left:?}");
    Ok(())
}

#[test]
fn restarted_admm_solves_most_scenes_to_a_millionth() -> Result<(), Error> {
    let runs = solve_feasible::<f64>(Method::Restart, 1e-6)?;
    let (share, left) = solved(&runs);
    assert!(share >= 87, "{share} %, left: {left:?}");
    Ok(())
}

#[test]
fn single_precision_solves_nearly_every_scene_to_a_thousandth() -> Result<(), Error> {
    for method in [Method::Restart, Method::Newton] {
        let runs = solve_feasible::<f32>(method, 1e-3)?;
        let (share, left) = solved(&runs);
        assert!(share >= 95, "{method:?}: {share} %, left: {left:?}");
    }
    Ok(())
}

#[test]
fn newton_solves_every_feasible_scene_to_a_billionth() -> Result<(), Error> {
    let runs = solve_feasible::<f64>(Method::Newton, 1e-9)?;
    let (share, left) = solved(&runs);
    assert!(share == 100, "{left:?}");
    Ok(())
}

/// Medians measured to 1e-6 in f64; a change that costs more than one iteration in ten shows here.
#[test]
fn the_median_cost_of_a_solve_does_not_grow() -> Result<(), Error> {
    for (method, measured) in [(Method::Restart, 49), (Method::Newton, 25)] {
        let median = median_cost(&solve_feasible::<f64>(method, 1e-6)?);
        assert!(median <= measured + measured / 10, "{method:?}: {median}");
    }
    Ok(())
}

/// Two walls that close on a body: no velocity satisfies `H_N v + w_N >= 0`, says Farkas' `d`.
#[test]
fn an_infeasible_scene_is_proved_infeasible() -> Result<(), Error> {
    let files = files(false);
    let file = files.iter().find(|file| file.name == "infeasible_squeeze");
    let file = file.expect("it is bundled");
    let (scene, f) = (file.scene::<f64, 3, 3, 2>()?, file.free_impulse());
    let solution = Method::Newton.solve(&scene, &f, &Settings::new(1e-6))?;
    assert_eq!(solution.status, Status::Infeasible);
    let proof = scene.contacts().iter().zip(&solution.certificate);
    let proof = proof.fold(
        (SVector::<f64, 3>::zeros(), 0.0),
        |(force, power), (contact, &d)| {
            assert!(d >= 0.0);
            let normal = contact.jacobian.row(0).transpose();
            (force + normal * d, power + contact.offset[0] * d)
        },
    );
    let (force, power) = proof;
    assert!(power < 0.0);
    assert!(force.norm() <= 1e-12 * solution.certificate.iter().sum::<f64>());
    Ok(())
}

/// Whatever the method, the precision and the tolerance: `Solved` is a promise about the error.
#[test]
fn what_is_called_solved_is_solved() -> Result<(), Error> {
    let files = files(false);
    for exponent in 2..=8 {
        let settings = Settings {
            max_iterations: 400,
            ..Settings::new(10_f64.powi(-exponent))
        };
        for (method, file) in Method::ALL
            .into_iter()
            .flat_map(|m| files.iter().map(move |f| (m, f)))
        {
            let runs = [
                solve::<f64>(file, method, &settings)?,
                solve::<f32>(file, method, &settings)?,
            ];
            for (run, precision) in runs.iter().zip(["f64", "f32"]) {
                let honest = run.status != Status::Solved || run.error <= settings.tolerance;
                let (name, error) = (&run.name, run.error);
                assert!(
                    honest,
                    "{name} 1e-{exponent} {method:?} {precision}: {error:e}"
                );
            }
        }
    }
    Ok(())
}
