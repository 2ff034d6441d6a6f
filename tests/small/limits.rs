//! Limits that stay out of `W` until they are reached.

use super::jams::wedge;
use crate::support::random::{draws, numbers};
use crate::support::sizes::{body_rows, joints};
use nalgebra::{Matrix2, SVector, matrix, vector};
use stiction::{
    Contact, Error, Factor, Input, JointRow, Kernel, List, RowLaw, RowMode, Scene, Settings, Solver, Status,
};
use testbed::scene_file::{self, SceneFile};

const N: usize = 18;

/// A limit of one velocity, from below with `sign` 1.
fn limit<const K: usize>(dof: usize, sign: f64, offset: f64, key: u32) -> JointRow<f64, K> {
    let mut row = SVector::zeros();
    row[dof] = sign;
    JointRow { row, offset, law: RowLaw::Limit, compliance: 0.0, key }
}

/// The steps of a trotting quadruped, each with a limit for each of its twelve joints, of which its free gait violates two.
fn trot() -> Vec<(SceneFile, Vec<JointRow<f64, N>>)> {
    let path = scene_file::repository().join("tests/sequences/go2_trot.json");
    let steps = scene_file::read(&path).expect("it can be read");
    let mut solver = Solver::<f64, N, 3, 12>::new();
    let with_limits = steps.into_iter().map(|step| {
        let scene = step.scene().expect("it is sound");
        let factor = Factor::new(&scene).expect("it is sound");
        let push = step.free_impulse();
        let solution = solver.solve(&scene, &factor, &push, &Settings::new(1e-11));
        let v = solution.expect("it is sound").velocity;
        let limits = (6..18).zip(0..).map(|(dof, key)| {
            let sign = if v[dof] > 0.0 { -1.0 } else { 1.0 };
            let spare = if key % 6 == 2 { -0.05 } else { 1.0 };
            limit(dof, sign, spare - sign * v[dof], key)
        });
        (step, limits.collect())
    });
    with_limits.collect()
}

fn fill<const R: usize>(scene: &mut Scene<f64, N, 3, 5, R>, step: &SceneFile) -> Result<(), Error> {
    let source = step.scene::<f64, N, 3, 5>()?;
    scene.set_mass(source.mass())?;
    scene.clear();
    for contact in source.contacts() {
        scene.push(contact)?;
    }
    Ok(())
}

#[test]
fn what_is_left_out_is_kept_and_changes_nothing() -> Result<(), Error> {
    let settings = Settings::new(1e-9);
    let (mut lazy, mut whole) = (Kernel::<_, N, 3, 5, 6>::new(), Kernel::<_, N, 3, 5, 12>::new());
    let (mut reached, mut work) = (0, [0; 2]);
    for (step, limits) in trot() {
        fill(lazy.scene_mut(), &step)?;
        fill(whole.scene_mut(), &step)?;
        for row in &limits {
            whole.scene_mut().push_row(row)?;
        }
        let push = step.free_impulse();
        let (few, all) = (lazy.solve_with_limits(&limits, &push, &settings)?, whole.solve(&push, &settings)?);
        assert!(few.is_solved() && all.is_solved(), "{}", step.name);
        assert!((few.velocity - all.velocity).norm() < 1e-7 * all.velocity.norm());
        for row in &limits {
            let speed = row.row.dot(&few.velocity) + row.offset;
            match few.row_by_key(row.key) {
                Some(found) => {
                    assert!(speed > -1e-7, "{}: {speed}", step.name);
                    reached += usize::from(found.mode == RowMode::AtLimit);
                }
                None => assert!(speed >= 0.0),
            }
        }
        work[0] += few.work.total();
        work[1] += all.work.total();
    }
    assert_eq!(reached, 80); // two in each of 40 steps
    assert!(work[0] <= work[1] * 11 / 10, "{work:?}");
    Ok(())
}

/// Two bodies of 1 kg, the first one over a floor.
fn pair() -> Result<joints::Kernel<f64>, Error> {
    let mut kernel = Kernel::new();
    kernel.scene_mut().set_mass(&Matrix2::identity())?;
    kernel.scene_mut().push(&Contact {
        jacobian: matrix![1.0, 0.0],
        offset: vector![0.0],
        mu: 0.0,
        key: 0,
    })?;
    Ok(kernel)
}

