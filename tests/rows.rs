//! Scenes of contacts and joint rows: what is solved, what is proved, what is refused, and what a warm start follows.

use crate::support::sizes::{block_rows, linkage, point_rows};
use nalgebra::{Matrix2, Matrix3, SVector, matrix, vector};
use stiction::time_stepping::{DryFriction, JointLimit};
use stiction::{
    Contact, Error, Factor, Input, JointRow, Kernel, List, Real, RowLaw, RowMode, Scene, Settings, Solver,
    Status, Surface,
};
use testbed::kernel::Answer;
use testbed::mixed::{self, MixedFile, Times};
use testbed::{mixed_measure, scene_file};

/// The bundled scenes with joint rows, compliance or shapes of friction.
fn files() -> Vec<MixedFile> {
    let paths = scene_file::json_files(&scene_file::repository().join("tests/mixed"));
    let read = |path: std::path::PathBuf| mixed::read(&path).expect("it can be read");
    let files: Vec<_> = paths.into_iter().filter_map(read).collect();
    assert_eq!(files.len(), 13);
    files
}

type Solve = fn(&MixedFile, &Settings<f64>, u32) -> Result<(Answer, Times), String>;

/// The largest work of the bundled scenes to a tolerance, all of which are solved, or proved infeasible.
fn work<T: Real>(solve: Solve, tolerance: f64) -> usize {
    let mut most = 0;
    for file in files() {
        let (answer, _) = solve(&file, &Settings::new(tolerance), 1).expect("a size is compiled");
        if file.name.starts_with("infeasible") {
            assert_eq!(answer.status, Status::Infeasible, "{}", file.name);
            let (normals, joints) = (&answer.certificate, &answer.certificate_lambda);
            assert!(mixed_measure::proves(&file, normals, joints), "{}", file.name);
            continue;
        }
        let file = file.rounded::<T>();
        let error = mixed_measure::error(&file, &answer.v, &answer.r, &answer.lambda);
        assert_eq!(answer.status, Status::Solved, "{}: {error:.1e}", file.name);
        assert!(error <= tolerance, "{}: {error:.1e}", file.name);
        assert!(answer.error >= error * 0.99, "{}: {} {error}", file.name, answer.error);
        most = most.max(answer.work.total());
    }
    most
}

#[test]
fn bundled_scenes_are_solved_in_double_precision() {
    assert!(work::<f64>(mixed::solve::<f64>, 1e-9) <= 160);
    assert!(work::<f64>(mixed::solve::<f64>, 1e-4) <= 160);
}

#[test]
fn bundled_scenes_are_solved_in_single_precision() {
    assert!(work::<f32>(mixed::solve::<f32>, 1e-4) <= 130);
}

/// Two bodies in a row, with a row of this law over the first one.
fn row(law: RowLaw<f64>, offset: f64, key: u32) -> JointRow<f64, 2> {
    JointRow { row: vector![1.0, 0.0], offset, law, compliance: 0.0, key }
}

