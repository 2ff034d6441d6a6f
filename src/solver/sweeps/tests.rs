//! How many sweeps are made, of a cube on a corner and on four, and what they leave.
#![allow(clippy::indexing_slicing)]

use crate::linalg::stacked::Stacked;
use crate::problem::Problem;
use crate::sets::sweep;
use crate::solver::fixtures::{C, D, N, cube, pressed, with_monitor};
use crate::solver::method::{Method, Phase};
use crate::solver::phases::AllPhases;
use crate::solver::point::NewtonPoint;
use crate::solver::state::State;
use crate::solver::sweeps::Pace;
use crate::{Error, Factor, JointRow, Model, RowLaw, Scene};
use nalgebra::SVector;

/// Sweeps from zero impulses until they are given up or over; how many, and how that ended.
fn swept(corners: usize, mu: f64, sideways: f64) -> Result<(usize, &'static str), Error> {
    let scene = cube(corners, mu)?;
    with_monitor(&scene, &pressed(sideways), |monitor| {
        let mut state = State::<f64, D, C, 0>::none();
        state.point.set_zero_impulse(monitor.problem);
        state.begin_sweeps(monitor);
        loop {
            let pace = state.sweep(monitor);
            let end = match pace {
                Pace::Continue if !monitor.waits() => continue,
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
        let mut method = Method::none(AllPhases);
        method.state.point.set_zero_impulse(monitor.problem);
        method.state.begin_sweeps(monitor);
        method.phase = Phase::Sweeps;
        method.state.sweep_once(monitor);
        let [u, r] = method.solution(monitor.problem);
        let u = SVector::from(u.contacts[0]);
        assert!(r.contacts[0][0] > 0.0 && u.yz().norm() > 0.1);
        assert!((u.x - 0.5 * u.yz().norm()).abs() < 1e-6);
    })
}

/// Sweeps add to velocities what each impulse adds, of contacts and of joint rows beside them; and each sweep lowers the energy
/// `½ r·W r + q·r` of what has no friction.
#[test]
fn sweeps_keep_the_velocities_of_their_impulses() -> Result<(), Error> {
    for mu in [0.0, 0.5] {
        let mut scene = Scene::<f64, N, D, C, 4>::new();
        scene.set_mass(cube(C, mu)?.mass())?;
        for contact in cube(C, mu)?.contacts() {
            scene.push(contact)?;
        }
        let bounded = |bound: f64| RowLaw::Box {
            lower: -bound,
            upper: bound,
        };
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
        let (factor, push) = (Factor::new(&scene)?, pressed(0.3));
        let mut problem = Problem::new(&scene, &factor, &push, Model::Coulomb);
        problem.fill(true);
        let mut point = NewtonPoint::none();
        point.set_zero_impulse(&problem);
        let (mut multipliers, mut last) = ([0.0; C], 0.0);
        for _ in 0..10 {
            sweep::sweep(
                &problem.sets,
                problem.factor,
                problem.model,
                &mut point.r,
                &mut point.u,
                &mut multipliers,
            );
            let mut u = Stacked::zero();
            problem.velocities(&point.r, &mut u);
            for (kept, u) in point.u.iter().zip(u.iter()) {
                assert!((kept - u).abs() < 1e-14, "{kept} {u}");
            }
            let mut energy = 0.0;
            for (set, (r, u)) in problem
                .sets
                .contacts()
                .iter()
                .zip(point.r.contacts.iter().zip(&u.contacts))
            {
                energy += (SVector::from(*u) + set.q).dot(&SVector::from(*r)) / 2.0;
            }
            for (set, (r, u)) in problem
                .sets
                .rows()
                .iter()
                .zip(point.r.rows.iter().zip(&u.rows))
            {
                energy += (u + set.q) * r / 2.0;
            }
            assert!(mu > 0.0 || energy <= last, "{energy} {last}");
            last = energy;
        }
        let rows = point.r.rows;
        assert!(
            rows[0] > 0.0 && rows[1] != 0.0 && (rows[2] - 0.01).abs() < 1e-15,
            "{rows:?}"
        );
    }
    Ok(())
}
