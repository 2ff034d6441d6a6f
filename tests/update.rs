//! A factor for one solve: `Factor::update` leaves the resolvent to the solve that needs it.

use crate::support::check;
use nalgebra::{SMatrix, SVector, matrix, vector};
use stiction::{AdmmSolver, Contact, Error, Factor, Scene, Settings, Solver, Status};
use testbed::kernel::{Answer, Constructor, Shape};
use testbed::method::Method;
use testbed::scene_file::{self, SceneFile};

/// Replays a sequence, warm and each step cold, with both kinds of factor; the resolvents that solves
/// have computed for a factor without.
fn replay(kernel: Constructor, steps: &[SceneFile], tolerance: f64) -> Result<usize, Error> {
    let shape = Shape::of_all(steps).expect("a step");
    let settings = Settings::new(tolerance);
    let mut resolvents = 0;
    for warm in [true, false] {
        let mut kernels = [kernel(shape), kernel(shape)].map(|kernel| kernel.expect("a size"));
        for step in steps {
            let mut answers = Vec::new();
            for (kernel, for_many) in kernels.iter_mut().zip([true, false]) {
                if !warm {
                    kernel.reset();
                }
                kernel.load(step)?;
                kernel.prepare(for_many)?;
                kernel.solve(Method::Default, &settings)?;
                answers.push(kernel.answer());
            }
            let [complete, updated] = &answers[..] else {
                unreachable!("two kernels")
            };
            assert_eq!(complete.status, Status::Solved, "{}", step.name);
            resolvents += updated.work.resolvents - complete.work.resolvents;
            let updated = Answer {
                work: complete.work,
                ..updated.clone()
            };
            assert_eq!(*complete, updated, "{}", step.name);
        }
    }
    Ok(resolvents)
}

#[test]
fn a_solve_with_an_updated_factor_is_that_with_a_complete_one() -> Result<(), Error> {
    let mut resolvents = 0;
    for file in scene_file::bundled_sequences() {
        let steps = scene_file::read(&file).expect("a sequence file");
        resolvents += replay(kernels_f64::kernel, &steps, 1e-6)?;
        resolvents += replay(kernels_f32::kernel, &steps, 1e-4)?;
    }
    assert_eq!(resolvents, 0, "a solve by the default method needs none");
    Ok(())
}

/// A box on four corners: more rows than dofs, so that a cold solve starts with ADMM.
fn cube() -> Result<(Scene<f64, 6, 3, 4>, SVector<f64, 6>), Error> {
    let mut scene = Scene::new();
    scene.set_mass(&SMatrix::from_diagonal(&vector![
        2.0, 2.0, 2.0, 0.1, 0.1, 0.1
    ]))?;
    for (key, (x, y)) in (0..).zip([(0.2, 0.2), (0.2, -0.2), (-0.2, 0.2), (-0.2, -0.2)]) {
        scene.push(&Contact {
            jacobian: matrix![
                0.0, 0.0, 1.0, y, -x, 0.0;
                1.0, 0.0, 0.0, 0.0, -0.2, -y;
                0.0, 1.0, 0.0, 0.2, 0.0, x],
            offset: SVector::zeros(),
            mu: 0.5,
            key,
        })?;
    }
    Ok((scene, vector![0.1, -0.05, 0.2, 0.0, 0.01, 0.02]))
}

#[test]
fn admm_alone_asks_for_the_resolvent() -> Result<(), Error> {
    let (scene, f) = cube()?;
    let (complete, settings) = (Factor::new(&scene)?, Settings::default());
    let mut updated = Factor::empty();
    updated.update(&scene)?;
    assert!(updated.parts().is_none());
    let mut solver = AdmmSolver::new();
    for _ in 0..2 {
        let refused = solver.solve_restart(&scene, &updated, &f, &settings);
        assert_eq!(refused.err(), Some(Error::NoResolvent));
        assert_eq!(updated.set_penalty(-1.0), Err(Error::InvalidPenalty));
    }
    updated.set_penalty(updated.penalty())?;
    assert_eq!(updated.parts(), complete.parts());
    let status = check::same_by_admm(&scene, [&complete, &updated], &f, &settings)?;
    assert_eq!(status, Status::Solved);
    let solution = solver.solve_restart(&scene, &updated, &f, &settings)?;
    assert_eq!(solution.status, Status::Solved);
    Ok(())
}

