//! Solves a scene, or the time steps of a sequence, with the smallest compiled size that holds it.

use crate::support::measure::{self, Law};
use crate::support::scene_file::SceneFile;
use crate::support::solve;
use crate::{Method, Options, Precision, Start};
use std::hint::black_box;
use std::time::Instant;
use stiction::{AdmmSolver, ContactMode, Error, Factor, Real, Settings, Solver, Status};

/// One solved scene.
pub(crate) struct Run {
    pub(crate) name: String,
    pub(crate) n_dof: usize,
    pub(crate) n_contacts: usize,
    pub(crate) dim: usize,
    pub(crate) status: Status,
    pub(crate) iterations: usize,
    pub(crate) newton_steps: usize,
    pub(crate) factorizations: usize,
    /// Recomputed in f64.
    pub(crate) error: f64,
    pub(crate) prepare_ns: f64,
    pub(crate) solve_ns: f64,
    pub(crate) v: Vec<f64>,
    pub(crate) r: Vec<f64>,
    pub(crate) modes: Vec<ContactMode>,
    /// `d`, row by row with zero tangential parts, if the scene is infeasible.
    pub(crate) certificate: Option<Vec<f64>>,
}

/// Solves scenes one after the other, each cold or each from the one before, or says why one cannot
/// be solved.
pub(crate) fn solve(
    scenes: &[SceneFile],
    start: Start,
    options: &Options,
) -> Result<Vec<Run>, String> {
    match options.precision {
        Precision::F64 => solve_sized::<f64>(scenes, start, options),
        Precision::F32 => solve_sized::<f32>(scenes, start, options),
    }
}

fn solve_sized<T: Real>(
    scenes: &[SceneFile],
    start: Start,
    options: &Options,
) -> Result<Vec<Run>, String> {
    let Some(scene) = scenes.iter().max_by_key(|scene| scene.n_contacts) else {
        return Ok(Vec::new());
    };
    macro_rules! sizes {
        ($d:literal: $($n:literal),*) => {
            match (scene.n_dof, scene.n_contacts) {
                $(
                    (..=$n, ..=4) => solve_as::<T, $n, $d, 4>(scenes, start, options),
                    (..=$n, ..=12) => solve_as::<T, $n, $d, 12>(scenes, start, options),
                )*
                (n, c) => Err(format!("{n} dofs and {c} contacts: at most 30 and 12")),
            }
        };
    }
    match scene.dim {
        2 => sizes!(2: 6, 18, 30),
        3 => sizes!(3: 6, 12, 18, 24, 30),
        dim => Err(format!("dim {dim} is not 2 or 3")),
    }
}

/// The solvers between two scenes.
#[derive(Clone)]
struct Solvers<T, const N: usize, const D: usize, const C: usize> {
    factor: Factor<T, N, D, C>,
    newton: Solver<T, N, D, C>,
    admm: AdmmSolver<T, N, D, C>,
}

fn solve_as<T: Real, const N: usize, const D: usize, const C: usize>(
    scenes: &[SceneFile],
    start: Start,
    options: &Options,
) -> Result<Vec<Run>, String> {
    let mut solvers = Box::new(Solvers::<T, N, D, C> {
        factor: Factor::empty(),
        newton: Solver::new(),
        admm: AdmmSolver::new(),
    });
    let mut runs = Vec::new();
    for scene in scenes {
        if start == Start::Cold {
            solvers.newton.reset();
            solvers.admm.reset();
        }
        let run = solve_one(scene, &mut solvers, options);
        runs.push(run.map_err(|error| format!("{}: {error}", scene.name))?);
    }
    Ok(runs)
}

fn solve_one<T: Real, const N: usize, const D: usize, const C: usize>(
    file: &SceneFile,
    solvers: &mut Solvers<T, N, D, C>,
    options: &Options,
) -> Result<Run, Error> {
    let scene = file.scene::<T, N, D, C>()?;
    let f = file.free_impulse::<T, N>();
    let settings = Settings {
        max_iterations: options.max_iterations,
        ..Settings::new(T::literal(options.tolerance()))
    };
    let (mut prepare_ns, mut solve_ns) = (f64::INFINITY, f64::INFINITY);
    let (newton, admm) = (solvers.newton.clone(), solvers.admm.clone());
    let Solvers {
        factor,
        newton: solver,
        admm: admm_solver,
    } = solvers;
    // What a solve does without is not prepared.
    let spares_resolvent = options.method == Method::Default
        && solve::spares_resolvent(&scene, factor, &newton, &f, &settings)?;
    for _ in 0..options.repeat {
        let start = Instant::now();
        if spares_resolvent {
            factor.update(black_box(&scene))?;
        } else {
            factor.compute(black_box(&scene))?;
        }
        prepare_ns = prepare_ns.min(start.elapsed().as_secs_f64() * 1e9);

        solver.clone_from(&newton);
        admm_solver.clone_from(&admm);
        let start = Instant::now();
        let (scene, factor, f) = (black_box(&scene), black_box(&*factor), black_box(&f));
        let solution = match options.method {
            Method::Plain => admm_solver.solve_plain(scene, factor, f, &settings)?,
            Method::Fast => admm_solver.solve_fast(scene, factor, f, &settings)?,
            Method::Restart => admm_solver.solve_restart(scene, factor, f, &settings)?,
            Method::Default => solver.solve(scene, factor, f, &settings)?,
        };
        black_box(solution);
        solve_ns = solve_ns.min(start.elapsed().as_secs_f64() * 1e9);
    }
    let solution = match options.method {
        Method::Default => solver.solution(),
        _ => admm_solver.solution(),
    };
    let double = |x: &T| x.to_subset().unwrap_or(f64::NAN);
    let velocity = solution.velocity.iter().take(file.n_dof);
    let impulses = solution.contacts.iter().flat_map(|c| c.impulse.iter());
    let (v, r): (Vec<f64>, Vec<f64>) = (
        velocity.map(double).collect(),
        impulses.map(double).collect(),
    );
    Ok(Run {
        name: file.name.clone(),
        n_dof: file.n_dof,
        n_contacts: file.n_contacts,
        dim: file.dim,
        status: solution.status,
        iterations: solution.iterations,
        newton_steps: solution.newton_steps,
        factorizations: solution.factorizations,
        error: measure::error(file, &v, &r, Law::Coulomb),
        prepare_ns,
        solve_ns,
        v,
        r,
        certificate: (solution.status == Status::Infeasible).then(|| {
            let normals = solution.certificate.iter().map(double);
            normals
                .flat_map(|d| (0..D).map(move |row| if row == 0 { d } else { 0.0 }))
                .collect()
        }),
        modes: solution.contacts.iter().map(|c| c.mode).collect(),
    })
}
