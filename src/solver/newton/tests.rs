//! Newton steps: accepted, shortened, rejected, and with the Jacobian of an earlier step.
#![allow(clippy::indexing_slicing)]

use crate::Error;
use crate::solver::AllPhases;
use crate::solver::fixtures::{C, D, N, cube, pressed, with_monitor};
use crate::solver::monitor::Monitor;
use crate::solver::newton::{Chord, Newton, Outcome};
use crate::solver::state::State;
use nalgebra::vector;

/// Moves to the guess that all contacts stick.
fn go_to_guess(state: &mut State<f64, D, C, 0>, monitor: &Monitor<'_, '_, f64, N, D, C, 0, 0>) {
    monitor.problem.all_sticking(&mut state.point.z);
    state.point.update(monitor.problem);
}

/// The state of a solve at the guess that all contacts stick.
fn guess(monitor: &Monitor<'_, '_, f64, N, D, C, 0, 0>) -> State<f64, D, C, 0> {
    let mut state = State::none();
    go_to_guess(&mut state, monitor);
    state
}

/// Makes a step and the checks that are due after it.
fn step(
    state: &mut State<f64, D, C, 0>,
    monitor: &mut Monitor<'_, '_, f64, N, D, C, 0, 0>,
    newton: Newton,
) -> Outcome {
    let outcome = state.step(monitor, newton);
    while monitor.must_return() && !monitor.is_over() {
        state.check::<AllPhases, _, _>(monitor);
    }
    outcome
}

#[test]
fn one_step_all_but_solves_what_sticks() -> Result<(), Error> {
    with_monitor(&cube(4, 0.5)?, &pressed(0.2), |monitor| {
        let mut state = guess(monitor);
        let outcome = step(&mut state, monitor, Newton::guessed());
        let Outcome::Accepted(newton) = outcome else { unreachable!("a linear problem") };
        assert!(state.point.estimate < 1e-3); // the rest of the error comes from damping
        step(&mut state, monitor, newton);
        assert!(monitor.is_over());
    })
}

/// A step that solves the scene is accepted, even if it is the last one.
#[test]
fn the_last_step_may_solve() -> Result<(), Error> {
    with_monitor(&cube(4, 0.5)?, &pressed(0.2), |monitor| {
        let mut state = guess(monitor);
        step(&mut state, monitor, Newton::guessed());
        let outcome = step(&mut state, monitor, Newton::with_one_step());
        assert!(monitor.is_over() && matches!(outcome, Outcome::Accepted(_)));
    })
}

/// No step raises the merit, except from a guess.
#[test]
fn every_accepted_step_lowers_the_merit() -> Result<(), Error> {
    for sideways in [0.1, 0.45, 0.6, 2.0] {
        with_monitor(&cube(4, 0.5)?, &pressed(sideways), |monitor| {
            let mut state = guess(monitor);
            state.point.set_zero_impulse(monitor.problem);
            state.point.rebuild(monitor.problem);
            let mut newton = Newton::new();
            while !monitor.is_over() {
                let before = state.point.merit;
                match step(&mut state, monitor, newton) {
                    Outcome::Accepted(next) => newton = next,
                    _ => break,
                }
                assert!(state.point.merit < before, "{sideways}");
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
    with_monitor(&scene, &pressed(0.2), |monitor| {
        let mut state = guess(monitor);
        for _ in 0..100 {
            let before = (state.point.z, state.point.r, state.point.merit);
            if let Outcome::Rejected = step(&mut state, monitor, Newton::new()) {
                assert_eq!(before, (state.point.z, state.point.r, state.point.merit));
                return;
            }
        }
        unreachable!("the scene has no solution");
    })
}

/// If the active set is that of the last solve, its Jacobian serves again, for a fifth of the work.
#[test]
fn a_kept_jacobian_saves_a_new_one() -> Result<(), Error> {
    let mut state = State::none();
    let scene = cube(1, 5.0)?; // sticks
    for (sideways, expected) in [(0.10, 1), (0.11, 0)] {
        with_monitor(&scene, &pressed(sideways), |monitor| {
            go_to_guess(&mut state, monitor);
            let newton = Newton::warm(false);
            while !monitor.is_over() {
                step(&mut state, monitor, newton);
            }
            assert_eq!(monitor.solution.work.newton_steps, expected, "{sideways}");
        })?;
    }
    assert!(state.holds_jacobian);
    Ok(())
}

/// The central path uses the matrix of the Jacobian, so the Jacobian is lost.
#[test]
fn a_jacobian_is_kept_until_the_central_path_uses_its_matrix() -> Result<(), Error> {
    with_monitor(&cube(4, 0.5)?, &pressed(0.6), |monitor| {
        let mut state = guess(monitor);
        assert!(!state.holds_jacobian);
        let mut newton = Newton::guessed();
        state.step_anew(monitor, &mut newton);
        assert!(state.holds_jacobian);
        state.begin_path(monitor);
        assert!(state.holds_jacobian);
        state.path_step(monitor);
        assert!(!state.holds_jacobian && !monitor.is_over());
        go_to_guess(&mut state, monitor);
        state.step_anew(monitor, &mut newton);
        assert!(state.holds_jacobian);
        state.forget();
        assert!(!state.holds_jacobian && matches!(state.chord_steps(monitor, &mut true), Chord::Unavailable));
    })
}
