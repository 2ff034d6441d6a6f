//! Newton steps: accepted, shortened, rejected, and with the Jacobian of an earlier step.
#![allow(clippy::indexing_slicing)]

use crate::Error;
use crate::solver::AllPhases;
use crate::solver::fixtures::{C, D, N, cube, pressed, with_solve, with_solve_from};
use crate::solver::newton::{Chord, Outcome};
use crate::solver::record::Call;
use crate::solver::state::{Newton, State};
use crate::solver::warm_start::WarmStart;
use nalgebra::vector;

type Solve<'s, 'a> = crate::solver::solve::Solve<'s, 'a, f64, N, D, C, 0, 0, AllPhases>;

/// Moves to the guess that all contacts stick.
fn go_to_guess(solve: &mut Solve<'_, '_>) {
    solve.begin_guess(Newton::guessed());
}

/// Makes a step and the checks that are due after it.
fn step(solve: &mut Solve<'_, '_>, newton: Newton) -> Outcome {
    let outcome = solve.step(newton);
    while solve.monitor.must_return() && !solve.monitor.is_over() {
        solve.check();
    }
    outcome
}

#[test]
fn one_step_all_but_solves_what_sticks() -> Result<(), Error> {
    with_solve(&cube(4, 0.5)?, &pressed(0.2), |solve| {
        go_to_guess(solve);
        let outcome = step(solve, Newton::guessed());
        let Outcome::Accepted(newton) = outcome else { unreachable!("a linear problem") };
        assert!(solve.state.point.estimate < 1e-3); // the rest of the error comes from damping
        step(solve, newton);
        assert!(solve.monitor.is_over());
    })
}

/// A step that solves the scene is accepted, even if it is the last one.
#[test]
fn the_last_step_may_solve() -> Result<(), Error> {
    with_solve(&cube(4, 0.5)?, &pressed(0.2), |solve| {
        go_to_guess(solve);
        step(solve, Newton::guessed());
        let outcome = step(solve, Newton::with_one_step());
        assert!(solve.monitor.is_over() && matches!(outcome, Outcome::Accepted(_)));
    })
}

/// No step raises the merit, except from a guess.
#[test]
fn every_accepted_step_lowers_the_merit() -> Result<(), Error> {
    for sideways in [0.1, 0.45, 0.6, 2.0] {
        with_solve(&cube(4, 0.5)?, &pressed(sideways), |solve| {
            go_to_guess(solve);
            solve.set_zero_impulse();
            solve.rebuild();
            let mut newton = Newton::new();
            while !solve.monitor.is_over() {
                let before = solve.state.point.merit;
                match step(solve, newton) {
                    Outcome::Accepted(next) => newton = next,
                    _ => break,
                }
                assert!(solve.state.point.merit < before, "{sideways}");
            }
        })?;
    }
    Ok(())
}

/// Between closing walls a step is rejected at last. The point stays where it was.
#[test]
fn a_rejected_step_changes_nothing() -> Result<(), Error> {
    let mut scene = cube(2, 0.5)?;
    scene.set_jacobian(1, &-scene.contacts()[0].jacobian)?;
    for contact in 0..2 {
        scene.set_offset(contact, &vector![-0.1, 0.3, 0.0])?;
    }
    with_solve(&scene, &pressed(0.2), |solve| {
        go_to_guess(solve);
        for _ in 0..100 {
            let before = (solve.state.point.z, solve.state.point.r, solve.state.point.merit);
            if let Outcome::Rejected = step(solve, Newton::new()) {
                assert_eq!(before, (solve.state.point.z, solve.state.point.r, solve.state.point.merit));
                return;
            }
        }
        unreachable!("the scene has no solution");
    })
}

/// If the active set is that of the last solve, its Jacobian serves again, for a fifth of the work.
#[test]
fn a_kept_jacobian_saves_a_new_one() -> Result<(), Error> {
    let (mut state, mut last) = (State::none(), WarmStart::cold());
    let scene = cube(1, 5.0)?; // sticks
    for (sideways, expected) in [(0.10, 1), (0.11, 0)] {
        with_solve_from((&mut state, &mut last), Call::Begin, (&scene, &pressed(sideways)), |solve| {
            go_to_guess(solve);
            let newton = Newton::warm(false);
            while !solve.monitor.is_over() {
                step(solve, newton);
            }
            assert_eq!(solve.monitor.solution.work.newton_steps, expected, "{sideways}");
        })?;
    }
    assert!(state.holds_jacobian);
    Ok(())
}

/// The central path uses the matrix of the Jacobian, so the Jacobian is lost.
#[test]
fn a_jacobian_is_kept_until_the_central_path_uses_its_matrix() -> Result<(), Error> {
    with_solve(&cube(4, 0.5)?, &pressed(0.6), |solve| {
        go_to_guess(solve);
        assert!(!solve.state.holds_jacobian);
        let mut newton = Newton::guessed();
        solve.step_anew(&mut newton);
        assert!(solve.state.holds_jacobian);
        solve.begin_path();
        assert!(solve.state.holds_jacobian);
        assert!(solve.path_step().is_ok());
        assert!(!solve.state.holds_jacobian && !solve.monitor.is_over());
        go_to_guess(solve);
        solve.step_anew(&mut newton);
        assert!(solve.state.holds_jacobian);
        solve.state.forget();
        assert!(!solve.state.holds_jacobian && matches!(solve.chord_steps(&mut true), Chord::Unavailable));
    })
}
