//! What a derivative refuses, and its margin where squares overflow.

use crate::support::sizes::{block, joint};
use nalgebra::{Matrix1, Matrix2, matrix, vector};
use stiction::{Contact, Error, JointRow, RowLaw, Settings, Status};

fn floor(key: u32) -> Contact<f64, 2, 2> {
    Contact { jacobian: matrix![0.0, 1.0; 1.0, 0.0], offset: vector![0.0, 0.0], mu: 0.5, key }
}

/// A block of 2 kg that slides.
fn sliding(settings: &Settings<f64>) -> Result<block::Kernel<f64>, Error> {
    let mut kernel = block::Kernel::new();
    kernel.scene_mut().set_mass(&(Matrix2::identity() * 2.0))?;
    kernel.scene_mut().push(&floor(7))?;
    kernel.solve(&vector![1.0, -0.2], settings)?;
    Ok(kernel)
}

#[test]
fn what_is_not_usable_has_no_derivative() -> Result<(), Error> {
    let settings = Settings::new(1e-9);
    assert!(sliding(&settings)?.derivative(&settings).is_ok());
    let none = Settings { budget: 0, ..settings };
    let early = sliding(&none)?;
    assert_eq!(early.solution().status, Status::OutOfBudget);
    assert_eq!(early.derivative(&none).err(), Some(Error::NoSolution));
    assert!(early.derivative(&Settings::new(early.solution().error)).is_ok()); // who asks for no more
    Ok(())
}

/// A wall in the place of the floor: as many contacts, and another scene.
#[test]
fn a_scene_of_other_contacts_has_no_derivative() -> Result<(), Error> {
    let settings = Settings::new(1e-9);
    let mut kernel = sliding(&settings)?;
    let floor = floor(7);
    for (key, refused) in [(99, Some(Error::NoSolution)), (7, None)] {
        kernel.scene_mut().clear();
        kernel.scene_mut().push(&Contact { key, ..floor.clone() })?;
        kernel.prepare()?;
        assert_eq!(kernel.derivative(&settings).err(), refused);
    }
    Ok(())
}

/// A stop at a lever of 1e-100 m, which is pushed out by an impulse of 1e200 N·m·s.
#[test]
fn a_margin_is_a_number_where_squares_are_none() -> Result<(), Error> {
    let settings = Settings::new(1e-9);
    let mut kernel = joint::Kernel::<f64>::new();
    kernel.scene_mut().set_mass(&Matrix1::new(1.0))?;
    let (row, law) = (vector![1e-100], RowLaw::Limit);
    kernel.scene_mut().push_row(&JointRow { row, offset: -1.0, law, compliance: 0.0, key: 0 })?;
    kernel.solve(&vector![0.0], &settings)?;
    let margin = kernel.derivative(&settings)?.margin();
    assert!((margin - 1.0).abs() < 1e-9, "{margin}"); // the impulse itself
    // A contact at such a lever.
    let mut kernel = block::Kernel::<f64>::new();
    kernel.scene_mut().set_mass(&Matrix2::identity())?;
    let (jacobian, offset) = (matrix![0.0, 1e-100; 0.0, 0.0], vector![-1.0, 0.0]);
    kernel.scene_mut().push(&Contact { jacobian, offset, mu: 0.0, key: 0 })?;
    kernel.solve(&vector![0.0, 0.0], &settings)?;
    let margin = kernel.derivative(&settings)?.margin();
    assert!((margin - 1.0).abs() < 1e-9, "{margin}");
    Ok(())
}
