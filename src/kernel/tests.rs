//! When a kernel computes its factor again.
#![allow(clippy::float_cmp)] // to the last bit

use super::Kernel;
use crate::error::Error;
use crate::problem::Age;
use crate::scene::{Contact, JointRow, RowLaw};
use crate::solution::Settings;
use crate::solver::Call;
use nalgebra::{Matrix2, matrix, vector};

/// 2 kg on a floor.
fn block<const R: usize>() -> Result<Kernel<f64, 2, 2, 1, R>, Error> {
    let mut kernel = Kernel::new();
    kernel.scene_mut().set_mass(&(Matrix2::identity() * 2.0))?;
    let (jacobian, offset) = (matrix![0.0, 1.0; 1.0, 0.0], vector![0.0, 0.0]);
    kernel.scene_mut().push(&Contact { jacobian, offset, mu: 0.5, key: 0 })?;
    Ok(kernel)
}

/// A bit flips in the factor. Its fingerprint cannot tell, and a solve that fails does.
#[test]
fn a_factor_in_doubt_is_computed_anew_and_not_within_a_solve() -> Result<(), Error> {
    let mut kernel = block::<0>()?;
    kernel.prepare()?;
    let whole = kernel.factor.mean_effective_mass(0);
    for _ in 0..2 {
        kernel.factor.spoil();
        let spoilt = kernel.factor.mean_effective_mass(0);
        assert!(spoilt != whole);
        kernel.prepare()?; // the last call, if there was one, has solved its scene
        assert_eq!(kernel.factor.mean_effective_mass(0), spoilt);
        kernel.note_doubt(false); // it has not
        kernel.solver_mut().reset();
        kernel.prepare_for(Call::Resume)?;
        assert_eq!(kernel.factor.mean_effective_mass(0), spoilt);
        kernel.prepare()?;
        assert_eq!(kernel.factor.mean_effective_mass(0), whole);
        assert!(!kernel.in_doubt);
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
