//! Joint rows: what mechanics says of them.

use crate::support::boxes::GRAVITY;
use crate::support::sizes::point_rows;
use nalgebra::{Matrix3, SMatrix, SVector, vector};
use stiction::time_stepping::{ClosedLoop, DryFriction, JointLimit, Motor};
use stiction::{Contact, Error, Factor, JointRow, RowLaw, RowMode, Settings, Solver};

#[test]
fn a_pendulum_on_its_stop_loses_its_momentum_there() -> Result<(), Error> {
    let (inertia, speed, step) = (0.3, 1.7, 1e-3);
    let mut scene = point_rows::Scene::<f64>::new();
    scene.set_mass(&(Matrix3::identity() * inertia))?;
    let limit = JointLimit { distance: 0.0, recovery: 0.0, reach: 10.0 };
    let stop = scene.push_row(&limit.row(SVector::ith(0, 1.0), step, 0)?)?;
    let weight = 0.8; // N·m, onto the stop
    let push = SVector::ith(0, -inertia * speed - step * weight);
    let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
    let solution = solver.solve(&scene, &factor, &push, &Settings::new(1e-12))?;
    let stop = solution.rows[stop];
    assert_eq!(stop.mode, RowMode::AtLimit);
    assert!((stop.impulse - (inertia * speed + step * weight)).abs() < 1e-12);
    assert!(solution.velocity[0].abs() < 1e-12);
    Ok(())
}

#[test]
fn dry_friction_stops_a_flywheel_after_its_momentum_over_the_torque() -> Result<(), Error> {
    let (inertia, speed, torque, step) = (0.2, 3.0, 0.5, 1e-3);
    let mut kernel = point_rows::Kernel::<f64>::new();
    kernel.scene_mut().set_mass(&(Matrix3::identity() * inertia))?;
    let row = DryFriction { torque }.row(SVector::ith(0, 1.0), step, 0)?;
    let gear = kernel.scene_mut().push_row(&row)?;
    let (mut velocity, mut steps) = (speed, 0_u32);
    while velocity > 1e-12 {
        let solution = kernel.solve(&SVector::ith(0, inertia * velocity), &Settings::new(1e-12))?;
        velocity = solution.velocity[0];
        steps += 1;
        let mode = solution.rows[gear].mode;
        assert!(mode == RowMode::AtLower || velocity < 1e-9, "{mode:?}");
    }
    assert!((f64::from(steps) * step - inertia * speed / torque).abs() < 1.5 * step);
    // And holds what is less than it.
    let push = SVector::ith(0, 0.9 * torque * step);
    let solution = kernel.solve(&push, &Settings::new(1e-12))?;
    let gear = solution.rows[gear];
    assert_eq!((gear.mode, solution.velocity[0]), (RowMode::Holding, 0.0));
    Ok(())
}

/// What is left of its momentum is rounding, and says nothing of the impulses that the spring brings.
#[test]
fn a_spring_presses_a_body_at_rest_onto_its_contacts() -> Result<(), Error> {
    for exponent in 10..24 {
        for step in 0..40 {
            let speed = 0.1 + 0.01 * f64::from(step); // of the spring alone
            let mut kernel = point_rows::Kernel::<f64>::new();
            let scene = kernel.scene_mut();
            scene.set_mass(&(Matrix3::identity() * 2.0))?;
            for key in 0..4 {
                let jacobian = SMatrix::from_diagonal(&vector![-1.0, 0.0, 0.0]);
                let offset = SVector::zeros();
                scene.push(&Contact { jacobian, offset, mu: 1.0, key })?;
            }
            let (law, compliance, key) = (RowLaw::Equality, 0.5, 0);
            let row = SVector::ith(0, 1.0);
            scene.push_row(&JointRow { row, offset: -speed, law, compliance, key })?;
            let rounding = SVector::ith(0, 10_f64.powi(-exponent));
            let solution = kernel.solve(&rounding, &Settings::new(1e-8))?;
            assert!(solution.is_solved(), "{exponent} {speed} {:?}", solution.status);
            let pressed: f64 = solution.contacts.iter().map(|contact| contact.impulse[0]).sum();
            assert!((pressed - speed / compliance).abs() < 1e-7 && solution.velocity[0].abs() < 1e-8);
        }
    }
    Ok(())
}