/// Each call of a solve may have a factor of its own, as long as the scene is the same.
#[test]
fn a_solve_goes_on_with_the_other_kind_of_factor() -> Result<(), Error> {
    let (scene, f) = cube()?;
    let complete = Factor::new(&scene)?;
    let mut updated = Factor::empty();
    updated.update(&scene)?;
    for (first, then) in [(&complete, &updated), (&updated, &complete)] {
        let mut solver = Solver::new();
        let two = Settings {
            budget: 2,
            ..Settings::new(1e-9)
        };
        let begun = solver.solve(&scene, first, &f, &two)?;
        assert_eq!(begun.status, Status::OutOfBudget);
        let done = solver.resume(&scene, then, &f, &Settings::new(1e-9))?;
        assert_eq!(done.status, Status::Solved);
    }
    Ok(())
}

/// A feather twice on the floor beside five blocks: too light for the penalty of all.
#[test]
fn masses_too_unlike_for_a_resolvent_are_solved_without() -> Result<(), Error> {
    let masses = SVector::<f32, 12>::from_fn(|dof, _| if dof < 2 { 1e-8 } else { 1.0 });
    let mut scene = Scene::<f32, 12, 2, 7>::new();
    scene.set_mass(&SMatrix::from_diagonal(&masses))?;
    for (key, body) in (0..).zip([0, 0, 1, 2, 3, 4, 5]) {
        let mut jacobian = SMatrix::<f32, 2, 12>::zeros();
        (jacobian[(0, 2 * body + 1)], jacobian[(1, 2 * body)]) = (1.0, 1.0);
        scene.push(&Contact {
            jacobian,
            offset: SVector::zeros(),
            mu: 0.5,
            key,
        })?;
    }
    assert_eq!(Factor::new(&scene).err(), Some(Error::InvalidPenalty));
    let mut factor = Factor::empty();
    factor.update(&scene)?;
    let mut solver = Solver::new();
    let solution = solver.solve(&scene, &factor, &masses, &Settings::new(1e-4))?;
    assert_eq!(solution.status, Status::Solved);
    Ok(())
}

/// Where `W` overflows, at one contact among others, nothing can be said of its error.
#[test]
fn an_infinite_delassus_operator_is_refused() -> Result<(), Error> {
    let mut scene = Scene::<f32, 2, 1, 2>::new();
    scene.set_mass(&SMatrix::from_diagonal(&vector![1.0, 1e-12]))?;
    for (key, jacobian) in (0..).zip([matrix![1.0, 0.0], matrix![0.0, 1e14]]) {
        scene.push(&Contact {
            jacobian,
            offset: vector![0.0],
            mu: 0.0,
            key,
        })?;
    }
    let mut factor = Factor::empty();
    assert_eq!(factor.update(&scene), Err(Error::InvalidPenalty));
    assert_eq!(factor.contacts(), 0);
    Ok(())
}

/// A factor that was of more contacts has nothing of them left.
#[test]
fn walls_are_proved_to_close_with_a_factor_that_was_another_scene_s() -> Result<(), Error> {
    let scene = |normals: &[[f64; 2]], offset| -> Result<_, Error> {
        let mut scene = Scene::<f64, 2, 2, 4>::new();
        scene.set_mass(&SMatrix::identity())?;
        for (key, &[x, y]) in (0..).zip(normals) {
            scene.push(&Contact {
                jacobian: matrix![x, y; y, -x],
                offset: vector![offset, 0.0],
                mu: 0.3,
                key,
            })?;
        }
        Ok(scene)
    };
    let mut factor = Factor::empty();
    factor.update(&scene(
        &[[1.0, 0.0], [1.0, 0.0], [-3.0, 0.0], [-3.0, 0.0]],
        0.0,
    )?)?;
    let walls = scene(&[[1.0, 0.0], [-1.0, 0.0]], -1.0)?;
    factor.update(&walls)?;
    let mut solver = Solver::new();
    let solution = solver.solve(&walls, &factor, &vector![0.1, 0.05], &Settings::default())?;
    assert_eq!(solution.status, Status::Infeasible);
    Ok(())
}

/// Who has nothing to do computes no resolvent either.
#[test]
fn a_scene_at_rest_needs_no_resolvent() -> Result<(), Error> {
    let (scene, _) = cube()?;
    let mut factor = Factor::empty();
    factor.update(&scene)?;
    let mut solver = Solver::new();
    let solution = solver.solve(&scene, &factor, &SVector::zeros(), &Settings::default())?;
    assert_eq!(
        (solution.status, solution.work.resolvents),
        (Status::Solved, 0)
    );
    Ok(())
}
