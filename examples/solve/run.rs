//! Solves one scene with the smallest compiled size that holds it.

use crate::support::measure::{self, Law};
use crate::support::scene_file::SceneFile;
use crate::{Method, Options, Precision};
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

/// Solves a scene, or says why it cannot be solved.
pub(crate) fn solve(scene: &SceneFile, options: &Options) -> Result<Run, String> {
    match options.precision {
        Precision::F64 => solve_sized::<f64>(scene, options),
        Precision::F32 => solve_sized::<f32>(scene, options),
    }
}

fn solve_sized<T: Real>(scene: &SceneFile, options: &Options) -> Result<Run, String> {
    macro_rules! sizes {
        ($d:literal: $($n:literal),*) => {
            match (scene.n_dof, scene.n_contacts) {
                $(
                    (..=$n, ..=4) => solve_as::<T, $n, $d, 4>(scene, options),
                    (..=$n, ..=12) => solve_as::<T, $n, $d, 12>(scene, options),
                )*
                (n, c) => return Err(format!("{n} dofs and {c} contacts: at most 30 and 12")),
            }
        };
    }
    match scene.dim {
        2 => sizes!(2: 6, 18, 30),
        3 => sizes!(3: 6, 12, 18, 24, 30),
        dim => return Err(format!("dim {dim} is not 2 or 3")),
    }
    .map_err(|error| format!("{}: {error}", scene.name))
}

fn solve_as<T: Real, const N: usize, const D: usize, const C: usize>(
    file: &SceneFile,
    options: &Options,
) -> Result<Run, Error> {
    let scene = file.scene::<T, N, D, C>()?;
    let f = file.free_impulse::<T, N>();
    let tolerance = options.tolerance.unwrap_or(match options.precision {
        Precision::F64 => 1e-9,
        Precision::F32 => 1e-4,
    });
    let settings = Settings {
        max_iterations: options.max_iterations,
        ..Settings::new(T::literal(tolerance))
    };
    let mut factor = Factor::empty();
    let (mut solver, mut admm) = (Solver::new(), AdmmSolver::new());
    let (mut prepare_ns, mut solve_ns) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..options.repeat.max(1) {
        let start = Instant::now();
        factor.compute(black_box(&scene))?;
        prepare_ns = prepare_ns.min(start.elapsed().as_secs_f64() * 1e9);

        solver.reset();
        admm.reset();
        let start = Instant::now();
        let (scene, factor, f) = (black_box(&scene), black_box(&factor), black_box(&f));
        let solution = match options.method {
            Method::Plain => admm.solve_plain(scene, factor, f, &settings)?,
            Method::Fast => admm.solve_fast(scene, factor, f, &settings)?,
            Method::Restart => admm.solve_restart(scene, factor, f, &settings)?,
            Method::Default => solver.solve(scene, factor, f, &settings)?,
        };
        black_box(solution);
        solve_ns = solve_ns.min(start.elapsed().as_secs_f64() * 1e9);
    }
    let solution = match options.method {
        Method::Default => solver.solution(),
        _ => admm.solution(),
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
