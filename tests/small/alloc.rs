//! Nothing allocates: not the set-up, not a solve by any method, not a projection.

use crate::support::boxes::{BRICK, BoxScene};
use crate::support::sizes::joints;
use allocation_counter::measure;
use nalgebra::{SMatrix, SVector, vector};
use stiction::{
    Acceleration, AdmmFactor, AdmmSolver, Contact, Error, Factor, FrictionCone, JointRow, Model, RowLaw,
    Scene, Settings, SlipUpdate, Solution, Solver, Status,
};

/// Allocations of a call.
fn allocations(call: impl FnOnce()) -> u64 {
    measure(call).count_total
}

fn sliding_box() -> Result<(BoxScene<f64>, SVector<f64, 6>), Error> {
    Ok((BRICK.on_plane(0.3)?, BRICK.free_impulse(0.5, 0.01)))
}

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| drop(std::hint::black_box(Box::new(1)))), 1);
}

#[test]
fn building_a_scene_does_not_allocate() -> Result<(), Error> {
    let (source, _) = sliding_box()?;
    let mut scene = Scene::<f64, 6, 3, 4>::new();
    let mut result = Ok(());
    let count = allocations(|| {
        result = scene.set_mass(source.mass());
        for contact in source.contacts() {
            result = result.and(scene.push(contact).map(|_| ()));
        }
        result = result.and(scene.set_friction(0, 0.2)).and(scene.set_offset(0, &SVector::zeros()));
    });
    assert_eq!((count, result), (0, Ok(())));
    Ok(())
}

#[test]
fn factorising_does_not_allocate() -> Result<(), Error> {
    let (scene, _) = sliding_box()?;
    let mut factor = AdmmFactor::empty();
    let mut result = Ok(());
    let count = allocations(|| {
        result = factor.prepare(&scene).and(factor.set_penalty(3.0));
    });
    assert_eq!((count, result), (0, Ok(())));
    let mut factor = Factor::empty();
    let count = allocations(|| result = factor.prepare(&scene));
    assert_eq!((count, result), (0, Ok(())));
    Ok(())
}

#[test]
fn newton_does_not_allocate_cold_or_warm() -> Result<(), Error> {
    let (source, push) = sliding_box()?;
    let settings = Settings::new(1e-9);
    let mut solver = Solver::new();
    // Contacts are known, go, come and change places.
    let steps = [[0, 1, 2, 3], [0, 1, 2, 3], [3, 4, 5, 0]].into_iter();
    for (keys, push) in steps.zip([push, push * 1.01, push * -1.0]) {
        let mut scene = source.clone();
        scene.clear_contacts();
        for (contact, key) in source.contacts().iter().zip(keys) {
            scene.push(&Contact { key, ..contact.clone() })?;
        }
        let factor = Factor::new(&scene)?;
        let mut status = Err(Error::InvalidPenalty);
        let count = allocations(|| {
            let solution = solver.solve(&scene, &factor, &push, &settings);
            status = solution.map(|solution| solution.status);
        });
        assert_eq!((count, status), (0, Ok(Status::Solved)));
    }
    Ok(())
}

#[test]
fn no_first_order_method_allocates() -> Result<(), Error> {
    let (scene, push) = sliding_box()?;
    let factor = AdmmFactor::new(&scene)?;
    for (slip_update, model) in [
        (SlipUpdate::EveryIteration, Model::Coulomb),
        (SlipUpdate::OuterLoop, Model::Coulomb),
        (SlipUpdate::EveryIteration, Model::ConvexRelaxation),
    ] {
        let settings = Settings { model, ..Settings::new(1e-3) };
        for acceleration in [Acceleration::Plain, Acceleration::Nesterov, Acceleration::Restart] {
            let mut solver = AdmmSolver::with(acceleration, slip_update);
            let mut solved = false;
            let count = allocations(|| {
                let solution = solver.solve(&scene, &factor, &push, &settings);
                solved = solution.is_ok_and(Solution::is_solved);
            });
            assert_eq!((count, solved), (0, true), "{acceleration:?}, {slip_update:?}, {model:?}");
        }
    }
    Ok(())
}

#[test]
fn an_unsolved_scene_does_not_allocate() -> Result<(), Error> {
    let (scene, push) = sliding_box()?;
    let factor = AdmmFactor::new(&scene)?;
    let settings = Settings { budget: 3, ..Settings::new(1e-12) };
    let (mut newton, mut admm) = (Solver::new(), AdmmSolver::new());
    let mut statuses = [None; 2];
    let count = allocations(|| {
        let newton = newton.solve(&scene, factor.factor(), &push, &settings);
        let admm = admm.solve(&scene, &factor, &push, &settings);
        statuses = [newton, admm].map(|result| result.ok().map(|solution| solution.status));
    });
    assert_eq!((count, statuses), (0, [Some(Status::OutOfBudget); 2]));
    Ok(())
}

#[test]
fn projecting_does_not_allocate() {
    let mut sum = SVector::<f64, 3>::zeros();
    let count = allocations(|| {
        for cone in FrictionCone::new(0.5).into_iter().flat_map(|cone| [cone, cone.dual()]) {
            let x = vector![0.1, 2.0, -1.0];
            sum += cone.project(&x);
        }
    });
    assert_eq!(count, 0);
    assert!(sum.norm() > 0.0);
}

#[test]
fn nothing_beside_contacts_allocates() {
    let mut kernel = joints::Kernel::<f64>::new();
    let row = |key: u32, entry: f64, offset: f64, law| JointRow {
        row: vector![entry, 0.3],
        offset,
        law,
        compliance: 0.0,
        key,
    };
    let limits = [row(1, 1.0, 0.1, RowLaw::Limit), row(2, -1.0, 9.0, RowLaw::Limit)];
    let walls = [row(0, 1.0, -1.0, RowLaw::Equality), row(0, 1.0, 1.0, RowLaw::Equality)];
    let motor = row(0, 0.5, 0.2, RowLaw::Box { lower: -1.0, upper: 1.0 });
    let hurried = Settings { budget: 1, ..Settings::new(1e-12) };
    let mut found = Vec::with_capacity(8);
    let count = allocations(|| {
        let scene = kernel.scene_mut();
        let filled = scene.set_mass(&SMatrix::identity());
        found.push(filled.and(scene.push_row(&motor).map(|_| Status::Unsolved)));
        let push = vector![-3.0, 0.2];
        for settings in [Settings::new(1e-9), hurried] {
            let solution = kernel.solve_with_limits(&limits, &push, &settings);
            found.push(solution.map(|solution| solution.status));
        }
        let advanced = kernel.advance(&push, &Settings::new(1e-9));
        assert_eq!(advanced, Ok(true), "a budget is left");
        let solution = kernel.resume(&push, &Settings::new(1e-9));
        found.push(solution.map(|solution| solution.status));
        for wall in &walls {
            let _ = kernel.scene_mut().push_row(wall);
        }
        let solution = kernel.solve(&push, &Settings::new(1e-9));
        found.push(solution.map(|solution| solution.status));
        let refused = kernel.solve(&vector![f64::NAN, 0.0], &Settings::new(1e-9));
        found.push(refused.map(|solution| solution.status));
    });
    assert_eq!(count, 0);
    let statuses: Vec<_> = found.iter().map(|found| found.ok()).collect();
    assert_eq!(statuses[1], Some(Status::Solved));
    assert_eq!(statuses[4..], [Some(Status::Infeasible), None]);
}
