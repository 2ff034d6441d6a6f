//! What was once called solved, or Open, and was not: found by reasoning where fuzzing had not been.

use nalgebra::{Matrix1, Matrix2, Matrix3, SVector, matrix, vector};
use stiction::{
    Contact, Error, JointRow, Kernel, RowIndex, RowLaw, RowMode, Scene, Settings, Status,
};
use testbed::measure::{Law, error_of};

fn row<T: stiction::Real, const N: usize>(
    row: SVector<T, N>,
    offset: T,
    law: RowLaw<T>,
    key: u32,
) -> JointRow<T, N> {
    JointRow {
        row,
        offset,
        law,
        compliance: T::ZERO,
        key,
    }
}

fn normal<T: stiction::Real, const N: usize>(
    jacobian: SVector<T, N>,
    offset: T,
) -> Contact<T, N, 1> {
    Contact {
        jacobian: jacobian.transpose(),
        offset: vector![offset],
        mu: T::ZERO,
        key: 0,
    }
}

/// The impulse of a motor that moves nothing is no size to compare others with.
#[test]
fn a_row_that_nothing_moves_loosens_nothing() -> Result<(), Error> {
    let mut kernel = Kernel::<f64, 1, 1, 2, _>::mixed();
    let scene = kernel.scene_mut();
    scene.set_mass(&Matrix1::new(1.0))?;
    scene.push_row(&row(vector![1.0], 0.0, RowLaw::Limit, 0))?;
    let motor = RowLaw::Box {
        lower: 1e5,
        upper: 1e5,
    };
    scene.push_row(&row(vector![0.0], 0.0, motor, 1))?;
    for (push, velocity) in [(1.0, 1.0), (-1.0, 0.0)] {
        let solution = kernel.solve(&vector![push], &Settings::new(1e-4))?;
        assert!(solution.is_solved());
        assert!((solution.velocity[0] - velocity).abs() < 1e-3);
    }
    Ok(())
}

#[test]
fn a_delassus_operator_of_too_high_a_rank_is_refused() -> Result<(), Error> {
    let mut scene = Scene::<f32, 1, 1, 2>::new();
    scene.push(&normal(vector![0.0], -1.0))?;
    scene.push(&normal(vector![0.0], -1.0))?;
    let close = |entry: f32| [[[[1.0], [entry]]], [[[entry], [1.0]]]];
    let refused = scene.set_delassus(&close(0.9999));
    assert!(matches!(refused, Err(Error::DelassusNotGram { .. })));
    scene.set_delassus(&close(1.0 - f32::EPSILON)) // rounding
}

/// `q` is 0 by cancellation, and `W r + q` and `H v + w` are, too: what rounding hides is still there.
#[test]
fn rounding_counts_where_everything_cancels() -> Result<(), Error> {
    let mut kernel = Kernel::<f32, 2, 1, 1>::new();
    kernel.scene_mut().set_mass(&Matrix2::identity())?;
    let contact = normal(vector![0.909_239_4, 1.013_443_8], 0.0);
    kernel.scene_mut().push(&contact)?;
    let push = vector![0.560_922_6, -0.503_247_44];
    for tolerance in [1e-6_f32, 1e-4] {
        let solution = kernel.solve(&push, &Settings::new(tolerance))?.clone();
        let error = error_of(kernel.scene(), &push, &solution, Law::Coulomb);
        assert!(!solution.is_solved() || error <= f64::from(tolerance));
        assert!(tolerance < 1e-5 || solution.is_solved());
    }
    Ok(())
}

#[test]
fn a_limit_within_rounding_is_not_left_out() -> Result<(), Error> {
    let mut kernel = Kernel::<f32, 2, 1, 1, _>::mixed();
    kernel.scene_mut().set_mass(&Matrix2::identity())?;
    let limits = [row(vector![0.885_352, 0.955_784_8], 0.0, RowLaw::Limit, 0)];
    let push = vector![1.185_029_3, -1.097_703_3];
    let solution = kernel.solve_with_limits(&limits, &push, &Settings::new(1e-6))?;
    assert!(solution.row_by_key(0).is_some());
    Ok(())
}

