//! The state between solves: what a warm start saves, and that it may live in a `static`.

mod support;

use nalgebra::{SMatrix, SVector, matrix, vector};
use std::sync::Mutex;
use stiction::{AdmmSolver, Contact, Error, Factor, Scene, Settings, Solution, Solver, Status};
use support::boxes::{BRICK, BoxScene};
use support::measure::{Law, error_of};

fn settings() -> Settings<f64> {
    Settings::new(1e-8)
}

/// A box that slides down a slope, and its free impulse turned a little.
fn sliding_box() -> Result<(BoxScene<f64>, [SVector<f64, 6>; 2]), Error> {
    let free_impulses = [0.5, 0.501].map(|slope| BRICK.free_impulse(slope, 0.01));
    Ok((BRICK.on_plane(0.3)?, free_impulses))
}

/// A Newton step counts as ten iterations.
fn cost<const N: usize, const D: usize, const C: usize>(
    solution: &Solution<f64, N, D, C>,
) -> usize {
    assert_eq!(solution.status, Status::Solved);
    solution.iterations + 10 * solution.newton_steps
}

#[test]
fn the_same_problem_again_costs_nothing() -> Result<(), Error> {
    let (scene, [f, _]) = sliding_box()?;
    let factor = Factor::new(&scene)?;
    let mut newton = Solver::new();
    assert!(cost(newton.solve(&scene, &factor, &f, &settings())?) > 0);
    let again = newton.solve(&scene, &factor, &f, &settings())?;
    assert_eq!((cost(again), again.factorizations), (0, 0));
    assert!(error_of(&scene, &f, again, Law::Coulomb) <= settings().tolerance);

    let mut admm = AdmmSolver::new();
    assert!(cost(admm.solve_restart(&scene, &factor, &f, &settings())?) > 0);
    assert_eq!(
        cost(admm.solve_restart(&scene, &factor, &f, &settings())?),
        0
    );
    assert_eq!(cost(admm.solve_plain(&scene, &factor, &f, &settings())?), 0);
    assert_eq!(cost(admm.solve_fast(&scene, &factor, &f, &settings())?), 0);
    Ok(())
}

#[test]
fn a_problem_like_the_last_costs_less_than_cold() -> Result<(), Error> {
    let (scene, [f, changed]) = sliding_box()?;
    let factor = Factor::new(&scene)?;
    let (mut cold, mut warm) = (Solver::new(), Solver::new());
    warm.solve(&scene, &factor, &f, &settings())?;
    let warm = cost(warm.solve(&scene, &factor, &changed, &settings())?);
    let cold = cost(cold.solve(&scene, &factor, &changed, &settings())?);
    assert!(warm < cold, "newton: warm {warm}, cold {cold}");

    let (mut cold, mut warm) = (AdmmSolver::new(), AdmmSolver::new());
    warm.solve_restart(&scene, &factor, &f, &settings())?;
    let warm = cost(warm.solve_restart(&scene, &factor, &changed, &settings())?);
    let cold = cost(cold.solve_restart(&scene, &factor, &changed, &settings())?);
    assert!(warm < cold, "restart: warm {warm}, cold {cold}");
    Ok(())
}

#[test]
fn after_a_reset_the_solver_is_as_new() -> Result<(), Error> {
    let (scene, [f, changed]) = sliding_box()?;
    let factor = Factor::new(&scene)?;
    let (mut fresh, mut used) = (Solver::new(), Solver::new());
    used.solve(&scene, &factor, &changed, &settings())?;
    used.reset();
    let fresh = fresh.solve(&scene, &factor, &f, &settings())?;
    let used = used.solve(&scene, &factor, &f, &settings())?;
    assert_eq!((fresh.velocity, cost(fresh)), (used.velocity, cost(used)));

    let (mut fresh, mut used) = (AdmmSolver::new(), AdmmSolver::new());
    used.solve_restart(&scene, &factor, &changed, &settings())?;
    used.reset();
    let fresh = fresh.solve_restart(&scene, &factor, &f, &settings())?;
    let used = used.solve_restart(&scene, &factor, &f, &settings())?;
    assert_eq!((fresh.velocity, cost(fresh)), (used.velocity, cost(used)));
    Ok(())
}

