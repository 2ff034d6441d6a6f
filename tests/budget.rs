//! A budget ends a call, not a solve: split over any number of calls it gives the same bits.

use crate::support::boxes::BRICK;
use stiction::{AdmmFactor, AdmmSolver, Error, Settings, Status, Work};
use testbed::kernel::{self, Answer, Kernel, Shape, smallest};
use testbed::measure::{self, Law};
use testbed::method::Method;
use testbed::scene_file::{SceneFile, bundled_scenes};

/// All bits of a solution, and what it has cost but for the search for a proof, which the end of a call may bring forward.
fn bits(answer: &Answer) -> (Vec<u64>, Status, Work) {
    let numbers = answer.v.iter().chain(&answer.r).chain([&answer.error]);
    (numbers.map(|x| x.to_bits()).collect(), answer.status, Work { proof_searches: 0, ..answer.work })
}

/// The kernel with a scene and its factor.
fn prepared(file: &SceneFile) -> Box<dyn Kernel> {
    kernel::prepared(smallest::<f64>, file, Method::Default).unwrap()
}

/// The scene with a free impulse so many times as large.
fn pushed(file: &SceneFile, share: f64) -> SceneFile {
    let mut pushed = file.clone();
    pushed.f *= share;
    pushed
}

/// Solves a scene cold and, a little changed, warm, in calls of `budget` each; the answers, the
/// calls, and the most that one of them has cost.
fn solve(file: &SceneFile, budget: usize) -> ([Answer; 2], usize, usize) {
    let mut kernel = prepared(file);
    let settings = Settings { budget, ..Settings::new(1e-9) };
    let (mut calls, mut dearest) = (0, 0);
    let answers = [1.0, 0.99].map(|share| {
        kernel.load(&pushed(file, share)).unwrap();
        let (mut spent, mut error) = (0, f64::INFINITY);
        kernel.solve(Method::Default, &settings).unwrap();
        loop {
            let answer = kernel.answer();
            dearest = dearest.max(answer.work.total() - spent);
            (spent, calls) = (answer.work.total(), calls + 1);
            // What a call has found is not lost by the next.
            assert!(answer.error <= error * 1.01 + 1e-12, "{}", file.name);
            error = answer.error;
            if answer.status != Status::OutOfBudget {
                break;
            }
            kernel.resume(&settings).unwrap();
        }
        kernel.answer()
    });
    (answers, calls, dearest)
}

#[test]
fn a_split_solve_gives_the_same_bits() {
    let mut sooner = 0;
    for file in bundled_scenes() {
        let (whole, calls, _) = solve(&file, 100_000);
        assert_eq!(calls, 2, "{}", file.name); // one cold, one warm
        for budget in [1, 7, 40] {
            let (split, _, dearest) = solve(&file, budget);
            if whole[0].status == Status::Infeasible {
                // The end of a call is a time to doubt: it may be known sooner.
                assert!(split.iter().all(|answer| answer.status == Status::Infeasible));
            } else {
                for (split, whole) in split.iter().zip(&whole) {
                    // The question whether a body can stay at rest ends with a call, with a solution. And the end of a call computes
                    // the error of the best impulses, whatever their estimate. The next solve then starts elsewhere.
                    if split.work.total() < whole.work.total() && split.status == Status::Solved {
                        sooner += 1;
                        break;
                    }
                    let (split, whole) = (bits(split), bits(whole));
                    assert_eq!(split, whole, "{} in calls of {budget}", file.name);
                }
            }
            // A call ends with the piece of work in which its budget ends, and the one search for a proof.
            assert!(dearest < budget + 20, "{}: {dearest}", file.name);
        }
    }
    assert!(sooner <= 13, "{sooner} of some 120 pairs"); // the others have equal bits
}

/// What a wild tick leaves behind is forgotten with the rest.
#[test]
fn a_solver_that_was_reset_gives_the_bits_of_a_new_one() {
    let settings = Settings { budget: 1_000, ..Settings::new(1e-5) };
    for file in bundled_scenes() {
        let solve = |wild: &[f64]| {
            let mut kernel = smallest::<f32>(Shape::of(&file)).expect("a size is compiled");
            for &scale in wild {
                kernel.load(&pushed(&file, scale)).unwrap();
                kernel.prepare(Method::Default).unwrap();
                kernel.solve(Method::Default, &settings).unwrap();
            }
            kernel.reset();
            kernel.load(&file).unwrap();
            kernel.prepare(Method::Default).unwrap();
            kernel.solve(Method::Default, &settings).unwrap();
            bits(&kernel.answer())
        };
        assert_eq!(solve(&[1e17, 1e25, 1e30]), solve(&[]), "{}", file.name);
    }
}

#[test]
fn there_is_nothing_to_resume() {
    let file = bundled_scenes().remove(0);
    let settings = Settings::new(1e-9);
    let cold = {
        let mut kernel = prepared(&file);
        kernel.solve(Method::Default, &settings).unwrap();
        kernel.answer()
    };

    let mut kernel = prepared(&file);
    kernel.resume(&settings).unwrap();
    assert_eq!(bits(&kernel.answer()), bits(&cold));
    kernel.load(&pushed(&file, f64::NAN)).unwrap();
    assert!(kernel.resume(&settings).is_err());
    kernel.reset();
    kernel.load(&file).unwrap();
    kernel.resume(&settings).unwrap();
    assert_eq!(bits(&kernel.answer()), bits(&cold));

    // What has ended is not gone on with: this is another solve, of other data.
    let other = pushed(&file, 0.9);
    kernel.load(&other).unwrap();
    kernel.resume(&settings).unwrap();
    let answer = kernel.answer();
    assert!(measure::error(&other, &answer.v, &answer.r, Law::Coulomb) <= 1e-9);
    kernel.load(&file).unwrap();

    // A solve that is refused leaves the one that was paused.
    let pause = Settings { budget: 3, ..settings };
    kernel.reset();
    kernel.solve(Method::Default, &pause).unwrap();
    assert_eq!(kernel.answer().status, Status::OutOfBudget);
    kernel.load(&pushed(&file, f64::NAN)).unwrap();
    assert!(kernel.solve(Method::Default, &settings).is_err());
    assert!(kernel.resume(&settings).is_err());
    kernel.load(&file).unwrap();
    kernel.prepare(Method::Default).unwrap();
    kernel.resume(&settings).unwrap();
    assert_eq!(bits(&kernel.answer()), bits(&cold));
}

/// ADMM alone goes on where it was, too.
#[test]
fn a_split_solve_by_admm_gives_the_same_bits() -> Result<(), Error> {
    let scene = BRICK.on_plane::<f64>(0.3)?;
    let factor = AdmmFactor::new(&scene)?;
    let (mut whole, mut split) = (AdmmSolver::new(), AdmmSolver::new());
    for slope in [0.5, 0.2] {
        let push = BRICK.free_impulse(slope, 0.01);
        let settings = Settings::new(1e-8);
        let whole = whole.solve(&scene, &factor, &push, &settings)?;
        let few = Settings { budget: 7, ..settings };
        split.solve(&scene, &factor, &push, &few)?;
        let mut calls = 1;
        while split.solution().status == Status::OutOfBudget {
            split.resume(&scene, &factor, &push, &few)?;
            calls += 1;
        }
        let split = split.solution();
        assert!(whole.is_solved() && calls > 2, "{calls} calls");
        assert_eq!((split.velocity, split.work, split.error), (whole.velocity, whole.work, whole.error));
    }
    Ok(())
}
