//! The bundled scenes: what is solved, how exactly, in how many iterations.

use crate::support::check;
use nalgebra::SVector;
use stiction::{Error, Settings, Status};
use testbed::kernel::{self, Constructor, smallest};
use testbed::measure::{self, Law};
use testbed::method::Method;
use testbed::scene_file::{SceneFile, bundled_scenes};

/// One scene solved.
struct Run {
    name: String,
    status: Status,
    /// In iterations; a Newton step counts as ten.
    work: usize,
    /// Recomputed in f64 from the file.
    error: f64,
}

/// A cold solve.
fn solve(
    kernel: Constructor,
    file: &SceneFile,
    method: Method,
    settings: &Settings<f64>,
) -> Result<Run, Error> {
    let mut kernel = kernel::prepared(kernel, file, method)?;
    kernel.solve(method, settings)?;
    let answer = kernel.answer();
    Ok(Run {
        name: file.name.clone(),
        status: answer.status,
        work: answer.work.total(),
        error: measure::error(file, &answer.v, &answer.r, Law::Coulomb),
    })
}

/// All bundled scenes, or those that have a solution.
fn files(feasible_only: bool) -> Vec<SceneFile> {
    let files = bundled_scenes().into_iter();
    let wanted = |file: &SceneFile| !feasible_only || !file.name.starts_with("infeasible");
    let files: Vec<_> = files.filter(wanted).collect();
    assert!(files.len() > 40, "the scenes are not where they were");
    files
}

/// Scenes of [`files`] that are solved, and the work that half of them, nine in ten and all take at most.
fn solved(kernel: Constructor, method: Method, tolerance: f64) -> Result<(usize, [usize; 3]), Error> {
    let settings = Settings { budget: 1_000, ..Settings::new(tolerance) };
    let runs = files(true)
        .iter()
        .map(|file| solve(kernel, file, method, &settings))
        .collect::<Result<Vec<_>, _>>()?;
    let solved = runs.iter().filter(|run| run.status == Status::Solved);
    let mut work: Vec<_> = runs.iter().map(|run| run.work).collect();
    work.sort_unstable();
    let last = work.len() - 1;
    Ok((solved.count(), [50, 90, 100].map(|share| work[last * share / 100])))
}

/// What was measured, of 42 scenes within 1,000 work: a change that solves fewer, or costs one iteration in twenty more, fails.
#[test]
fn as_many_scenes_are_solved_with_as_little_work_as_before() -> Result<(), Error> {
    let (double, single): (Constructor, Constructor) = (smallest::<f64>, smallest::<f32>);
    let mut changed = Vec::new();
    for (kernel, method, tolerance, before) in [
        (double, Method::Default, 1e-3, (42, [10, 20, 68])),
        (double, Method::Default, 1e-6, (42, [10, 24, 198])),
        (double, Method::Default, 1e-9, (42, [14, 28, 232])),
        (single, Method::Default, 1e-3, (42, [10, 30, 68])),
        (single, Method::Default, 1e-5, (42, [10, 30, 76])),
        (double, Method::Restart, 1e-3, (42, [19, 65, 323])),
        (double, Method::Restart, 1e-6, (42, [41, 143, 514])),
        (single, Method::Restart, 1e-3, (42, [19, 65, 316])),
    ] {
        let now = solved(kernel, method, tolerance)?;
        let work = now.1.into_iter().zip(before.1);
        if now.0 < before.0 || !work.into_iter().all(check::is_no_more) {
            changed.push(format!("{method:?} to {tolerance:e}: {now:?}, not {before:?}"));
        }
    }
    assert!(changed.is_empty(), "{}", changed.join("\n"));
    Ok(())
}

/// Two walls that close on a body: no velocity satisfies `H_N v + w_N >= 0`, says Farkas' `d`.
#[test]
fn an_infeasible_scene_is_proved_infeasible() -> Result<(), Error> {
    let files = files(false);
    let file = files.iter().find(|file| file.name == "infeasible_squeeze");
    let file = file.expect("it is bundled");
    let (scene, push) = (file.scene::<f64, 3, 3, 3>()?, file.free_impulse());
    let solution = Method::Default.solve(&scene, &push, &Settings::new(1e-6))?;
    assert_eq!(solution.status, Status::Infeasible);
    let proof = scene.contacts().iter().zip(&solution.certificate);
    let proof = proof.fold((SVector::<f64, 3>::zeros(), 0.0), |(force, power), (contact, d)| {
        assert!(d[0] >= 0.0 && d[1] == 0.0 && d[2] == 0.0);
        let d = d[0];
        let normal = contact.jacobian.row(0).transpose();
        (force + normal * d, power + contact.offset[0] * d)
    });
    let (force, power) = proof;
    assert!(power < 0.0);
    assert!(force.norm() <= 1e-12 * solution.certificate.iter().sum::<SVector<f64, 3>>()[0]);
    Ok(())
}

/// Whatever the method, the precision and the tolerance: `Solved` is a promise about the error.
#[test]
fn what_is_called_solved_is_solved() -> Result<(), Error> {
    let files = files(false);
    for exponent in 2..=8 {
        let settings = Settings { budget: 400, ..Settings::new(10_f64.powi(-exponent)) };
        for (method, file) in Method::ALL.into_iter().flat_map(|m| files.iter().map(move |f| (m, f))) {
            let runs = [
                solve(smallest::<f64>, file, method, &settings)?,
                solve(smallest::<f32>, file, method, &settings)?,
            ];
            for (run, precision) in runs.iter().zip(["f64", "f32"]) {
                let honest = run.status != Status::Solved || run.error <= settings.tolerance;
                let (name, error) = (&run.name, run.error);
                assert!(honest, "{name} 1e-{exponent} {method:?} {precision}: {error:e}");
            }
        }
    }
    Ok(())
}