/// Bodies that do not touch each other on one floor, so that each contact is a problem of its own:
/// body `i` has the velocities `3 i ..`, slides, and is in the scene if it is listed.
fn bodies(listed: &[usize]) -> Result<(Scene<f64, 9, 3, 3>, SVector<f64, 9>), Error> {
    let mut scene = Scene::new();
    scene.set_mass(&SMatrix::from_diagonal_element(1.0))?;
    for body in listed {
        let mut jacobian = SMatrix::<f64, 3, 9>::zeros();
        let rows = matrix![0.0, 0.0, 1.0; 1.0, 0.0, 0.0; 0.0, 1.0, 0.0];
        jacobian
            .fixed_view_mut::<3, 3>(0, 3 * body)
            .copy_from(&rows);
        let offset = SVector::zeros();
        scene.push(&Contact {
            jacobian,
            offset,
            mu: 0.4,
        })?;
    }
    let f = [(1.0, 0.2, 0.7), (0.3, -0.9, 1.3), (-0.8, 0.5, 0.9)];
    let f = f.into_iter().flat_map(|(x, y, z)| [x, y, z]);
    Ok((scene, SVector::from_iterator(f)))
}

/// Solves `before`, says which contact was which, and gives the cost of `after`.
fn carried(
    before: &[usize],
    after: &[usize],
    previous: &[Option<usize>],
) -> Result<[usize; 2], Error> {
    let (mut newton, mut admm) = (Solver::new(), AdmmSolver::new());
    let (scene, f) = bodies(before)?;
    let factor = Factor::new(&scene)?;
    newton.solve(&scene, &factor, &f, &settings())?;
    admm.solve_restart(&scene, &factor, &f, &settings())?;
    newton.carry_over(previous);
    admm.carry_over(previous);
    let (scene, f) = bodies(after)?;
    let factor = Factor::new(&scene)?;
    Ok([
        cost(newton.solve(&scene, &factor, &f, &settings())?),
        cost(admm.solve_restart(&scene, &factor, &f, &settings())?),
    ])
}

#[test]
fn contacts_that_stay_are_warm_when_one_goes() -> Result<(), Error> {
    assert_eq!(carried(&[0, 1, 2], &[0, 2], &[Some(0), Some(2)])?, [0, 0]);
    assert_eq!(
        carried(&[0, 1, 2], &[2, 0, 1], &[Some(2), Some(0), Some(1)])?,
        [0, 0]
    );
    Ok(())
}

#[test]
fn a_contact_that_comes_is_cold() -> Result<(), Error> {
    for cost in carried(&[0, 2], &[0, 1, 2], &[Some(0), None, Some(1)])? {
        assert!(cost > 0);
    }
    Ok(())
}

#[test]
fn contacts_that_are_not_carried_or_do_not_exist_are_cold() -> Result<(), Error> {
    let cold = carried(&[0, 1, 2], &[0, 1, 2], &[])?;
    assert!(cold.into_iter().all(|cost| cost > 0));
    assert_eq!(
        carried(&[0, 1, 2], &[0, 1, 2], &[Some(3), Some(usize::MAX), None])?,
        cold
    );
    Ok(())
}

#[test]
fn scene_factor_and_solvers_live_in_statics() -> Result<(), Error> {
    static SCENE: Mutex<Scene<f32, 2, 2, 1>> = Mutex::new(Scene::new());
    static FACTOR: Mutex<Factor<f32, 2, 2, 1>> = Mutex::new(Factor::empty());
    static SOLVER: Mutex<Solver<f32, 2, 2, 1>> = Mutex::new(Solver::new());
    static ADMM: Mutex<AdmmSolver<f32, 2, 2, 1>> = Mutex::new(AdmmSolver::new());
    let mut scene = SCENE.lock().expect("one thread");
    let mut factor = FACTOR.lock().expect("one thread");
    scene.set_mass(&matrix![2.0, 0.0; 0.0, 2.0])?;
    scene.push(&Contact {
        jacobian: matrix![0.0, 1.0; 1.0, 0.0],
        offset: vector![0.0, 0.0],
        mu: 0.5,
    })?;
    factor.compute(&scene)?;
    let (f, settings) = (vector![-0.05, 0.2], Settings::default());
    let mut solver = SOLVER.lock().expect("one thread");
    let mut admm = ADMM.lock().expect("one thread");
    let newton = solver.solve(&scene, &factor, &f, &settings)?;
    let restart = admm.solve_restart(&scene, &factor, &f, &settings)?;
    assert_eq!(
        (newton.status, restart.status),
        (Status::Solved, Status::Solved)
    );
    Ok(())
}
