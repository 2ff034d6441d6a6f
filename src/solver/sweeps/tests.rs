//! How many sweeps are made, of a cube on a corner and on four, and what they leave.
#![allow(clippy::expect_used)]

use crate::Error;
use crate::solver::fixtures::{C, D, cube, pressed, with_monitor};
use crate::solver::phases::Solve;
use crate::solver::sweeps::Pace;

/// Sweeps from zero impulses until they are given up or over; how many, and how that ended.
fn swept(corners: usize, mu: f64, sideways: f64) -> Result<(usize, &'static str), Error> {
    let scene = cube(corners, mu)?;
    with_monitor(&scene, &pressed(sideways), |monitor| {
        let mut solve = Solve::<f64, D, C>::none();
        solve.point.set_zero_impulse(monitor.problem);
        solve.begin_sweeps();
        loop {
            let pace = solve.sweep(monitor);
            let end = match pace {
                Pace::Continue if !monitor.is_over() => continue,
                Pace::Continue => "over",
                Pace::Enough => "enough",
            };
            return (monitor.solution.work.sweeps, end);
        }
    })
}

#[test]
fn one_contact_alone_takes_one_sweep() -> Result<(), Error> {
    for sideways in [0.0, 0.1, 3.0] {
        let (sweeps, end) = swept(1, 0.5, sideways)?;
        assert_eq!(end, "over", "{sideways}");
        assert!(sweeps <= 2, "{sideways}: {sweeps}"); // the multiplier of a slip is found in two
    }
    Ok(())
}

/// Four corners that begin to slip are more than sweeps can settle.
#[test]
fn sweeps_that_crawl_are_left() -> Result<(), Error> {
    let (sweeps, end) = swept(4, 0.5, 0.6)?;
    assert!(sweeps <= 3 && end == "enough", "{sweeps}: {end}");
    Ok(())
}

/// Without friction there is one row a corner: Newton's method is near once sweeps slow down.
#[test]
fn sweeps_that_slow_down_near_the_end_are_enough() -> Result<(), Error> {
    let (sweeps, end) = swept(4, 0.0, 0.0)?;
    assert!(sweeps >= 2, "{sweeps}: {end}");
    Ok(())
}

/// What a warm start keeps of a contact that slides is `û`, after sweeps as after Newton's method.
#[test]
fn sweeps_leave_augmented_velocities() -> Result<(), Error> {
    with_monitor(&cube(1, 0.5)?, &pressed(2.0), |monitor| {
        let mut solve = Solve::none();
        solve.point.set_zero_impulse(monitor.problem);
        solve.phase = solve.begin_sweeps();
        solve.sweep_once(monitor);
        let (u, r) = solve.contacts(monitor.problem).next().expect("a corner");
        assert!(r.x > 0.0 && u.yz().norm() > 0.1);
        assert!((u.x - 0.5 * u.yz().norm()).abs() < 1e-6);
    })
}
