//! Scene, factor and solver in one value.

use crate::support::boxes::{BRICK, planar_floor};
use crate::support::sizes::block;
use nalgebra::{Matrix2, Matrix6, matrix, vector};
use stiction::{
    AdmmFactor, AdmmSolver, Contact, ContactMode, Error, Factor, Kernel, Scene, Settings, Solution, Solver,
    Status,
};

/// It stands in a `static`.
static EMPTY: Kernel<f64, 6, 3, 4> = Kernel::new();

fn fill(scene: &mut Scene<f64, 6, 3, 4>, mu: f64) -> Result<(), Error> {
    let source = BRICK.on_plane::<f64>(mu)?;
    scene.set_mass(source.mass())?;
    scene.clear_contacts();
    for contact in source.contacts() {
        scene.push(contact)?;
    }
    Ok(())
}

/// A body that is declared at rest is asked whether it can stay, also if the first call has no time for that.
#[test]
fn a_call_without_a_budget_forgets_no_presumed_rest() -> Result<(), Error> {
    let settings = Settings::new(1e-9);
    let mut asked = 0;
    for slope in [0.2, 0.25, 0.28, 0.29, 0.2914] {
        let push = BRICK.free_impulse(slope, 0.01);
        let solution = |rests: bool, budgets: &[usize]| -> Result<String, Error> {
            let mut kernel = EMPTY.clone();
            fill(kernel.scene_mut(), 0.3)?;
            if rests {
                kernel.solver_mut().presume_rest();
            }
            for &budget in budgets {
                kernel.resume(&push, &Settings { budget, ..settings })?;
            }
            let solution = kernel.solution();
            assert!(solution.is_solved());
            Ok(format!("{:?} {:?} {:?}", solution.velocity, solution.contacts, solution.work))
        };
        let once = solution(true, &[10_000])?;
        assert_eq!(solution(true, &[0, 10_000])?, once, "{slope}");
        asked += usize::from(once != solution(false, &[10_000])?);
    }
    assert!(asked > 0);
    Ok(())
}

#[test]
fn a_kernel_gives_the_bits_of_its_parts() -> Result<(), Error> {
    let settings = Settings::new(1e-9);
    let (mut kernel, mut solver) = (EMPTY.clone(), Solver::new());
    for (tick, mu) in [0.3, 0.3, 0.6].into_iter().enumerate() {
        fill(kernel.scene_mut(), mu)?;
        if tick == 1 {
            let longer = kernel.scene().contacts()[0].jacobian * 1.25;
            kernel.scene_mut().set_jacobian(0, &longer)?;
        }
        let push = BRICK.free_impulse(0.5, 0.01);
        let scene = kernel.scene().clone();
        let factor = Factor::new(&scene)?;
        let parts = solver.solve(&scene, &factor, &push, &settings)?;
        let whole = kernel.solve(&push, &settings)?;
        assert!(whole.is_solved());
        assert_eq!((whole.velocity, whole.work, whole.error), (parts.velocity, parts.work, parts.error));
    }
    Ok(())
}

/// A contact at 0.01 m/s slips, and sticks for those to whom 1 m/s is still: for each solver.
#[test]
fn what_is_still_is_the_same_to_all_solvers() -> Result<(), Error> {
    let mut scene = block::Scene::<f64>::new();
    scene.set_mass(&(Matrix2::identity() * 2.0))?;
    scene.push(&planar_floor(0.5, 0))?;
    let (factor, resolvent, push) = (Factor::new(&scene)?, AdmmFactor::new(&scene)?, vector![0.12, -0.2]);
    for (still, mode) in [(0.0, ContactMode::Slip), (1.0, ContactMode::Stick)] {
        let settings = Settings { still, ..Settings::new(1e-9) };
        let (mut newton, mut admm) = (block::Solver::new(), AdmmSolver::new());
        let newton = newton.solve(&scene, &factor, &push, &settings)?;
        let admm = admm.solve(&scene, &resolvent, &push, &settings)?;
        for solution in [newton, admm] {
            assert_eq!(solution.contacts[0].mode, mode);
            assert!((solution.velocity[0] - 0.01).abs() < 1e-8);
        }
    }
    Ok(())
}

#[test]
fn a_kernel_goes_on_where_its_budget_ended() -> Result<(), Error> {
    let mut kernel = EMPTY.clone();
    fill(kernel.scene_mut(), 0.3)?;
    let push = BRICK.free_impulse(0.5, 0.01);
    let one = Settings { budget: 1, ..Settings::new(1e-9) };
    assert_eq!(kernel.solve(&push, &one)?.status, Status::OutOfBudget);
    assert!(kernel.resume(&push, &Settings::new(1e-9))?.is_solved());
    Ok(())
}

#[test]
fn a_kernel_refuses_what_its_parts_refuse() {
    let mut kernel = EMPTY.clone();
    let refused = kernel.solve(&vector![0.0, 0.0, 0.0, 0.0, 0.0, 0.0], &Settings::default());
    assert_eq!(refused.err(), Some(Error::MassNotPositiveDefinite { dof: 5 }));
}

/// The zeros of a kernel that has solved nothing are no exact solution, once it was called.
#[test]
fn the_error_of_nothing_is_infinite() {
    let (push, settings) = (vector![0.0, 0.0, 0.0, 0.0, 0.0, 0.0], Settings::default());
    let mut kernel = EMPTY.clone();
    assert!(kernel.solve(&push, &settings).is_err());
    assert_eq!(kernel.solution().status, Status::Unsolved);
    assert!(kernel.solution().error > f64::MAX);
    let mut solver = Solver::new();
    let (scene, factor) = (EMPTY.scene(), Factor::empty());
    let broken = Settings::new(-1.0);
    assert!(solver.solve(scene, &factor, &push, &broken).is_err());
    assert!(solver.solution().error > f64::MAX);
}

