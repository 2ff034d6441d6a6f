//! A budget ends a call, not a solve: split over any number of calls it gives the same bits.

mod support;

use stiction::{Factor, Settings, Solution, Solver, Status};
use support::scene_file::{self, SceneFile};

type Answer = (Vec<u64>, Status, [usize; 3], u64);

/// All bits of a solution, and what it has cost.
fn answer<const N: usize, const D: usize, const C: usize>(
    solution: &Solution<f64, N, D, C>,
) -> Answer {
    let impulses = solution
        .contacts
        .iter()
        .flat_map(|contact| &contact.impulse);
    let values = solution.velocity.iter().chain(impulses);
    let cost = [
        solution.iterations,
        solution.newton_steps,
        solution.factorizations,
    ];
    let bits = values.map(|x| x.to_bits()).collect();
    (bits, solution.status, cost, solution.error.to_bits())
}

/// Solves a scene cold and, a little changed, warm, in calls of `budget` each; the answers, the
/// calls, and the most that one of them has cost.
fn solve<const N: usize, const D: usize, const C: usize>(
    file: &SceneFile,
    budget: usize,
) -> ([Answer; 2], usize, usize) {
    let scene = file.scene::<f64, N, D, C>().unwrap();
    let factor = Factor::new(&scene).unwrap();
    let mut solver = Solver::new();
    let settings = Settings {
        max_iterations: budget,
        ..Settings::new(1e-9)
    };
    let (mut calls, mut dearest) = (0, 0);
    let answers = [1.0, 0.99].map(|share| {
        let f = file.free_impulse::<f64, N>() * share;
        let (mut spent, mut error) = (0, f64::INFINITY);
        solver.solve(&scene, &factor, &f, &settings).unwrap();
        loop {
            let solution = solver.solution();
            let work = solution.iterations + 10 * solution.newton_steps;
            dearest = dearest.max(work - spent);
            (spent, calls) = (work, calls + 1);
            // What a call has found is not lost by the next.
            assert!(solution.error <= error * 1.01 + 1e-12, "{}", file.name);
            error = solution.error;
            if solution.status != Status::MaxIterations {
                break;
            }
            solver.resume(&scene, &factor, &f, &settings).unwrap();
        }
        let ended = answer(solver.solution());
        // There is nothing to go on with.
        assert_eq!(
            ended,
            answer(solver.resume(&scene, &factor, &f, &settings).unwrap())
        );
        ended
    });
    (answers, calls, dearest)
}

/// The whole solve in one call, and in many.
fn compare<const N: usize, const D: usize, const C: usize>(file: &SceneFile) {
    let (whole, calls, _) = solve::<N, D, C>(file, 100_000);
    assert_eq!(calls, 2, "{}", file.name); // one cold, one warm
    for budget in [1, 7, 40] {
        let (split, _, dearest) = solve::<N, D, C>(file, budget);
        if whole[0].1 == Status::Infeasible {
            // The end of a call is a time to doubt: it may be known sooner.
            assert!(split.iter().all(|answer| answer.1 == Status::Infeasible));
        } else {
            assert_eq!(split, whole, "{} in calls of {budget}", file.name);
        }
        // A call ends with the piece of work in which its budget ends.
        assert!(dearest < budget + 40, "{}: {dearest}", file.name);
    }
}

#[test]
fn a_split_solve_gives_the_same_bits() {
    for path in scene_file::bundled() {
        for file in scene_file::read(&path).unwrap() {
            match file.dim {
                2 => compare::<6, 2, 4>(&file),
                _ => compare::<24, 3, 12>(&file),
            }
        }
    }
}

/// What a wild tick leaves behind is forgotten with the rest.
#[test]
fn a_solver_that_was_reset_gives_the_bits_of_a_new_one() {
    for path in scene_file::bundled() {
        for file in scene_file::read(&path).unwrap() {
            if file.dim != 3 || file.n_contacts > 4 || file.n_dof > 18 {
                continue;
            }
            let scene = file.scene::<f32, 18, 3, 4>().unwrap();
            let factor = Factor::new(&scene).unwrap();
            let f = file.free_impulse::<f32, 18>();
            let settings = Settings {
                max_iterations: 1_000,
                ..Settings::new(1e-5)
            };
            let bits = |solution: &Solution<f32, 18, 3, 4>| solution.velocity.map(f32::to_bits);
            let mut used = Solver::new();
            for scale in [1e17_f32, 1e25, 1e30] {
                used.solve(&scene, &factor, &(f * scale), &settings)
                    .unwrap();
            }
            used.reset();
            let used = bits(used.solve(&scene, &factor, &f, &settings).unwrap());
            let mut new = Solver::new();
            let new = bits(new.solve(&scene, &factor, &f, &settings).unwrap());
            assert_eq!(used, new, "{}", file.name);
        }
    }
}

#[test]
fn there_is_nothing_to_resume() {
    let path = scene_file::bundled().into_iter().next().unwrap();
    let file = scene_file::read(&path).unwrap().remove(0);
    let scene = file.scene::<f64, 24, 3, 12>().unwrap();
    let factor = Factor::new(&scene).unwrap();
    let f = file.free_impulse::<f64, 24>();
    let settings = Settings::new(1e-9);
    let cold = answer(Solver::new().solve(&scene, &factor, &f, &settings).unwrap());

    let mut solver = Solver::new();
    assert_eq!(
        answer(solver.resume(&scene, &factor, &f, &settings).unwrap()),
        cold
    );
    assert!(
        solver
            .resume(&scene, &factor, &(f * f64::NAN), &settings)
            .is_err()
    );
    solver.reset();
    assert_eq!(
        answer(solver.resume(&scene, &factor, &f, &settings).unwrap()),
        cold
    );

    // A solve that was refused is no solve to go on with.
    let pause = Settings {
        max_iterations: 3,
        ..settings
    };
    solver.reset();
    solver.solve(&scene, &factor, &(f * 0.5), &pause).unwrap();
    assert!(
        solver
            .solve(&scene, &factor, &(f * f64::NAN), &pause)
            .is_err()
    );
    let warm = solver.resume(&scene, &factor, &f, &settings).unwrap();
    assert_eq!(warm.status, Status::Solved);
}