#[test]
fn what_cannot_be_is_refused_by_name() -> Result<(), Error> {
    let mut scene = Scene::<f64, 2, 2, 0, 2>::new();
    scene.set_mass(&Matrix2::identity())?;
    let first = 0;
    let bounds = |lower, upper| RowLaw::Box { lower, upper };
    for law in [bounds(1.0, -1.0), bounds(f64::NAN, 1.0), bounds(0.0, f64::INFINITY)] {
        let refused = scene.push_row(&row(law, 0.0, 0));
        assert_eq!(refused, Err(Error::InvalidBounds { row: first }));
    }
    for compliance in [-1.0, f64::NAN, f64::INFINITY] {
        let soft = JointRow { compliance, ..row(RowLaw::Limit, 0.0, 0) };
        let refused = scene.push_row(&soft);
        assert_eq!(refused, Err(Error::InvalidRowCompliance { row: first }));
    }
    let input = Input::JointRow { row: first };
    let refused = scene.push_row(&row(RowLaw::Limit, f64::NAN, 0));
    let behind = Error::NotFinite { input, row: scene.mass().nrows(), column: 0 };
    assert_eq!(refused, Err(behind));
    assert!(scene.contacts().is_empty() && scene.rows().is_empty());
    let (one, two) =
        (scene.push_row(&row(RowLaw::Limit, 0.0, 0))?, scene.push_row(&row(RowLaw::Equality, 0.0, 1))?);
    assert_eq!((one, two), (0, 1));
    let full = scene.push_row(&row(RowLaw::Limit, 0.0, 2));
    let list = List::Rows;
    assert_eq!(full, Err(Error::ListFull { list, capacity: 2 }));
    let none = 2;
    assert_eq!(scene.set_row_offset(none, 0.0), Err(Error::NoSuchRow { row: none }));
    let refused = scene.set_row_law(two, bounds(2.0, 1.0));
    assert_eq!(refused, Err(Error::InvalidBounds { row: two }));
    Ok(())
}

#[test]
fn a_contact_that_gives_way_backwards_is_refused() -> Result<(), Error> {
    let mut scene = Scene::<f64, 3, 3, 2, 0, 2>::new();
    scene.set_mass(&Matrix3::identity())?;
    let contact = Contact { jacobian: Matrix3::identity(), offset: SVector::zeros(), mu: 0.0, key: 0 };
    let round = Surface::isotropic(0.5);
    let soft = Surface { compliance: [-1.0, 0.0], ..round };
    let refused = scene.push_on(&contact, &soft);
    assert_eq!(refused, Err(Error::InvalidCompliance { contact: 0, row: 0 }));
    let rough = Surface { friction: [0.5, -0.5], ..round };
    let refused = scene.push_on(&contact, &rough);
    assert_eq!(refused, Err(Error::InvalidFriction { contact: 0, row: 2 }));
    Ok(())
}

/// Four joints with friction and stops; rows in this order, some left out.
fn joints(order: &[u32]) -> Result<(linkage::Scene<f64>, Vec<usize>), Error> {
    let mut scene = Scene::new();
    scene.set_mass(&matrix![
        2.0, 0.3, 0.1, 0.0;
        0.3, 1.5, 0.2, 0.1;
        0.1, 0.2, 1.0, 0.3;
        0.0, 0.1, 0.3, 0.8])?;
    let mut places = Vec::new();
    for &key in order {
        let row = SVector::ith(usize::try_from(key / 2).unwrap_or(0), 1.0);
        places.push(scene.push_row(&if key % 2 == 0 {
            let torque = 100.0 * f64::from(1 + key);
            DryFriction { torque }.row(row, 1e-3, key)?
        } else {
            let stop = JointLimit { distance: 1e-4, recovery: 0.1, reach: 10.0 };
            stop.row(row, 1e-3, key)?
        })?);
    }
    Ok((scene, places))
}

#[test]
fn a_warm_start_follows_joint_rows_by_key() -> Result<(), Error> {
    let push = vector![-2.0, 1.0, -1.5, -1.0];
    let settings = Settings::new(1e-10);
    let (scene, places) = joints(&[0, 1, 2, 3, 4, 5, 6, 7])?;
    let mut solver = Solver::new();
    let cold = solver.solve(&scene, &Factor::new(&scene)?, &push, &settings)?;
    assert!(cold.is_solved() && cold.work.total() > 0);
    let impulses: Vec<_> = places.iter().map(|&row| cold.rows[row]).collect();
    // In another order each row finds its impulse, and there is nothing to be done.
    let order = [7, 2, 5, 0, 3, 6, 1, 4];
    let (scene, places) = joints(&order)?;
    let warm = solver.solve(&scene, &Factor::new(&scene)?, &push, &settings)?;
    assert!(warm.is_solved());
    assert_eq!(warm.work.total(), 0);
    for (place, key) in places.iter().zip(order) {
        let row = warm.rows[*place];
        assert_eq!(row.key, key);
        let last = impulses[usize::try_from(key).expect("small")];
        assert!((row.impulse - last.impulse).abs() < 1e-9);
        assert_eq!(row.mode, last.mode);
    }
    // Open ones may go.
    let open = |row: &usize| warm.rows[*row].mode == RowMode::Open;
    let closed = places.iter().zip(order).filter(|(row, _)| !open(row));
    let left: Vec<u32> = closed.map(|(_, key)| key).collect();
    assert!(left.len() < 8);
    let (scene, _) = joints(&left)?;
    let warm = solver.solve(&scene, &Factor::new(&scene)?, &push, &settings)?;
    assert_eq!((warm.status, warm.work.total()), (Status::Solved, 0));
    Ok(())
}