#[test]
fn a_scene_is_afterwards_what_it_was() -> Result<(), Error> {
    let (push, settings) = (vector![-1.0, -1.0], Settings::new(1e-9));
    let (mut kernel, mut fresh) = (pair()?, pair()?);
    let limits = [limit(1, 1.0, 0.25, 0), limit(1, -1.0, 3.0, 1)];
    let solution = kernel.solve_with_limits(&limits, &push, &settings)?;
    assert!((solution.velocity - vector![0.0, -0.25]).norm() < 1e-9);
    assert_eq!(solution.row_by_key(0).map(|row| row.mode), Some(RowMode::AtLimit));
    assert_eq!(solution.row_by_key(1), None);
    let scene = kernel.scene();
    assert_eq!((scene.contacts().len(), scene.rows().len()), (1, 0));
    kernel.solver_mut().reset();
    let (again, alone) = (kernel.solve(&push, &settings)?, fresh.solve(&push, &settings)?);
    assert_eq!((again.velocity, again.work), (alone.velocity, alone.work));
    assert_eq!(again.velocity, vector![0.0, -1.0]);
    Ok(())
}

#[test]
fn a_limit_that_a_contact_pushes_onto_is_found_on_the_way() -> Result<(), Error> {
    // The floor pushes the pair apart; the free motion violates no limit.
    let mut kernel = joints::Kernel::<f64>::new();
    kernel.scene_mut().set_mass(&matrix![2.0, -1.0; -1.0, 2.0])?;
    let (jacobian, offset) = (matrix![1.0, 0.0], vector![0.0]);
    kernel.scene_mut().push(&Contact { jacobian, offset, mu: 0.0, key: 0 })?;
    let limits = [limit(1, -1.0, 0.25, 7)];
    let push = vector![-3.0, 1.5];
    for tick in 0..2 {
        let solution = kernel.solve_with_limits(&limits, &push, &Settings::new(1e-9))?;
        assert!(solution.is_solved());
        assert!((solution.velocity - vector![0.0, 0.25]).norm() < 1e-8);
        assert_eq!(solution.work.total() == 0, tick == 1, "the second starts at the first");
    }
    Ok(())
}

#[test]
fn a_budget_is_that_of_all_and_nothing_is_solved_that_violates_a_limit() -> Result<(), Error> {
    let (mut ended, mut solved) = (0, 0);
    for (step, limits) in trot().iter().step_by(5) {
        for budget in [0, 1, 2, 3, 5, 8, 13, 21, 34, 55, 89] {
            let mut kernel = Kernel::<_, N, 3, 5, 6>::new();
            fill(kernel.scene_mut(), step)?;
            let settings = Settings { budget, ..Settings::new(1e-6) };
            let push = step.free_impulse();
            let solution = kernel.solve_with_limits(limits, &push, &settings)?;
            assert!(solution.work.total() <= budget + 19);
            let speeds = limits.iter().map(|row| row.row.dot(&solution.velocity) + row.offset);
            let least = speeds.fold(f64::INFINITY, f64::min);
            if solution.is_solved() {
                assert!(least > -1e-5, "{least}");
                solved += 1;
            } else {
                assert_eq!(solution.status, Status::OutOfBudget);
                let known = |row: &JointRow<f64, N>| solution.row_by_key(row.key).is_some();
                let left_out = limits.iter().filter(|row| !known(row));
                let kept = |row: &JointRow<f64, N>| row.row.dot(&solution.velocity) + row.offset >= 0.0;
                assert!(left_out.clone().all(kept), "its error knows of all that is violated");
                ended += 1;
            }
        }
    }
    assert!(ended > 5 && solved > 5, "{ended} {solved}");
    Ok(())
}

