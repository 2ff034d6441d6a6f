//! What the monitor keeps, and when it stops.
#![allow(clippy::indexing_slicing, clippy::float_cmp)]

use crate::linalg::blocks::ContactVector;
use crate::solver::fixtures::{C, D, N, cube, pressed, with_monitor};
use crate::solver::monitor::Monitor;
use crate::{Error, Status};
use nalgebra::{SVector, vector};

/// Each of four corners carries this share of the weight.
fn carried(share: f64) -> ContactVector<f64, D, C> {
    [[share, 0.0, 0.0]; C]
}

/// Ends a call with these impulses at present.
fn finish(monitor: &mut Monitor<'_, '_, f64, N, D, C>, present: ContactVector<f64, D, C>) {
    monitor.finish(present.into_iter().map(SVector::from));
}

fn show(monitor: &mut Monitor<'_, '_, f64, N, D, C>, r: &ContactVector<f64, D, C>) {
    let mut u = carried(0.0);
    let natural_map = monitor.problem.natural_map(r, &mut u);
    monitor.consider(r, &u, natural_map);
}

#[test]
fn the_solution_ends_a_solve() -> Result<(), Error> {
    with_monitor(&cube(4, 0.5)?, &pressed(0.0), |monitor| {
        show(monitor, &carried(0.1));
        assert!(monitor.is_running());
        show(monitor, &carried(0.25));
        assert!(monitor.is_over());
        finish(monitor, carried(0.0));
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
        finish(monitor, carried(0.3));
        assert_eq!(monitor.solution.status, Status::OutOfBudget);
        assert_eq!(monitor.solution.contacts[2].impulse.x, 0.24);
        // What is there at present counts too, if it is better.
        finish(monitor, carried(0.249));
        assert_eq!(monitor.solution.contacts[2].impulse.x, 0.249);
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

/// Patience, in work, is 200 for each bit above `64 eps`, and begins anew with an error that is halved.
#[test]
fn work_without_a_halved_error_ends_a_solve() -> Result<(), Error> {
    with_monitor(&cube(4, 0.5)?, &pressed(0.0), |monitor| {
        let bits = |bits: i32| 64.0 * f64::EPSILON * 2.0_f64.powi(bits);
        for (natural_map, patience) in [(bits(10), 2000), (bits(8), 1600), (bits(0), 0)] {
            monitor.record.natural_map = Some(natural_map);
            monitor.fail();
            monitor.solution.work.iterations += patience;
            monitor.fail();
            assert!(!monitor.is_over());
        }
        monitor.solution.work.iterations += 1;
        monitor.fail();
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
    with_monitor(&scene, &pressed(0.0), |monitor| {
        show(monitor, &carried(0.0));
        finish(monitor, carried(0.0));
        monitor.doubt();
        assert_eq!(monitor.solution.status, Status::Infeasible);
        assert_eq!(monitor.solution.work.proof_searches, 1);
        let d = &monitor.solution.certificate;
        assert!(d.len() == 2 && d[0] > 0.0 && (d[0] - d[1]).abs() < 1e-12);
    })
}

/// Where standing still satisfies all contacts there is nothing to look for.
#[test]
fn a_floor_is_not_searched_for_a_proof() -> Result<(), Error> {
    with_monitor(&cube(4, 0.5)?, &pressed(0.0), |monitor| {
        monitor.look_for_proof();
        assert_eq!(monitor.solution.work.proof_searches, 0);
    })
}