#[test]
fn limits_that_close_on_each_other_are_proved_infeasible_and_rubber_ones_give_way() -> Result<(), Error> {
    for compliance in [0.0, 0.5] {
        let mut scene = Scene::<f32, 2, 3, 0, 2>::new();
        scene.set_mass(&Matrix2::identity())?;
        for (key, sign) in [(0, 1.0), (1, -1.0)] {
            scene.push_row(&JointRow {
                row: vector![sign, 0.0],
                offset: -0.2,
                law: RowLaw::Limit,
                compliance,
                key,
            })?;
        }
        let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
        let solution = solver.solve(&scene, &factor, &vector![0.1, 0.3], &Settings::new(1e-4))?;
        let proof = &solution.row_certificate;
        if compliance == 0.0 {
            assert_eq!(solution.status, Status::Infeasible);
            assert_eq!(proof.len(), 2);
            assert!(proof[0] > 0.0 && (proof[0] - proof[1]).abs() < 1e-6 * proof[0]);
        } else {
            assert!(solution.is_solved());
            assert!(proof.is_empty() && solution.certificate.is_empty());
        }
    }
    Ok(())
}

/// Of impulses of 1e45 even a bad error is less than that of none, relative to them.
#[test]
fn impulses_of_a_glitch_are_no_start() -> Result<(), Error> {
    let mut kernel = point_rows::Kernel::<f64>::new();
    let scene = kernel.scene_mut();
    let root: Matrix3<f64> = matrix![
        0.819_426_827_225_430_7, -0.387_975_774_545_407_9, -0.117_006_683_884_221_08;
        0.0, -0.971_305_119_639_388_9, 0.243_492_048_874_153_9;
        0.0, 0.0, -0.893_741_945_225_507];
    let root = root + root.transpose() - Matrix3::from_diagonal(&root.diagonal());
    scene.set_mass(&(root * root.transpose() + Matrix3::identity() * (root.norm_squared() * 0.01)))?;
    let contact = |jacobian, mu| Contact { jacobian, offset: vector![0.0, 0.0, 0.0], mu, key: 0 };
    let stands = matrix![-0.591, 1.424, 0.0; 0.943, 0.0, 1.074; 0.207, -0.928, 0.054];
    scene.push(&contact(stands, 1.17))?;
    let row = |row, bounds: [f64; 2], compliance| JointRow {
        row,
        offset: 0.0,
        law: RowLaw::Box { lower: bounds[0], upper: bounds[1] },
        compliance,
        key: 0,
    };
    scene.push_row(&row(vector![0.0, -0.876, 0.0], [0.0, 0.609], 0.217))?;
    let other = matrix![0.640, 1.816, -0.828; -1.969, 0.774, -1.0; 0.832, 0.0, 1.517];
    scene.push(&contact(other, 1.5))?;
    scene.push_row(&row(vector![-1.0, 1.031, 1.181], [-0.75, 0.0], 0.0))?;
    let tick = Settings::new(1e-9);
    let short = Settings { budget: 1, ..tick };
    let glitch = vector![1e45, -1e45, 1.7e43];
    assert_eq!(kernel.solve(&glitch, &short)?.status, Status::OutOfBudget);
    let solution = kernel.solve(&vector![0.0, 1.84, 0.0], &tick)?;
    assert!(solution.is_solved() && solution.work.total() < 20, "{:?}", solution.work);
    Ok(())
}