/// An open limit is checked as well.
#[test]
fn a_limit_that_is_left_out_has_sound_numbers() -> Result<(), Error> {
    let mut kernel = Kernel::<f64, 1, 1, 1, _>::mixed();
    kernel.scene_mut().set_mass(&Matrix1::new(1.0))?;
    for compliance in [-1.0, f64::NAN] {
        let limits = [JointRow {
            compliance,
            ..row(vector![1.0], 5.0, RowLaw::Limit, 0)
        }];
        let refused = kernel.solve_with_limits(&limits, &vector![0.0], &Settings::new(1e-9));
        assert_eq!(refused.err(), Some(Error::InvalidCompliance { slot: 0 }));
    }
    Ok(())
}

#[test]
fn a_solve_that_was_disowned_is_not_resumed() -> Result<(), Error> {
    let mut kernel = Kernel::<f64, 2, 1, 2, _>::mixed();
    let scene = kernel.scene_mut();
    scene.set_mass(&Matrix2::identity())?;
    scene.push(&normal(vector![1.0, 0.3], 0.0))?;
    scene.push(&normal(vector![0.9, -0.4], 0.0))?;
    let limits = [row(vector![-1.0, 0.0], 0.05, RowLaw::Limit, 0)];
    let hurried = Settings {
        budget: 1,
        ..Settings::new(1e-9)
    };
    let full = kernel.solve_with_limits(&limits, &vector![-1.0, 1.9], &hurried);
    assert_eq!(full.err(), Some(Error::ContactListFull { capacity: 2 }));
    assert_eq!(kernel.solution().status, Status::Unsolved);
    let none = Settings {
        budget: 0,
        ..hurried
    };
    let solution = kernel.resume(&vector![-5.0, 0.0], &none)?;
    assert_eq!(solution.work.total(), 0);
    Ok(())
}

#[test]
fn a_limit_is_open_if_it_does_not_push() -> Result<(), Error> {
    let mut kernel = Kernel::<f64, 2, 1, 3, _>::mixed();
    let scene = kernel.scene_mut();
    scene.set_mass(&Matrix2::identity())?;
    for (key, (x, y, offset)) in [(-0.9, 0.9, -0.4), (0.3, -0.4, -0.3), (0.7, -0.9, -0.9)]
        .into_iter()
        .enumerate()
    {
        let key = u32::try_from(key).unwrap_or(0);
        scene.push_row(&row(vector![x, y], offset, RowLaw::Limit, key))?;
    }
    for tolerance in [1e-2, 1e-4, 1e-9] {
        let solution = kernel.solve(&vector![0.0, 0.0], &Settings::new(tolerance))?;
        for slot in 0..3 {
            let found = solution.row(RowIndex { slot, row: 0 }).expect("a row");
            assert_eq!(found.mode == RowMode::Open, found.impulse == 0.0);
            assert!(found.mode == RowMode::Open || found.mode == RowMode::AtLimit);
        }
    }
    Ok(())
}

/// Two walls that nothing can move apart, beside a body that could be solved alone.
#[test]
fn what_cannot_be_met_is_not_solved() -> Result<(), Error> {
    let mut kernel = Kernel::<f32, 3, 3, 2>::new();
    let scene = kernel.scene_mut();
    scene.set_mass(&Matrix3::identity())?;
    for (scale, offset) in [(1.0, 0.0), (0.0, -1.0)] {
        scene.push(&Contact {
            jacobian: matrix![0.0, 0.0, 1.0; 1.0, 0.0, 0.0; 0.0, 1.0, 0.0] * scale,
            offset: vector![offset, 0.0, 0.0],
            mu: 0.5,
            key: 0,
        })?;
    }
    let solution = kernel.solve(&vector![0.1, 0.0, -1.0], &Settings::new(1e-4))?;
    assert_eq!(solution.status, Status::Infeasible);
    Ok(())
}
