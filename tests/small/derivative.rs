//! What a derivative refuses, and its margin where squares overflow.

use crate::support::boxes::planar_floor;
use crate::support::sizes::{block, block_rows, joint};
use nalgebra::{Matrix1, Matrix2, matrix, vector};
use stiction::{Contact, Derivative, Error, JointRow, RowLaw, Settings, Status};

/// A block of 2 kg that slides.
fn sliding(settings: &Settings<f64>) -> Result<block::Kernel<f64>, Error> {
    let mut kernel = block::Kernel::new();
    kernel.scene_mut().set_mass(&(Matrix2::identity() * 2.0))?;
    kernel.scene_mut().push(&planar_floor(0.5, 7))?;
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

/// All that is computed of a solution refuses a scene of which one number has changed since, and takes it when it is as it was.
#[test]
fn what_is_asked_of_a_solution_is_refused_for_another_scene() -> Result<(), Error> {
    type Change = fn(&mut block_rows::Scene<f64>) -> Result<(), Error>;
    let (settings, push) = (Settings::new(1e-9), vector![1.0, -0.2]);
    let row = JointRow { row: vector![1.0, 0.0], offset: -0.1, law: RowLaw::Limit, compliance: 0.0, key: 3 };
    let mut kernel = block_rows::Kernel::new();
    kernel.scene_mut().set_mass(&(Matrix2::identity() * 2.0))?;
    kernel.scene_mut().push(&planar_floor(0.5, 7))?;
    kernel.scene_mut().push_row(&row)?;
    kernel.solve(&push, &settings)?;
    let whole = kernel.scene().clone();
    let changes: [Change; 10] = [
        |scene| scene.set_friction(0, 0.9),
        |scene| scene.set_offset(0, &vector![0.0, 0.1]),
        |scene| scene.set_jacobian(0, &matrix![0.0, 1.0; -1.0, 0.0]),
        |scene| scene.set_mass(&(Matrix2::identity() * 3.0)),
        |scene| scene.set_row_offset(0, 0.1),
        |scene| scene.set_row_law(0, RowLaw::Equality),
        |scene| scene.set_row_compliance(0, 0.1),
        |scene| scene.push(&planar_floor(0.5, 8)).map(drop),
        |scene| scene.remove_row(0),
        |scene| scene.remove_contact(0).and_then(|()| scene.push(&planar_floor(0.5, 99)).map(drop)),
    ];
    for (index, change) in changes.into_iter().enumerate() {
        change(kernel.scene_mut())?;
        kernel.prepare()?;
        let refused = Some(Error::SceneChanged);
        assert_eq!(kernel.derivative(&settings).err(), refused, "{index}");
        assert_eq!(kernel.least_impulses(&settings).err(), refused, "{index}");
        assert_eq!(kernel.slip_reserve(&settings).err(), refused, "{index}");
        assert_eq!(kernel.load_reserve(&push, &settings).err(), refused, "{index}");
        kernel.scene_mut().clear();
        kernel.scene_mut().set_mass(whole.mass())?;
        kernel.scene_mut().push(&planar_floor(0.5, 7))?;
        kernel.scene_mut().push_row(&row)?;
        kernel.prepare()?;
        assert!(kernel.derivative(&settings).is_ok() && kernel.slip_reserve(&settings).is_ok());
        // A solution may be kept and copied, and its scene be built again.
        let (solution, factor) = (kernel.solution().clone(), kernel.factor().clone());
        assert!(Derivative::new(&whole, &factor, &solution, &settings).is_ok());
    }
    Ok(())
}

/// Limits that are reached are no part of the scene; without them the solution is that of the scene.
#[test]
fn a_solution_that_has_reached_a_limit_is_not_that_of_the_scene() -> Result<(), Error> {
    let settings = Settings::new(1e-9);
    let mut kernel = block_rows::Kernel::<f64>::new();
    kernel.scene_mut().set_mass(&Matrix2::identity())?;
    kernel.scene_mut().push(&planar_floor(0.5, 7))?;
    for (offset, refused) in [(-0.1, Some(Error::SceneChanged)), (-9.0, None)] {
        let stop = JointRow {
            row: vector![-1.0, 0.0],
            offset: -offset,
            law: RowLaw::Limit,
            compliance: 0.0,
            key: 0,
        };
        kernel.solve_with_limits(&[stop], &vector![1.0, -0.2], &settings)?;
        assert_eq!(kernel.derivative(&settings).err(), refused);
        kernel.solver_mut().reset(); // a stop that has pushed is asked again
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
