//! When a kernel computes its factor again.
#![allow(clippy::float_cmp)] // to the last bit

use super::Kernel;
use crate::error::Error;
use crate::problem::Age;
use crate::scene::{Contact, JointRow, RowLaw};
use crate::solution::Settings;
use nalgebra::{Matrix2, matrix, vector};

/// 2 kg on a floor.
fn block<const R: usize>() -> Result<Kernel<f64, 2, 2, 1, R>, Error> {
    let mut kernel = Kernel::new();
    kernel.scene_mut().set_mass(&(Matrix2::identity() * 2.0))?;
    let (jacobian, offset) = (matrix![0.0, 1.0; 1.0, 0.0], vector![0.0, 0.0]);
    kernel.scene_mut().push(&Contact { jacobian, offset, mu: 0.5, key: 0 })?;
    Ok(kernel)
}

/// A bit flips in the factor. Its fingerprint cannot tell, and a solve that fails does. Between two slices nothing is computed again, and once
/// the solve is given up the factor is.
#[test]
fn a_factor_in_doubt_is_computed_anew_and_not_within_a_solve() -> Result<(), Error> {
    let mut kernel = block::<0>()?;
    let (push, settings) = (vector![1.0, -0.2], Settings::new(1e-9));
    kernel.solve(&push, &settings)?;
    let effective_mass = |kernel: &Kernel<f64, 2, 2, 1>| kernel.factor.mean_effective_mass(0);
    let whole = effective_mass(&kernel);
    for gives_up_between in [false, true] {
        kernel.factor.spoil();
        let spoilt = effective_mass(&kernel);
        kernel.prepare()?; // the last call has solved its scene
        for _ in 0..3 {
            assert!(!kernel.advance(&push, &Settings { budget: 1, ..Settings::new(0.0) })?);
            kernel.prepare()?;
            assert_eq!(effective_mass(&kernel), spoilt);
        }
        if !gives_up_between {
            assert!(!kernel.resume(&push, &Settings { budget: 0, ..Settings::new(0.0) })?.is_solved());
            kernel.prepare()?;
            assert_eq!(effective_mass(&kernel), whole);
        }
        assert!(kernel.solve(&push, &settings)?.is_solved());
        assert_eq!(effective_mass(&kernel), whole);
        assert!(spoilt != whole && !kernel.in_doubt);
    }
    Ok(())
}

/// A solve with limits trusts a factor that it has just computed, and the next one does not.
#[test]
fn a_new_factor_is_trusted_once_with_limits() -> Result<(), Error> {
    let (push, settings) = (vector![1.0, -0.2], Settings::new(1e-9));
    let limits =
        [JointRow { row: vector![-1.0, 0.0], offset: 0.1, law: RowLaw::Limit, compliance: 0.0, key: 0 }];
    for call in 0..3 {
        let mut kernel = block::<1>()?;
        for age in [Age::New, Age::Old] {
            match call {
                0 => kernel.solve_with_limits(&limits, &push, &settings).map(drop)?,
                1 => kernel.resume_with_limits(&limits, &push, &settings).map(drop)?,
                _ => while !kernel.advance_with_limits(&limits, &push, &settings)? {},
            }
            assert!(kernel.solution().is_solved());
            assert_eq!(kernel.solver().factor_age(), age, "{call}");
        }
    }
    Ok(())
}