/// A body that is pushed with 3 N·s against a wall and against a stop, which share the push: in a row of the scene as in a list.
#[test]
fn a_wall_and_a_stop_share_a_push() -> Result<(), Error> {
    let (settings, push) = (Settings::new(1e-9), vector![3.0, 0.0]);
    let limits = [limit(1, 1.0, 1.0, 1), limit(0, -1.0, 0.0, 7)];
    let least = |lazy: bool| {
        let mut kernel = joints::Kernel::<f64>::new();
        let scene = kernel.scene_mut();
        scene.set_mass(&(Matrix2::identity() * 2.0))?;
        scene.push(&Contact { jacobian: matrix![-1.0, 0.0], offset: vector![0.0], mu: 0.0, key: 0 })?;
        let least = if lazy {
            kernel.solve_with_limits(&limits, &push, &settings)?;
            let others = [limit(1, 1.0, 1.0, 1), limit(0, -1.0, 0.1, 7)];
            let changed = kernel.least_impulses_with_limits(&others, &settings);
            assert_eq!(changed.err(), Some(Error::SceneChanged));
            let least = kernel.least_impulses_with_limits(&limits, &settings)?;
            assert!(kernel.scene().rows().is_empty() && kernel.least_impulses(&settings).is_err());
            least
        } else {
            scene.push_row(&limits[1])?;
            kernel.solve(&push, &settings)?;
            kernel.least_impulses(&settings)?
        };
        assert!(least.momentum_error < 1e-9);
        Ok([least.contacts[0][0], least.rows[0]])
    };
    for share in least(true)?.into_iter().chain(least(false)?) {
        assert!((share - 1.5).abs() < 1e-9, "{share}");
    }
    Ok(())
}

#[test]
fn limits_that_close_on_each_other_are_proved_infeasible() -> Result<(), Error> {
    let mut kernel = pair()?;
    let limits = [limit(1, 1.0, -0.5, 3), limit(0, 1.0, 9.0, 4), limit(1, -1.0, 0.25, 5)];
    let solution = kernel.solve_with_limits(&limits, &vector![0.0, 0.0], &Settings::new(1e-9))?;
    assert_eq!(solution.status, Status::Infeasible);
    let rows = || solution.rows.iter().zip(&solution.row_certificate);
    let proof = |key: u32| rows().find(|(row, _)| row.key == key).map_or(0.0, |(_, &d)| d);
    let (lower, upper) = (proof(3), proof(5));
    assert!(lower > 0.0 && (lower - upper).abs() < 1e-9 * lower && proof(4) == 0.0);
    Ok(())
}

#[test]
fn what_cannot_be_is_refused_by_name_and_the_scene_stays() -> Result<(), Error> {
    let (mut kernel, settings) = (pair()?, Settings::new(1e-9));
    let sound = limit(1, 1.0, 0.25, 0);
    let mut refused = |limits: &[JointRow<f64, 2>], push: [f64; 2]| {
        let error = kernel.solve_with_limits(limits, &push.into(), &settings).err();
        let scene = kernel.scene();
        assert_eq!((scene.contacts().len(), scene.rows().len()), (1, 0));
        error
    };
    let not_finite = |input, row| Some(Error::NotFinite { input, row, column: 0 });
    let broken = limit(1, f64::NAN, 0.25, 1);
    let limits = [sound.clone(), broken];
    assert_eq!(refused(&limits, [0.0, 0.0]), not_finite(Input::Limit { limit: 1 }, 1));
    let endless = [limit(1, 1.0, f64::INFINITY, 0)];
    assert_eq!(refused(&endless, [0.0, 0.0]), not_finite(Input::Limit { limit: 0 }, 2));
    assert_eq!(refused(&[], [0.0, f64::NAN]), not_finite(Input::FreeImpulse, 1));
    let taken = Some(Error::LimitKeyTaken { limit: 2 });
    let twice = [sound, limit(0, 1.0, 1.0, 1), limit(0, -1.0, 1.0, 1)];
    assert_eq!(refused(&twice, [0.0, 0.0]), taken);
    let many = [0, 1, 2, 3, 4].map(|key| limit(1, 1.0, 0.25, key));
    let boxes = many.map(|row| JointRow { law: RowLaw::Box { lower: -1.0, upper: 1.0 }, ..row });
    let full = Some(Error::ListFull { list: List::Rows, capacity: 4 });
    assert_eq!(refused(&boxes, [0.0, 0.0]), full); // there is room for four
    Ok(())
}

