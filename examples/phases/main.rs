//! Which share of drawn scenes each set of phases solves, cold, in `f32`, with the default budget, and with what work.
//!
//! `cargo run --release -p phases` prints lines `machine solver quantity value` for the table of the firmware page: ten-thousandths
//! of the scenes that the solver calls solved, and work. A scene that is called solved and is not ends the program.

use rayon::iter::{IntoParallelIterator, ParallelIterator};
use stiction::{
    AdmmFactor, AdmmSolver, AllPhases, Error, Factor, Phases, Real, Scene, Settings, Solution, Solver,
    SweepsAndNewton, SweepsOnly,
};
use testbed::generate::{self, Class, Existence};
use testbed::measure::{self, Law};
use testbed::scene_file::SceneFile;

/// All drawn scenes of three rows a contact fit.
const N: usize = 30;
const D: usize = 3;
const C: usize = 12;
/// An even seed: nothing was tuned on it.
const SEED: u64 = 2024;
const COUNT: u64 = 10_000;

type Solve = fn(&SceneFile, &Scene<f32, N, D, C>, &Settings<f32>) -> Result<Solution<f32, N, D, C>, Error>;

fn by_phases<P: Phases>(
    file: &SceneFile,
    scene: &Scene<f32, N, D, C>,
    settings: &Settings<f32>,
    phases: P,
) -> Result<Solution<f32, N, D, C>, Error> {
    let factor = Factor::new(scene)?;
    let mut solver = Solver::with_phases(phases);
    let solution = solver.solve(scene, &factor, &file.free_impulse(), settings);
    solution.cloned()
}

fn by_admm(
    file: &SceneFile,
    scene: &Scene<f32, N, D, C>,
    settings: &Settings<f32>,
) -> Result<Solution<f32, N, D, C>, Error> {
    let factor = AdmmFactor::new(scene)?;
    let mut solver = AdmmSolver::new();
    let solution = solver.solve(scene, &factor, &file.free_impulse(), settings);
    solution.cloned()
}

/// Work, if it was solved.
fn solved(file: &SceneFile, tolerance: f64, solve: Solve) -> Option<usize> {
    let settings = Settings::new(f32::literal(tolerance));
    let scene = file.scene().expect("numbers are finite");
    let solution = solve(file, &scene, &settings).ok().filter(Solution::is_solved)?;
    let v: Vec<f64> = solution.velocity.iter().map(|&v| v.into()).collect();
    let impulses = solution.contacts.iter().flat_map(|contact| &contact.impulse);
    let r: Vec<f64> = impulses.map(|&r| r.into()).collect();
    let error = measure::error(&file.rounded::<f32>(), &v[..file.n_dof], &r, Law::Coulomb);
    assert!(error <= tolerance, "{}: {error} is no {tolerance}", file.name);
    Some(solution.work.total())
}

fn main() {
    let drawn = (0..COUNT).into_par_iter().filter_map(|index| {
        let turn = usize::try_from(index).expect("a small number") % Class::DRAWN.len();
        let (file, existence) = generate::draw(Class::DRAWN[turn], SEED, index);
        (file.dim == D && existence != Existence::Infeasible).then_some(file)
    });
    let files: Vec<SceneFile> = drawn.collect();
    println!("m4f32 phases scenes {}", files.len());
    let solvers: [(&str, Solve); 4] = [
        ("all", |file, scene, settings| by_phases(file, scene, settings, AllPhases)),
        ("newton", |file, scene, settings| by_phases(file, scene, settings, SweepsAndNewton)),
        ("sweeps", |file, scene, settings| by_phases(file, scene, settings, SweepsOnly)),
        ("restart", by_admm),
    ];
    for (name, solve) in solvers {
        for (label, tolerance) in [("1e-3", 1e-3), ("1e-4", 1e-4)] {
            let outcomes = files.as_slice().into_par_iter();
            let mut work: Vec<usize> = outcomes.filter_map(|file| solved(file, tolerance, solve)).collect();
            work.sort_unstable();
            println!("m4f32 phases {name}_solved_{label} {}", work.len() * 10_000 / files.len());
            for percent in [50, 90] {
                // Of all scenes: one that is not solved takes more than any that is.
                let rank = (files.len() - 1) * percent / 100;
                if let Some(work) = work.get(rank) {
                    println!("m4f32 phases {name}_work_{percent}_{label} {work}");
                }
            }
        }
    }
}
