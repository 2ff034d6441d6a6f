//! Solutions, settings and errors survive a way through text and through bytes, bit by bit.

use nalgebra::{Matrix1, Matrix2, matrix, vector};
use serde::Serialize;
use serde::de::DeserializeOwned;
use stiction::time_stepping::Parameter;
use stiction::{
    Contact, Error, Factor, Input, JointRow, Kernel, Mixed, Model, RowIndex, RowLaw, Scene,
    Settings, Solution, Solver, Status,
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

fn same<const N: usize, const D: usize, const C: usize>(solution: &Solution<f64, N, D, C>) {
    for read in back(solution, solution.error.is_finite()) {
        assert_eq!(read.velocity, solution.velocity);
        assert_eq!(read.contacts, solution.contacts);
        assert_eq!(read.status, solution.status);
        assert_eq!(read.certificate, solution.certificate);
        assert_eq!(read.work, solution.work);
        assert_eq!(read.error.to_bits(), solution.error.to_bits());
    }
}

#[test]
fn a_solution_is_read_back_as_it_was_written() -> Result<(), Error> {
    let mut scene = Scene::<f64, 2, 2, 1>::new();
    scene.set_mass(&(Matrix2::identity() * 3.0))?;
    scene.push(&Contact {
        jacobian: matrix![0.0, 1.0; 1.0, 0.0],
        offset: vector![0.0, 0.0],
        mu: 0.3,
        key: 0,
    })?;
    let factor = Factor::new(&scene)?;
    let mut solver = Solver::new();
    same(solver.solution());
    for budget in [0, 1_000] {
        let settings = Settings {
            budget,
            model: Model::ConvexRelaxation,
            ..Settings::new(1e-9)
        };
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

/// What joint rows do is left out, and whoever asks is told of none.
#[test]
fn of_joint_rows_nothing_false_is_read() -> Result<(), Error> {
    let mut kernel = Kernel::<f64, 1, 1, 1, Mixed>::mixed();
    kernel.scene_mut().set_mass(&Matrix1::new(0.5))?;
    let stop = kernel.scene_mut().push_row(&JointRow {
        row: vector![1.0],
        offset: 0.0,
        law: RowLaw::Limit,
        compliance: 0.0,
        key: 0,
    })?;
    let solution = kernel.solve(&vector![-1.0], &Settings::new(1e-9))?;
    assert!(solution.row(stop).is_some());
    let bytes = postcard::to_stdvec(solution).unwrap();
    let read: Solution<f64, 1, 1, 1, Mixed> = postcard::from_bytes(&bytes).unwrap();
    assert_eq!(
        (read.status, read.velocity),
        (solution.status, solution.velocity)
    );
    assert!(read.row(stop).is_none() && read.row_by_key(0).is_none());
    Ok(())
}

#[test]
fn every_kind_of_error_is_read_back() {
    let row = RowIndex { slot: 3, row: 1 };
    let parameter = Parameter::Step;
    let input = Input::JointRow { row };
    for error in [
        Error::InvalidPenalty,
        Error::StaleFactor,
        Error::NotFinite {
            input,
            row: 1,
            column: 2,
        },
        Error::DelassusOutOfRange { contact: 5 },
        Error::RowOutOfRange { key: u32::MAX },
        Error::InvalidBounds { row },
        Error::InvalidParameter { parameter },
    ] {
        for read in back(&error, true) {
            assert_eq!(read, error);
        }
    }
}