/// Rows that nothing moves say what they are all the same.
#[test]
fn a_row_that_nothing_moves_has_the_mode_of_its_law() -> Result<(), Error> {
    let still = |law, offset| JointRow { row: SVector::zeros(), ..row(law, offset, 0) };
    let motor = RowLaw::Box { lower: -1.0, upper: 2.0 };
    for (law, offset, mode) in [
        (RowLaw::Limit, 0.5, RowMode::Open),
        (RowLaw::Equality, 0.0, RowMode::Holding),
        (motor, 0.3, RowMode::Holding),
    ] {
        let mut kernel = block_rows::Kernel::<f64>::new();
        kernel.scene_mut().set_mass(&Matrix2::identity())?;
        let index = kernel.scene_mut().push_row(&still(law, offset))?;
        let solution = kernel.solve(&vector![1.0, 1.0], &Settings::new(1e-9))?;
        let found = solution.rows[index];
        assert!(solution.is_solved());
        assert_eq!((found.impulse, found.mode), (0.0, mode));
    }
    Ok(())
}

#[test]
fn a_joint_row_is_no_contact_to_be_changed() -> Result<(), Error> {
    let mut scene = block_rows::Scene::<f64>::new();
    scene.set_mass(&Matrix2::identity())?;
    scene.push_row(&row(RowLaw::Limit, 0.0, 0))?;
    let before = scene.rows().to_vec();
    let refused = Err(Error::NoSuchContact { contact: 0 });
    assert_eq!(scene.set_friction(0, 0.5), refused);
    assert_eq!(scene.set_offset(0, &vector![1.0, 1.0]), refused);
    assert_eq!(scene.set_jacobian(0, &Matrix2::identity()), refused);
    assert_eq!(scene.remove_contact(0), refused);
    assert!(scene.contacts().is_empty());
    assert_eq!(scene.rows(), before);
    Ok(())
}

/// Impulses that somebody else has found, by key, those of joint rows apart from those of contacts.
#[test]
fn a_solve_starts_at_impulses_of_joint_rows_that_are_given() -> Result<(), Error> {
    let push = vector![-2.0, 1.0, -1.5, -1.0];
    let settings = Settings::new(1e-10);
    let (scene, _) = joints(&[0, 1, 2, 3, 4, 5, 6, 7])?;
    let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
    let cold = solver.solve(&scene, &factor, &push, &settings)?.clone();
    assert!(cold.is_solved() && cold.work.total() > 0);
    let mut given: Vec<_> = cold.rows.iter().map(|row| (row.key, row.impulse)).collect();
    given.reverse();
    solver.reset();
    solver.set_impulses(&[], &given)?;
    let warm = solver.solve(&scene, &factor, &push, &settings)?;
    assert_eq!((warm.status, warm.work.total()), (Status::Solved, 0));
    assert!((warm.velocity - cold.velocity).norm() < 1e-9);
    // What is refused changes nothing.
    let capacity = 8;
    for (contacts, rows, list, capacity) in [
        (vec![], vec![(0, 0.0); 9], List::InitialRowImpulses, capacity),
        (vec![(0, SVector::zeros())], vec![], List::InitialImpulses, 0),
    ] {
        let refused = solver.set_impulses(&contacts, &rows);
        assert_eq!(refused, Err(Error::ListFull { list, capacity }));
    }
    let refused = solver.set_impulses(&[], &[(0, 1.0), (1, f64::INFINITY)]);
    let input = Input::InitialRowImpulse { row: 1 };
    assert!(matches!(refused, Err(Error::NotFinite { input: found, .. }) if found == input));
    let warm = solver.solve(&scene, &factor, &push, &settings)?;
    assert_eq!((warm.status, warm.work.total()), (Status::Solved, 0));
    Ok(())
}
