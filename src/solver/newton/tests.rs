//! Steps of Newton's method: accepted, shortened, rejected, and with the Jacobian of the step before.
#![allow(clippy::indexing_slicing)]

use crate::Error;
use crate::solver::fixtures::{C, D, N, cube, pressed, with_monitor};
use crate::solver::monitor::Monitor;
use crate::solver::newton::{Newton, Outcome};
use crate::solver::phases::Solve;
use crate::solver::workspace::Workspace;
use nalgebra::vector;

/// A solve at the guess that all contacts stick.
fn guess(monitor: &Monitor<'_, '_, f64, N, D, C>) -> Solve<f64, D, C> {
    let mut solve = Solve::none();
    monitor.problem.all_sticking(&mut solve.point.z);
    solve.point.update(monitor.problem);
    solve
}

#[test]
fn one_step_all_but_solves_what_sticks() -> Result<(), Error> {
    with_monitor(&cube(4, 0.5)?, &pressed(0.2), |monitor| {
        let (mut solve, mut workspace) = (guess(monitor), Workspace::none());
        let outcome = solve.step(monitor, &mut workspace, Newton::guessed());
        let Outcome::Accepted(newton) = outcome else {
            unreachable!("a linear problem")
        };
        assert!(solve.point.natural_map < 1e-3); // what damping has left
        solve.step(monitor, &mut workspace, newton);
        assert!(monitor.is_over());
    })
}

/// A step that solves is none that was rejected, not even the last one.
#[test]
fn the_last_step_may_solve() -> Result<(), Error> {
    with_monitor(&cube(4, 0.5)?, &pressed(0.2), |monitor| {
        let (mut solve, mut workspace) = (guess(monitor), Workspace::none());
        solve.step(monitor, &mut workspace, Newton::guessed());
        let outcome = solve.step(monitor, &mut workspace, Newton::last());
        assert!(monitor.is_over() && matches!(outcome, Outcome::Accepted(_)));
    })
}

/// From anywhere else than a guess no step may raise the merit function.
#[test]
fn every_accepted_step_lowers_the_merit() -> Result<(), Error> {
    for sideways in [0.1, 0.45, 0.6, 2.0] {
        with_monitor(&cube(4, 0.5)?, &pressed(sideways), |monitor| {
            let (mut solve, mut workspace) = (guess(monitor), Workspace::none());
            solve.point.set_zero_impulse(monitor.problem);
            solve.point.rebuild(monitor.problem);
            let mut newton = Newton::new();
            while !monitor.is_over() {
                let before = solve.point.merit;
                match solve.step(monitor, &mut workspace, newton) {
                    Outcome::Accepted(next) => newton = next,
                    _ => break,
                }
                assert!(solve.point.merit < before, "{sideways}");
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
        let (mut solve, mut workspace) = (guess(monitor), Workspace::none());
        for _ in 0..100 {
            let before = (solve.point.z, solve.point.r, solve.point.merit);
            if let Outcome::Rejected = solve.step(monitor, &mut workspace, Newton::new()) {
                assert_eq!(before, (solve.point.z, solve.point.r, solve.point.merit));
                return;
            }
        }
        unreachable!("no solution to walk to for ever");
    })
}

/// Where each contact does what it did, the Jacobian of the last solve serves again, for a fifth of the price.
#[test]
fn a_kept_jacobian_saves_a_new_one() -> Result<(), Error> {
    let mut workspace = Workspace::none();
    let scene = cube(1, 5.0)?; // sticks
    for (sideways, expected) in [(0.10, 1), (0.11, 0)] {
        with_monitor(&scene, &pressed(sideways), |monitor| {
            let mut solve = guess(monitor);
            let newton = Newton::warm(false);
            while !monitor.is_over() {
                solve.step(monitor, &mut workspace, newton);
            }
            assert_eq!(monitor.solution.work.newton_steps, expected, "{sideways}");
        })?;
    }
    assert!(workspace.holds_jacobian());
    Ok(())
}
