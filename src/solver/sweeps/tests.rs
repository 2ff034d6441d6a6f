//! The number of sweeps of a cube on one corner and on four, and the velocities after them.
#![allow(clippy::indexing_slicing)]

use crate::linalg::stacked::Stacked;
use crate::problem::Problem;
use crate::solver::fixtures::{C, D, N, cube, pressed, with_solve, with_solve_from};
use crate::solver::record::Call;
use crate::solver::state::{Phase, State};
use crate::solver::sweeps::Pace;
use crate::solver::tuning;
use crate::solver::warm_start::WarmStart;
use crate::{Error, JointRow, RowLaw, Scene};
use nalgebra::SVector;

/// Sweeps from zero impulses until the solve is over or another sweep does not pay. Returns their number and the kind of end.
fn swept(corners: usize, mu: f64, sideways: f64) -> Result<(usize, &'static str), Error> {
    let scene = cube(corners, mu)?;
    with_solve(&scene, &pressed(sideways), |solve| {
        solve.set_zero_impulse();
        loop {
            let pace = solve.sweep();
            let end = match pace {
                Pace::Continue if !solve.monitor.must_return() => continue,
                Pace::Continue => "over",
                Pace::Enough => "enough",
            };
            return (solve.monitor.solution.work.sweeps, end);
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

/// Sweeps converge slowly for four corners that begin to slip.
#[test]
fn slow_sweeps_end() -> Result<(), Error> {
    let (sweeps, end) = swept(4, 0.5, 0.6)?;
    assert_eq!((sweeps, end), (tuning::sweeps(), "enough"));
    Ok(())
}

/// Without friction there is one row a corner, and sweeps slow down near the solution.
#[test]
fn sweeps_that_slow_down_near_the_end_are_enough() -> Result<(), Error> {
    let (sweeps, end) = swept(4, 0.0, 0.0)?;
    assert!(sweeps >= 2, "{sweeps}: {end}");
    Ok(())
}

/// A warm start keeps `û` of a sliding contact, after sweeps as after Newton's method.
#[test]
fn sweeps_leave_augmented_velocities() -> Result<(), Error> {
    with_solve(&cube(1, 0.5)?, &pressed(2.0), |solve| {
        solve.set_zero_impulse();
        solve.state.phase = Phase::Sweeps;
        solve.sweep_once();
        solve.complete_point();
        let u = SVector::from(solve.state.point.p.contacts[0]);
        assert!(solve.state.point.r.contacts[0][0] > 0.0 && u.yz().norm() > 0.1);
        assert!((u.x - 0.5 * u.yz().norm()).abs() < 1e-6);
    })
}

/// `½ r·W r + q·r` of impulses with the velocities `u = W r + q`.
fn energy<const R: usize>(
    problem: &Problem<'_, f64, N, D, C, R, 0>,
    r: &Stacked<f64, D, C, R>,
    u: &Stacked<f64, D, C, R>,
) -> f64 {
    let mut energy = 0.0;
    let values = r.contacts.iter().zip(&u.contacts);
    for (set, (r, u)) in problem.sets.contacts().iter().zip(values) {
        energy += (SVector::from(*u) + set.q).dot(&SVector::from(*r)) / 2.0;
    }
    let values = r.rows.iter().zip(&u.rows);
    for (set, (r, u)) in problem.sets.rows().iter().zip(values) {
        energy += (u + set.q) * r / 2.0;
    }
    energy
}

/// Sweeps keep `u = W r + q`, for contacts and joint rows. Without friction each sweep lowers the energy `½ r·W r + q·r`.
#[test]
fn sweeps_keep_the_velocities_of_their_impulses() -> Result<(), Error> {
    for mu in [0.0, 0.5] {
        let mut scene = Scene::<f64, N, D, C, 4>::new();
        scene.set_mass(cube(C, mu)?.mass())?;
        for contact in cube(C, mu)?.contacts() {
            scene.push(contact)?;
        }
        let bounded = |bound: f64| RowLaw::Box { lower: -bound, upper: bound };
        let laws = [RowLaw::Limit, RowLaw::Equality, bounded(0.01)];
        for (key, law) in (0..).zip(laws) {
            let entry = |i: usize, j: usize| f64::from(i == 3 + j) + f64::from(i < 3) * 0.3;
            scene.push_row(&JointRow {
                row: SVector::from_fn(|i, _| entry(i, usize::try_from(key).unwrap_or(0))),
                offset: -0.2,
                law,
                compliance: 0.1,
                key,
            })?;
        }
        let last = (&mut State::none(), &mut WarmStart::cold());
        let rows = with_solve_from(last, Call::Begin, (&scene, &pressed(0.3)), |solve| {
            solve.set_zero_impulse();
            let mut last = 0.0;
            for _ in 0..10 {
                solve.sweep_once();
                let (problem, point) = solve.problem_and_point();
                let mut u = Stacked::zero();
                problem.velocities(&point.r, &mut u);
                for (kept, u) in point.u.iter().zip(u.iter()) {
                    assert!((kept - u).abs() < 1e-14, "{kept} {u}");
                }
                let energy = energy(problem, &point.r, &u);
                assert!(mu > 0.0 || energy <= last, "{energy} {last}");
                last = energy;
            }
            solve.state.point.r.rows
        })?;
        assert!(rows[0] > 0.0 && rows[1] != 0.0 && (rows[2] - 0.01).abs() < 1e-15, "{rows:?}");
    }
    Ok(())
}
