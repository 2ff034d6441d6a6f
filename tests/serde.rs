//! Solutions, settings and errors survive a way through text and through bytes, bit by bit.

use nalgebra::{Matrix1, Matrix2, matrix, vector};
use serde::Serialize;
use serde::de::DeserializeOwned;
use stiction::time_stepping::Parameter;
use stiction::{
    Contact, Error, Factor, Input, JointRow, Kernel, List, Model, RowLaw, Scene, Settings, Solution, Solver,
    Status,
};

/// What comes back by way of bytes, and if it is all made of numbers of text.
fn back<V: Serialize + DeserializeOwned>(value: &V, is_finite: bool) -> Vec<V> {
    let bytes = postcard::to_stdvec(value).unwrap();
    let mut read = vec![postcard::from_bytes(&bytes).unwrap()];
    if is_finite {
        let text = serde_json::to_string(value).unwrap();
        read.push(serde_json::from_str(&text).unwrap());
    }
    read
}

fn same<const N: usize, const D: usize, const C: usize, const R: usize>(
    solution: &Solution<f64, N, D, C, R>,
) {
    for read in back(solution, solution.error.is_finite()) {
        assert_eq!(read.velocity, solution.velocity);
        assert_eq!(read.contacts, solution.contacts);
        assert_eq!(read.status, solution.status);
        assert_eq!(read.rows, solution.rows);
        assert_eq!(read.certificate, solution.certificate);
        assert_eq!(read.row_certificate, solution.row_certificate);
        assert_eq!(read.work, solution.work);
        assert_eq!(read.error.to_bits(), solution.error.to_bits());
    }
}

#[test]
fn a_solution_is_read_back_as_it_was_written() -> Result<(), Error> {
    let mut scene = Scene::<f64, 2, 2, 1>::new();
    scene.set_mass(&(Matrix2::identity() * 3.0))?;
    let contact =
        Contact { jacobian: matrix![0.0, 1.0; 1.0, 0.0], offset: vector![0.0, 0.0], mu: 0.3, key: 0 };
    assert_eq!(back(&contact, true), [contact.clone(), contact.clone()]);
    scene.push(&contact)?;
    let factor = Factor::new(&scene)?;
    let mut solver = Solver::new();
    same(solver.solution());
    for budget in [0, 1_000] {
        let settings = Settings { budget, model: Model::ConvexRelaxation, ..Settings::new(1e-9) };
        same(solver.solve(&scene, &factor, &vector![0.7, -0.1], &settings)?);
        for read in back(&settings, true) {
            assert_eq!(read, settings);
        }
    }
    Ok(())
}

#[test]
fn a_proof_is_read_back_with_its_infinite_error() -> Result<(), Error> {
    let mut kernel = Kernel::<f64, 1, 1, 2>::new();
    kernel.scene_mut().set_mass(&Matrix1::new(1.0))?;
    for (entry, offset) in [(1.0, -0.3), (-1.0, -0.2)] {
        kernel.scene_mut().push(&Contact {
            jacobian: matrix![entry],
            offset: vector![offset],
            mu: 0.0,
            key: 0,
        })?;
    }
    let solution = kernel.solve(&vector![0.1], &Settings::new(1e-9))?;
    assert_eq!(solution.status, Status::Infeasible);
    assert_eq!(solution.certificate.len(), 2);
    same(solution);
    Ok(())
}

#[test]
fn what_joint_rows_do_is_read_back_and_how_they_contradict_each_other() -> Result<(), Error> {
    let mut kernel = Kernel::<f64, 1, 1, 1, 2>::new();
    kernel.scene_mut().set_mass(&Matrix1::new(0.5))?;
    let mut stop = JointRow { row: vector![1.0], offset: 0.0, law: RowLaw::Limit, compliance: 0.0, key: 7 };
    let (lower, upper) = (-0.5, 0.25);
    let motor = JointRow { law: RowLaw::Box { lower, upper }, ..stop.clone() };
    for row in [&stop, &motor] {
        assert_eq!(back(row, true), [row.clone(), row.clone()]);
    }
    kernel.scene_mut().push_row(&stop)?;
    let solution = kernel.solve(&vector![-1.0], &Settings::new(1e-9))?;
    assert!(solution.rows[0].impulse > 0.9);
    same(solution);
    let read = &back(solution, true)[0];
    assert_eq!(read.row_by_key(7), solution.rows.first());
    // A wall on the other side, which is nearer.
    (stop.row, stop.offset) = (vector![-1.0], -0.5);
    kernel.scene_mut().push_row(&stop)?;
    let solution = kernel.solve(&vector![-1.0], &Settings::new(1e-9))?;
    assert_eq!(solution.status, Status::Infeasible);
    assert_eq!(solution.row_certificate.len(), 2);
    same(solution);
    Ok(())
}

#[test]
fn every_kind_of_error_is_read_back() {
    let (row, list) = (3, List::InitialRowImpulses);
    let parameter = Parameter::Step;
    let input = Input::JointRow { row };
    for error in [
        Error::InvalidPenalty,
        Error::StaleFactor,
        Error::SceneChanged,
        Error::NotFinite { input, row: 1, column: 2 },
        Error::DelassusOutOfRange { contact: 5 },
        Error::RowOutOfRange { key: u32::MAX },
        Error::InvalidBounds { row },
        Error::InvalidRowCompliance { row },
        Error::InvalidLimit { limit: 3 },
        Error::LimitKeyTaken { limit: 3 },
        Error::ListFull { list, capacity: 4 },
        Error::InvalidVelocityCount { velocities: 0, capacity: 30 },
        Error::NoSuchContact { contact: 5 },
        Error::InvalidParameter { parameter },
    ] {
        for read in back(&error, true) {
            assert_eq!(read, error);
        }
    }
}
