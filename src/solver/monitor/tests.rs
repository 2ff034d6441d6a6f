//! The impulses that the monitor keeps, and the end of a solve.
#![allow(clippy::indexing_slicing, clippy::float_cmp)]

use crate::linalg::stacked::Stacked;
use crate::solver::AllPhases;
use crate::solver::fixtures::{C, D, N, cube, pressed, with_monitor, with_solve};
use crate::solver::monitor::Monitor;
use crate::solver::tuning;
use crate::{Error, Status};
use nalgebra::vector;

/// Impulses with which each of four corners carries this share of the weight.
fn carried(share: f64) -> Stacked<f64, D, C, 0> {
    Stacked { contacts: [[share, 0.0, 0.0]; C], rows: [] }
}

/// Shows impulses to the monitor, and makes the check that is due.
fn show(monitor: &mut Monitor<'_, '_, f64, N, D, C, 0, 0>, r: &Stacked<f64, D, C, 0>) {
    let mut u = carried(0.0);
    let estimate = monitor.problem.velocities_and_estimate(r, &mut u);
    monitor.consider(r, &u, estimate);
    if monitor.must_return() {
        monitor.check::<AllPhases>(r, &u);
    }
}

#[test]
fn the_solution_ends_a_solve() -> Result<(), Error> {
    with_monitor(&cube(4, 0.5)?, &pressed(0.0), |monitor| {
        show(monitor, &carried(0.1));
        assert!(monitor.is_running());
        show(monitor, &carried(0.25));
        assert!(monitor.is_over());
        monitor.finish::<AllPhases>();
        assert_eq!(monitor.solution.status, Status::Solved);
        assert!(monitor.solution.error <= 1e-9);
    })
}

#[test]
fn the_best_of_what_was_shown_is_kept() -> Result<(), Error> {
    with_monitor(&cube(4, 0.5)?, &pressed(0.0), |monitor| {
        for share in [0.1, 0.24, 0.4, 0.0] {
            show(monitor, &carried(share));
        }
        let written = monitor.finish::<AllPhases>();
        assert_eq!(monitor.solution.status, Status::OutOfBudget);
        assert_eq!(monitor.solution.contacts[2].impulse.x, 0.24);
        assert_eq!(written.map(|[_, r]| r), Some(carried(0.24)));
    })
}

#[test]
fn a_budget_ends_a_call() -> Result<(), Error> {
    with_monitor(&cube(4, 0.5)?, &pressed(0.0), |monitor| {
        monitor.solution.work.iterations = 89;
        monitor.solution.work.newton_steps = 1;
        assert!(monitor.is_running());
        monitor.solution.work.iterations += 1;
        assert!(!monitor.is_running() && !monitor.is_over());
    })
}

/// Near rounding, a halved error starts the count of work again. Far from rounding, the count ends no solve.
#[test]
fn work_without_a_halved_error_near_rounding_ends_a_solve() -> Result<(), Error> {
    with_monitor(&cube(4, 0.5)?, &pressed(0.0), |monitor| {
        let patience = tuning::patience();
        for (estimate, work) in
            [(1e-9, 100 * patience), (1000.0 * f64::EPSILON, patience), (400.0 * f64::EPSILON, patience)]
        {
            monitor.record.best_estimate = Some(estimate);
            monitor.note_failure();
            monitor.solution.work.iterations += work;
            monitor.note_failure();
            assert!(!monitor.is_over());
        }
        monitor.solution.work.iterations += 1;
        monitor.note_failure();
        assert_eq!(monitor.record.status, Status::PrecisionLimit);
    })
}

#[test]
fn walls_that_close_are_proved() -> Result<(), Error> {
    let mut scene = cube(2, 0.5)?;
    let floor = scene.contacts()[0].jacobian;
    scene.set_jacobian(1, &-floor)?; // a ceiling at the same corner
    for contact in 0..2 {
        scene.set_offset(contact, &vector![-0.1, 0.0, 0.0])?;
    }
    with_solve(&scene, &pressed(0.0), |solve| {
        show(&mut solve.monitor, &carried(0.0));
        solve.monitor.finish::<AllPhases>();
        solve.check_infeasibility();
        let monitor = &solve.monitor;
        assert_eq!(monitor.solution.status, Status::Infeasible);
        assert_eq!(monitor.solution.work.proof_searches, 1);
        let d = &monitor.solution.certificate;
        assert!(d.len() == 2 && d[0][0] > 0.0 && (d[0] - d[1]).norm() < 1e-12);
    })
}

/// If standing still satisfies all contacts, there is no search.
#[test]
fn a_floor_is_not_searched_for_a_proof() -> Result<(), Error> {
    with_monitor(&cube(4, 0.5)?, &pressed(0.0), |monitor| {
        monitor.look_for_proof();
        assert_eq!(monitor.solution.work.proof_searches, 0);
    })
}
