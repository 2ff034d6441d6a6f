//! When a kernel computes its factor again.
#![allow(clippy::float_cmp)] // to the last bit

use super::Kernel;
use crate::error::Error;
use crate::scene::Contact;
use crate::solution::Settings;
use nalgebra::{Matrix2, matrix, vector};

/// A bit flips in the factor. Its fingerprint cannot tell, and a solve that fails does. Between two slices nothing is computed again, and once
/// the solve is given up the factor is.
#[test]
fn a_factor_in_doubt_is_computed_anew_and_not_within_a_solve() -> Result<(), Error> {
    let mut kernel = Kernel::<f64, 2, 2, 1>::new();
    kernel.scene_mut().set_mass(&(Matrix2::identity() * 2.0))?;
    let (jacobian, offset) = (matrix![0.0, 1.0; 1.0, 0.0], vector![0.0, 0.0]);
    kernel.scene_mut().push(&Contact { jacobian, offset, mu: 0.5, key: 0 })?;
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