/// Five stops and room for four: those at the end of the list are left out, which the status says, and the error measures.
#[test]
fn stops_without_room_are_left_out_and_counted() -> Result<(), Error> {
    let mut kernel = joints::Kernel::<f64>::new();
    kernel.scene_mut().set_mass(&matrix![1.0, 0.0; 0.0, 2.0])?;
    let limits = [0, 0, 0, 0, 1].map(|dof| limit(dof, 1.0, 0.0, 0));
    let limits: Vec<_> = (0..).zip(limits).map(|(key, limit)| JointRow { key, ..limit }).collect();
    let settings = Settings::new(1e-9);
    for tiny in [1e-3, 1e-1] {
        let solution = kernel.solve_with_limits(&limits, &vector![-1.0, -tiny], &settings)?;
        assert_eq!(solution.status, Status::OutOfRows);
        assert!((solution.velocity - vector![0.0, -tiny / 2.0]).norm() < 1e-9);
        let size = solution.rows.iter().fold(tiny, |size, row| size.hypot(row.impulse));
        assert!((solution.error - tiny / size).abs() < 1e-9);
        assert!(solution.is_usable(1.01 * tiny / size) && !solution.is_usable(0.99 * tiny / size));
        assert!(!solution.is_solved());
    }
    // In pieces as well.
    while !kernel.advance_with_limits(&limits, &vector![-1.0, -0.1], &Settings { budget: 1, ..settings })? {}
    assert_eq!(kernel.solution().status, Status::OutOfRows);
    assert!(kernel.solve_with_limits(&limits, &vector![-1.0, 0.5], &settings)?.is_solved());
    Ok(())
}

/// Two stops and room for one row: that of the last tick must not keep out the one that is reached now.
#[test]
fn a_stop_that_is_left_makes_room_for_another() -> Result<(), Error> {
    let mut kernel = Kernel::<f64, 2, 1, 0, 1>::new();
    kernel.scene_mut().set_mass(&Matrix2::identity())?;
    let limits = [limit(0, 1.0, 0.0, 0), limit(1, 1.0, 0.0, 1)];
    let settings = Settings::new(1e-9);
    for tick in 0..6 {
        let free = if tick % 2 == 0 { vector![-1.0, 0.5] } else { vector![0.5, -1.0] };
        let solution = kernel.solve_with_limits(&limits, &free, &settings)?;
        assert!(solution.is_solved());
        assert!((solution.velocity - free.sup(&SVector::zeros())).norm() < 1e-9);
    }
    // Both: there is no room, and what was found with one of them is no solution of the other.
    let full = kernel.solve_with_limits(&limits, &vector![-1.0, -1.0], &settings)?;
    assert!(full.status == Status::OutOfRows && !full.is_usable(0.5));
    let solution = kernel.solve_with_limits(&limits, &vector![-1.0, 0.5], &settings)?;
    assert!(solution.is_solved());
    Ok(())
}

/// A lever: the first stop throws it onto the second, for which there is no room.
#[test]
fn a_stop_that_another_one_hits_is_left_out_and_counted() -> Result<(), Error> {
    let mut kernel = Kernel::<f64, 2, 1, 0, 1>::new();
    kernel.scene_mut().set_mass(&matrix![2.0, 1.0; 1.0, 2.0])?;
    let limits = [limit(0, 1.0, 0.0, 0), limit(1, 1.0, 0.0, 1)];
    let settings = Settings::new(1e-9);
    let solution = kernel.solve_with_limits(&limits, &vector![2.0, 2.0], &settings)?;
    assert!(solution.is_solved());
    let full = kernel.solve_with_limits(&limits, &vector![-1.0, -0.25], &settings)?;
    assert!(full.status == Status::OutOfRows && !full.is_usable(0.1));
    Ok(())
}

#[test]
fn a_limit_that_is_refused_is_named() -> Result<(), Error> {
    let mut kernel = joints::Kernel::<f64>::new();
    kernel.scene_mut().set_mass(&Matrix2::identity())?;
    let mut limits = [limit(0, 1.0, 1.0, 0), limit(1, 1.0, 1.0, 1)];
    limits[1].compliance = -1.0;
    let settings = Settings::new(1e-9);
    let refused = kernel.solve_with_limits(&limits, &vector![0.0, 0.0], &settings);
    assert_eq!(refused.err(), Some(Error::InvalidLimit { limit: 1 }));
    limits[1].compliance = 0.0;
    limits[1].law = RowLaw::Box { lower: 1.0, upper: -1.0 };
    let refused = kernel.solve_with_limits(&limits, &vector![0.0, 0.0], &settings);
    assert_eq!(refused.err(), Some(Error::InvalidLimit { limit: 1 }));
    Ok(())
}