/// Whatever a kernel has solved or refused, a reset makes it a new one.
#[test]
fn a_kernel_that_is_reset_is_a_new_one() -> Result<(), Error> {
    let (push, settings) = (BRICK.free_impulse(0.5, 0.01), Settings::new(1e-9));
    let bits = |kernel: &mut Kernel<f64, 6, 3, 4>| -> Result<String, Error> {
        fill(kernel.scene_mut(), 0.3)?;
        Ok(format!("{:?}", kernel.solve(&push, &settings)?))
    };
    let new = bits(&mut EMPTY.clone())?;
    let spoil: [fn(&mut Kernel<f64, 6, 3, 4>); 4] = [
        |_| {},
        |kernel| {
            assert!(kernel.scene_mut().set_mass(&(Matrix6::identity() * f64::NAN)).is_err());
        },
        |kernel| {
            let one = kernel.scene().contacts()[0].clone();
            assert!(kernel.scene_mut().push(&one).is_err()); // it is full
        },
        |kernel| {
            kernel.solver_mut().presume_rest();
            let one = Settings { budget: 1, ..Settings::new(1e-9) };
            assert!(kernel.solve(&BRICK.free_impulse(0.1, 0.01), &one).is_ok());
        },
    ];
    for spoil in spoil {
        let mut kernel = EMPTY.clone();
        assert_eq!(bits(&mut kernel)?, new);
        spoil(&mut kernel);
        kernel.reset();
        assert_eq!(kernel.scene().mass(), EMPTY.scene().mass());
        assert!(kernel.scene().contacts().is_empty());
        let solution = kernel.solution();
        assert_eq!(solution.status, Status::Unsolved);
        assert!(solution.contacts.is_empty() && solution.error > f64::MAX);
        let refused = kernel.resume(&push, &settings);
        assert_eq!(refused.err(), Some(Error::MassNotPositiveDefinite { dof: 5 }));
        assert_eq!(bits(&mut kernel)?, new);
    }
    Ok(())
}

/// Three points of one body stand; the one whose friction is lost between two ticks is the worst, and named.
#[test]
fn the_contact_that_is_farthest_off_is_named() -> Result<(), Error> {
    let (push, settings) = (BRICK.free_impulse(0.2, 0.01), Settings::new(1e-9));
    for slippery in 0..4 {
        let mut kernel = EMPTY.clone();
        fill(kernel.scene_mut(), 0.5)?;
        assert!(kernel.solve(&push, &settings)?.is_solved());
        let before = kernel.worst_contact();
        let residual = kernel.solution().error;
        assert!(before.is_none() || residual > 0.0);
        kernel.scene_mut().set_friction(slippery, 0.0)?;
        assert_eq!(kernel.worst_contact(), Some(slippery));
    }
    assert_eq!(EMPTY.worst_contact(), None);
    Ok(())
}

/// Scenes are independent of each other, and may be solved on as many threads as there are.
#[test]
fn everything_may_go_to_another_thread() {
    fn may<T: Send + Sync + Clone>() {}
    may::<Scene<f64, 6, 3, 4>>();
    may::<Factor<f64, 6, 3, 4>>();
    may::<AdmmFactor<f64, 6, 3, 4>>();
    may::<Solver<f64, 6, 3, 4>>();
    may::<AdmmSolver<f64, 6, 3, 4>>();
    may::<Kernel<f64, 6, 3, 4>>();
    may::<Solution<f64, 6, 3, 4>>();
}

#[test]
fn a_solution_names_its_contacts_by_their_keys() -> Result<(), Error> {
    let (mut kernel, source) = (EMPTY.clone(), BRICK.on_plane::<f64>(0.3)?);
    kernel.scene_mut().set_mass(source.mass())?;
    for (contact, key) in source.contacts().iter().zip([40, 10, 30, 20]) {
        kernel.scene_mut().push(&Contact { key, ..contact.clone() })?;
    }
    let solution = kernel.solve(&BRICK.free_impulse(0.5, 0.01), &Settings::default())?;
    let keys: Vec<u32> = solution.contacts.iter().map(|found| found.key).collect();
    assert_eq!(keys, [40, 10, 30, 20]);
    Ok(())
}

#[test]
fn a_solution_is_usable_by_its_status_and_its_error() -> Result<(), Error> {
    let mut kernel = EMPTY.clone();
    assert!(!kernel.solution().is_usable(f64::INFINITY));
    fill(kernel.scene_mut(), 0.3)?;
    let push = BRICK.free_impulse(0.5, 0.01);
    let none = Settings { budget: 0, ..Settings::new(1e-9) };
    let solution = kernel.solve(&push, &none)?;
    assert_eq!(solution.status, Status::OutOfBudget);
    assert!(solution.is_usable(solution.error) && !solution.is_usable(solution.error * 0.5));
    assert!(kernel.solve(&push, &Settings::new(1e-9))?.is_usable(0.0));

    let mut walls = Kernel::<f64, 2, 2, 2>::new();
    walls.scene_mut().set_mass(&Matrix2::identity())?;
    for normal in [1.0, -1.0] {
        walls.scene_mut().push(&Contact {
            jacobian: matrix![normal, 0.0; 0.0, normal],
            offset: vector![-1.0, 0.0],
            mu: 0.5,
            key: 0,
        })?;
    }
    let solution = walls.solve(&vector![0.0, 0.0], &Settings::default())?;
    assert_eq!(solution.status, Status::Infeasible);
    assert!(!solution.is_usable(f64::INFINITY));
    Ok(())
}
