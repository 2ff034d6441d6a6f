//! Steps of Newton's state: accepted, shortened, rejected, and with the Jacobian of the step before.
#![allow(clippy::indexing_slicing)]

use crate::Error;
use crate::solver::fixtures::{C, D, N, cube, pressed, with_monitor};
use crate::solver::monitor::Monitor;
use crate::solver::newton::{Newton, Outcome};
use crate::solver::state::State;
use nalgebra::vector;

/// Moves to the guess that all contacts stick.
fn go_to_guess(state: &mut State<f64, D, C, 0>, monitor: &Monitor<'_, '_, f64, N, D, C, 0, 0>) {
    monitor.problem.all_sticking(&mut state.point.z);
    state.point.update(monitor.problem);
}

/// A solve at the guess that all contacts stick.
fn guess(monitor: &Monitor<'_, '_, f64, N, D, C, 0, 0>) -> State<f64, D, C, 0> {
    let mut state = State::none();
    go_to_guess(&mut state, monitor);
    state
}

/// A step, and the answers to what it asks.
fn step(
    state: &mut State<f64, D, C, 0>,
    monitor: &mut Monitor<'_, '_, f64, N, D, C, 0, 0>,
    newton: Newton,
) -> Outcome {
    let outcome = state.step(monitor, newton);
    while monitor.waits() && !monitor.is_over() {
        state.judge(monitor);
    }
    outcome
}

#[test]
fn one_step_all_but_solves_what_sticks() -> Result<(), Error> {
    with_monitor(&cube(4, 0.5)?, &pressed(0.2), |monitor| {
        let mut state = guess(monitor);
        let outcome = step(&mut state, monitor, Newton::guessed());
        let Outcome::Accepted(newton) = outcome else {
            unreachable!("a linear problem")
        };
        assert!(state.point.estimate < 1e-3); // what damping has left
        step(&mut state, monitor, newton);
        assert!(monitor.is_over());
    })
}

/// A step that solves is none that was rejected, not even the last one.
#[test]
fn the_last_step_may_solve() -> Result<(), Error> {
    with_monitor(&cube(4, 0.5)?, &pressed(0.2), |monitor| {
        let mut state = guess(monitor);
        step(&mut state, monitor, Newton::guessed());
        let outcome = step(&mut state, monitor, Newton::last());
        assert!(monitor.is_over() && matches!(outcome, Outcome::Accepted(_)));
    })
}

/// From anywhere else than a guess no step may raise the merit function.
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

/// Between walls that close on it no step leads anywhere in the end; the point is left where it was.
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
        unreachable!("no solution to walk to for ever");
    })
}

/// Where each contact does what it did, the Jacobian of the last solve serves again, for a fifth of the price.
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

/// There is one matrix: the central path takes it away from a Jacobian, and a new one takes it back.
#[test]
fn a_jacobian_is_kept_until_the_matrix_is_lent() -> Result<(), Error> {
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
        assert!(!state.holds_jacobian && state.reuse_jacobian(monitor, &mut true).is_none());
    })
}