/// A row of the scene is not to be mistaken for a limit.
#[test]
fn a_limit_does_not_take_the_key_of_a_row_of_the_scene() -> Result<(), Error> {
    let (mut kernel, settings) = (pair()?, Settings::new(1e-9));
    kernel.scene_mut().push_row(&limit(0, 1.0, 1.0, 7))?;
    let limits = [6, 7].map(|key| limit(1, 1.0, 0.25, key));
    let refused = kernel.solve_with_limits(&limits, &vector![0.0, 0.0], &settings);
    assert_eq!(refused.err(), Some(Error::LimitKeyTaken { limit: 1 }));
    Ok(())
}

/// Wedges with limits of random rows: a jam or a contradiction of all rows is found with limits, too, at the latest by a second call. (The search
/// for a jam begins at impulses, which differ: one of 100 is missed.)
#[test]
fn a_jam_is_proved_with_limits_as_with_joint_rows() -> Result<(), Error> {
    let (mut jams, mut late, mut missed, settings) = (0, 0, 0, Settings::new(1e-6));
    for x in draws(numbers(24), 100) {
        let (scene, push) = wedge::<f64>(0.26 + 0.24 * x[0], (32.0 + 30.0 * x[1]).to_radians())?;
        let limits = [0, 1, 2].map(|k| {
            let (row, offset) = (SVector::from_column_slice(&x[7 * k + 2..7 * k + 8]), 0.1 * x[7 * k + 8]);
            JointRow { row, offset, ..limit(0, 1.0, 0.0, [0, 1, 2][k]) }
        });
        let limits = &limits[..if x[23] > 0.0 { 3 } else { 1 }];
        let (mut lazy, mut whole) = (body_rows::Kernel::new(), body_rows::Kernel::new());
        *lazy.scene_mut() = scene.clone();
        *whole.scene_mut() = scene.clone();
        limits.iter().try_for_each(|row| whole.scene_mut().push_row(row).map(drop))?;
        let is_proved = |status| matches!(status, Status::Jammed | Status::Infeasible);
        let all = whole.solve(&push, &settings)?;
        let mut few = lazy.solve_with_limits(limits, &push, &settings)?;
        jams += usize::from(few.status == Status::Jammed);
        if is_proved(all.status) && !is_proved(few.status) {
            late += 1;
            few = lazy.resume_with_limits(limits, &push, &settings)?;
            if !is_proved(few.status) {
                missed += 1;
                continue;
            }
        }
        assert_eq!(all.is_solved(), few.is_solved());
        if is_proved(all.status) || is_proved(few.status) {
            let proof = &few.certificate;
            let (mut force, mut approach, mut size) = (SVector::zeros(), 0.0, 0.0);
            for (contact, d) in scene.contacts().iter().zip(proof) {
                force += contact.jacobian.transpose() * d;
                (approach, size) = (approach - contact.offset.dot(d), size + d.norm());
                assert!(d[1].hypot(d[2]) <= contact.mu * d[0] * (1.0 + 1e-12));
            }
            for (row, &d) in few.rows.iter().zip(&few.row_certificate) {
                let limit = limits.iter().find(|limit| limit.key == row.key).expect("one of them");
                force += limit.row * d;
                (approach, size) = (approach - limit.offset * d, size + d);
                assert!(d >= 0.0);
            }
            assert!(proof.len() == 8 && few.row_certificate.len() == few.rows.len());
            assert!(force.norm() <= 1e-13 * size && approach > 1e-4 * size, "{:?}", few.status);
        }
    }
    assert!(jams > 40 && late < 5 && missed < 2, "{jams} {late} {missed}");
    Ok(())
}

/// A solve with limits trusts a factor that it has just computed, and the next one does not. It saves sums, and shows in `Debug` alone.
#[test]
fn a_new_factor_is_trusted_once_with_limits() -> Result<(), Error> {
    let (limits, push, settings) = ([limit(1, 1.0, 0.25, 0)], vector![-1.0, -1.0], Settings::new(1e-9));
    for call in 0..3 {
        let mut kernel = pair()?;
        for age in ["factor_age: New", "factor_age: Old"] {
            match call {
                0 => kernel.solve_with_limits(&limits, &push, &settings).map(drop)?,
                1 => kernel.resume_with_limits(&limits, &push, &settings).map(drop)?,
                _ => while !kernel.advance_with_limits(&limits, &push, &settings)? {},
            }
            assert!(kernel.solution().is_solved());
            assert!(format!("{:?}", kernel.solver()).contains(age), "{call}: {age}");
        }
    }
    Ok(())
}