#[test]
fn a_saturated_motor_lifts_exactly_what_it_can() -> Result<(), Error> {
    let (step, limit) = (1e-3, 30.0);
    let motor = Motor { stiffness: 4e4, damping: 400.0, limit, ..Motor::default() };
    // Asked to hold, and to lift what is too heavy by a metre.
    for (mass, saturated, target) in [(2.0, false, 0.0), (5.0, true, 1.0)] {
        let weight = mass * GRAVITY;
        let mut kernel = point_rows::Kernel::<f64>::new();
        kernel.scene_mut().set_mass(&(Matrix3::identity() * mass))?;
        let (mut height, mut velocity) = (0.0, 0.0);
        let row = |height: f64| {
            let ahead = height - target;
            Motor { ahead, ..motor }.row(SVector::ith(0, 1.0), step, 0)
        };
        let lift = kernel.scene_mut().push_row(&row(0.0)?)?;
        for _ in 0..300 {
            kernel.scene_mut().set_row_offset(lift, row(height)?.offset)?;
            let push = SVector::ith(0, mass * velocity - step * weight);
            let solution = kernel.solve(&push, &Settings::new(1e-12))?;
            velocity = solution.velocity[0];
            height += step * velocity;
        }
        let mode = kernel.solution().rows[lift].mode;
        if saturated {
            // It falls by what the motor cannot carry.
            let fallen = 0.5 * (limit - weight) / mass * (300.0 * step) * (301.0 * step);
            assert_eq!(mode, RowMode::AtUpper);
            assert!((height - fallen).abs() < 1e-9, "{height} {fallen}");
        } else {
            // A spring holds it.
            assert_eq!(mode, RowMode::Holding);
            assert!((height + weight / motor.stiffness).abs() < 1e-9, "{height}");
        }
    }
    Ok(())
}

/// How far the ends of a four-bar linkage are apart, and the rows of that: three rotors whose arms have no mass.
fn four_bar(angles: &SVector<f64, 3>) -> (SVector<f64, 2>, SMatrix<f64, 2, 3>) {
    let lengths = [0.1, 0.25, 0.15];
    let ends = vector![0.2, 0.0];
    let mut gap = -ends;
    let mut rows = SMatrix::<f64, 2, 3>::zeros();
    for (k, length) in lengths.into_iter().enumerate() {
        let sign = if k == 2 { -1.0 } else { 1.0 };
        let (sin, cos) = angles[k].sin_cos();
        gap += vector![cos, sin] * (sign * length);
        rows.set_column(k, &(vector![-sin, cos] * (sign * length)));
    }
    (gap, rows)
}

#[test]
fn a_four_bar_loop_does_not_drift_over_a_hundred_thousand_steps() -> Result<(), Error> {
    let (step, speed) = (1e-4, 0.1);
    let mass = Matrix3::from_diagonal(&vector![1e-3, 2e-3, 1.5e-3]);
    // Closed by Newton's method at a right angle of the crank.
    let mut angles = vector![1.5, 0.6, 1.9];
    for _ in 0..20 {
        let (gap, rows) = four_bar(&angles);
        let others = rows.fixed_columns::<2>(1).into_owned();
        let change = others.try_inverse().expect("it moves") * gap;
        angles -= vector![0.0, change[0], change[1]];
    }
    assert!(four_bar(&angles).0.norm() < 1e-15);
    let drive = Motor { damping: 1.0, limit: 5.0, target: speed, ..Motor::default() };
    let mut velocity = SVector::zeros();
    let mut kernel = point_rows::Kernel::<f64>::new();
    kernel.scene_mut().set_mass(&mass)?;
    let (mut early, mut late) = (0.0_f64, 0.0_f64);
    for k in 0..100_000 {
        let (gap, rows) = four_bar(&angles);
        let scene = kernel.scene_mut();
        scene.clear_rows();
        scene.push_row(&drive.row(SVector::ith(0, 1.0), step, 9)?)?;
        for (key, (row, &drift)) in (0..).zip(rows.row_iter().zip(&gap)) {
            let closed = ClosedLoop { drift, recovery: 1.0 };
            scene.push_row(&closed.row(row.transpose(), step, key)?)?;
        }
        let solution = kernel.solve(&(mass * velocity), &Settings::new(1e-12))?;
        assert!(solution.is_solved(), "{:?}", solution.status);
        velocity = solution.velocity;
        angles += velocity * step;
        let drift = four_bar(&angles).0.norm();
        if k < 50_000 {
            early = early.max(drift);
        } else {
            late = late.max(drift);
        }
    }
    println!("drift in the first half {early:.1e} m, in the second {late:.1e} m");
    assert!(early < 1e-9 && late < 1e-9);
    assert!((velocity[0] - speed).abs() < 0.05 * speed);
    Ok(())
}

#[test]
fn a_loop_of_redundant_rows_holds_like_one_without() -> Result<(), Error> {
    let solve = |copies: usize| -> Result<SVector<f64, 3>, Error> {
        let mut scene = point_rows::Scene::<f64>::new();
        scene.set_mass(&Matrix3::from_diagonal(&vector![1.0, 3.0, 1.0]))?;
        let closed = ClosedLoop { drift: 0.0, recovery: 1.0 };
        let row = closed.row(vector![1.0, -2.0, 0.0], 1e-3, 0)?;
        for _ in 0..copies {
            scene.push_row(&row)?;
        }
        let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
        let solution = solver.solve(&scene, &factor, &vector![1.0, 0.5, 0.0], &Settings::new(1e-10))?;
        assert!(solution.is_solved());
        Ok(solution.velocity)
    };
    let (one, five) = (solve(1)?, solve(5)?);
    assert!((one[0] - 2.0 * one[1]).abs() < 1e-9);
    assert!((one - five).norm() < 1e-9);
    Ok(())
}
