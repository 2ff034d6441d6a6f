//! Joint rows, compliance and shapes of friction: what mechanics says of them.

use crate::support::boxes::GRAVITY;
use nalgebra::{Matrix1, Matrix2, Matrix3, SMatrix, SVector, matrix, vector};
use stiction::time_stepping as law;
use stiction::time_stepping::Motor;
use stiction::{
    Contact, ContactMode, Error, Factor, JointRow, Kernel, Mixed, RowMode, Scene, Settings, Solver,
    Surface,
};

#[test]
fn a_pendulum_on_its_stop_loses_its_momentum_there() -> Result<(), Error> {
    let (inertia, speed, step) = (0.3, 1.7, 1e-3);
    let mut scene = Scene::<f64, 1, 3, 1, _>::mixed();
    scene.set_mass(&Matrix1::new(inertia))?;
    let stop = scene.push_row(&law::joint_limit(vector![1.0], 0.0, step, 0.0, 10.0, 0))?;
    let weight = 0.8; // N·m, onto the stop
    let push = vector![-inertia * speed - step * weight];
    let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
    let solution = solver.solve(&scene, &factor, &push, &Settings::new(1e-12))?;
    let stop = solution.row(stop).expect("it is there");
    assert_eq!(stop.mode, RowMode::AtLimit);
    assert!((stop.impulse - (inertia * speed + step * weight)).abs() < 1e-12);
    assert!(solution.velocity[0].abs() < 1e-12);
    Ok(())
}

#[test]
fn dry_friction_stops_a_flywheel_after_its_momentum_over_the_torque() -> Result<(), Error> {
    let (inertia, speed, torque, step) = (0.2, 3.0, 0.5, 1e-3);
    let mut kernel = Kernel::<f64, 1, 2, 1, _>::mixed();
    kernel.scene_mut().set_mass(&Matrix1::new(inertia))?;
    let row = law::dry_friction(vector![1.0], torque, step, 0);
    let gear = kernel.scene_mut().push_row(&row)?;
    let (mut velocity, mut steps) = (speed, 0_u32);
    while velocity > 1e-12 {
        let solution = kernel.solve(&vector![inertia * velocity], &Settings::new(1e-12))?;
        velocity = solution.velocity[0];
        steps += 1;
        let mode = solution.row(gear).expect("it is there").mode;
        assert!(mode == RowMode::AtLower || velocity < 1e-9, "{mode:?}");
    }
    assert!((f64::from(steps) * step - inertia * speed / torque).abs() < 1.5 * step);
    // And holds what is less than it.
    let push = vector![0.9 * torque * step];
    let solution = kernel.solve(&push, &Settings::new(1e-12))?;
    let gear = solution.row(gear).expect("it is there");
    assert_eq!((gear.mode, solution.velocity[0]), (RowMode::Holding, 0.0));
    Ok(())
}

#[test]
fn a_saturated_motor_lifts_exactly_what_it_can() -> Result<(), Error> {
    let (step, limit) = (1e-3, 30.0);
    let motor = Motor {
        stiffness: 4e4,
        damping: 400.0,
        feedforward: 0.0,
        limit,
    };
    // Asked to hold, and to lift what is too heavy by a metre.
    for (mass, saturated, target) in [(2.0, false, 0.0), (5.0, true, 1.0)] {
        let weight = mass * GRAVITY;
        let mut kernel = Kernel::<f64, 1, 3, 1, _>::mixed();
        kernel.scene_mut().set_mass(&Matrix1::new(mass))?;
        let (mut height, mut velocity) = (0.0, 0.0);
        let row = |height: f64| law::motor(vector![1.0], &motor, height - target, 0.0, step, 0);
        let lift = kernel.scene_mut().push_row(&row(0.0))?;
        for _ in 0..300 {
            kernel
                .scene_mut()
                .set_row_offset(lift, row(height).offset)?;
            let push = vector![mass * velocity - step * weight];
            let solution = kernel.solve(&push, &Settings::new(1e-12))?;
            velocity = solution.velocity[0];
            height += step * velocity;
        }
        let mode = kernel.solution().row(lift).expect("it is there").mode;
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
    let drive = Motor {
        stiffness: 0.0,
        damping: 1.0,
        feedforward: 0.0,
        limit: 5.0,
    };
    let mut velocity = SVector::zeros();
    let mut kernel = Kernel::<f64, 3, 3, 2, _>::mixed();
    kernel.scene_mut().set_mass(&mass)?;
    let (mut early, mut late) = (0.0_f64, 0.0_f64);
    for k in 0..100_000 {
        let (gap, rows) = four_bar(&angles);
        let scene = kernel.scene_mut();
        scene.clear_contacts();
        scene.push_row(&law::motor(
            SVector::ith(0, 1.0),
            &drive,
            0.0,
            speed,
            step,
            9,
        ))?;
        for (key, (row, &gap)) in (0..).zip(rows.row_iter().zip(&gap)) {
            scene.push_row(&law::closed_loop(row.transpose(), gap, step, 1.0, key))?;
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
fn a_compliant_foot_sinks_by_its_weight_over_its_stiffness() -> Result<(), Error> {
    let (mass, stiffness, relaxation, step) = (3.0, 5e3, 5e-3, 2e-3);
    let mut kernel = Kernel::<f64, 2, 2, 1, _>::mixed();
    kernel.scene_mut().set_mass(&(Matrix2::identity() * mass))?;
    let contact = Contact {
        jacobian: matrix![0.0, 1.0; 1.0, 0.0],
        offset: vector![0.0, 0.0],
        mu: 0.5,
        key: 0,
    };
    let surface = Surface {
        compliance: [law::compliance(stiffness, relaxation, step), 0.0],
        ..Surface::isotropic(0.5)
    };
    kernel.scene_mut().push_on(&contact, &surface)?;
    let (mut height, mut velocity) = (0.0, vector![0.0, 0.0]);
    for _ in 0..2000 {
        let gap = law::compliant_gap(height, relaxation, step, 10.0);
        kernel.scene_mut().set_offset(0, &vector![gap, 0.0])?;
        let push = velocity * mass + vector![0.1, -mass * GRAVITY] * step;
        velocity = kernel.solve(&push, &Settings::new(1e-12))?.velocity;
        height += step * velocity.y;
    }
    assert!(
        (height + mass * GRAVITY / stiffness).abs() < 1e-9,
        "{height}"
    );
    assert!(velocity.x.abs() < 1e-12); // friction is as rigid as ever
    Ok(())
}

/// A body of this mass and these moments that rolls on a point at distance `radius` below it.
fn rolling(
    mass: f64,
    moment: f64,
    radius: f64,
    surface: &Surface<f64>,
) -> Result<(Scene<f64, 6, 6, 1, Mixed>, SMatrix<f64, 6, 6>), Error> {
    let matrix = SMatrix::from_diagonal(&vector![mass, mass, mass, moment, moment, moment]);
    let mut scene = Scene::mixed();
    scene.set_mass(&matrix)?;
    let mut jacobian = SMatrix::zeros();
    for (row, column, entry) in [
        (0, 2, 1.0),
        (1, 0, 1.0),
        (1, 4, -radius),
        (2, 1, 1.0),
        (2, 3, radius),
        (3, 5, 1.0),
        (4, 3, 1.0),
        (5, 4, 1.0),
    ] {
        jacobian[(row, column)] = entry;
    }
    let contact = Contact {
        jacobian,
        offset: SVector::zeros(),
        mu: 0.0,
        key: 0,
    };
    scene.push_on(&contact, surface)?;
    Ok((scene, matrix))
}

#[test]
fn rolling_resistance_stops_a_coin_at_the_distance_of_its_energy() -> Result<(), Error> {
    let (mass, radius, length, speed, step) = (5e-3, 0.012, 1e-4, 0.3, 1e-4);
    let moment = 0.5 * mass * radius * radius;
    let surface = Surface {
        roll: [length; 2],
        spin: 1e-3,
        ..Surface::isotropic(0.8)
    };
    let (scene, matrix) = rolling(mass, moment, radius, &surface)?;
    let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
    let mut velocity = vector![speed, 0.0, 0.0, 0.0, speed / radius, 0.0];
    let mut distance = 0.0;
    while velocity[0] > 1e-9 {
        let mut push = matrix * velocity;
        push[2] -= mass * GRAVITY * step;
        let solution = solver.solve(&scene, &factor, &push, &Settings::new(1e-10))?;
        assert!(
            solution.is_solved(),
            "{:?} {}",
            solution.status,
            solution.error
        );
        velocity = solution.velocity;
        distance += step * velocity[0];
    }
    // (1 + 1/2) m v² / 2 is spent at `length m g / radius` a metre.
    let expected = 0.75 * speed * speed * radius / (length * GRAVITY);
    assert!(
        (distance / expected - 1.0).abs() < 2e-3,
        "{distance} {expected}"
    );
    Ok(())
}

#[test]
fn torsional_friction_stops_a_spinning_ball_at_the_time_of_its_momentum() -> Result<(), Error> {
    let (mass, radius, length, speed, step) = (0.1, 0.02, 2e-3, 20.0, 1e-3);
    let moment = 0.4 * mass * radius * radius;
    let surface = Surface {
        spin: length,
        ..Surface::isotropic(0.5)
    };
    let (scene, matrix) = rolling(mass, moment, radius, &surface)?;
    let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
    let mut velocity = SVector::ith(5, speed);
    let mut time = 0.0;
    while velocity[5] > 1e-9 {
        let mut push = matrix * velocity;
        push[2] -= mass * GRAVITY * step;
        let solution = solver.solve(&scene, &factor, &push, &Settings::new(1e-10))?;
        velocity = solution.velocity;
        time += step;
        // In physical units: a length times the normal impulse.
        let [normal, _, _, torque, ..]: [f64; 6] = solution.contacts[0].impulse.into();
        assert!((torque.abs() - length * normal).abs() < 1e-9 * normal || velocity[5] < 1e-9);
    }
    let expected = moment * speed / (length * mass * GRAVITY);
    assert!((time - expected).abs() < 1.5 * step, "{time} {expected}");
    Ok(())
}

#[test]
fn elliptic_friction_slides_as_maximum_dissipation_says() -> Result<(), Error> {
    let mass = 2.0;
    let mut scene = Scene::<f64, 3, 3, 1, _>::mixed();
    scene.set_mass(&(Matrix3::identity() * mass))?;
    let contact = Contact {
        jacobian: matrix![0.0, 0.0, 1.0; 1.0, 0.0, 0.0; 0.0, 1.0, 0.0],
        offset: SVector::zeros(),
        mu: 0.0,
        key: 0,
    };
    let friction = [0.8, 0.3];
    let surface = Surface {
        friction,
        ..Surface::isotropic(0.0)
    };
    scene.push_on(&contact, &surface)?;
    let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
    let push = vector![0.05, 0.03, -0.02];
    let solution = solver.solve(&scene, &factor, &push, &Settings::new(1e-12))?;
    let found = solution.contacts[0];
    assert_eq!(found.mode, ContactMode::Slip);
    let [normal, x, y] = found.impulse.into();
    let power = |x: f64, y: f64| -(x * found.velocity[1] + y * found.velocity[2]);
    // On the ellipse, and no other impulse there takes as much power.
    assert!(((x / friction[0]).hypot(y / friction[1]) - normal).abs() < 1e-12);
    for k in 0..360 {
        let (sin, cos) = f64::from(k).to_radians().sin_cos();
        let other = power(friction[0] * normal * cos, friction[1] * normal * sin);
        assert!(other <= power(x, y) + 1e-12);
    }
    Ok(())
}

#[test]
fn a_loop_of_redundant_rows_holds_like_one_without() -> Result<(), Error> {
    let solve = |copies: usize| -> Result<SVector<f64, 2>, Error> {
        let mut scene = Scene::<f64, 2, 3, 2, _>::mixed();
        scene.set_mass(&Matrix2::from_diagonal(&vector![1.0, 3.0]))?;
        let row: JointRow<f64, 2> = law::closed_loop(vector![1.0, -2.0], 0.0, 1e-3, 1.0, 0);
        for _ in 0..copies {
            scene.push_row(&row)?;
        }
        let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
        let solution = solver.solve(&scene, &factor, &vector![1.0, 0.5], &Settings::new(1e-10))?;
        assert!(solution.is_solved());
        Ok(solution.velocity)
    };
    let (one, five) = (solve(1)?, solve(5)?);
    assert!((one[0] - 2.0 * one[1]).abs() < 1e-9);
    assert!((one - five).norm() < 1e-9);
    Ok(())
}
