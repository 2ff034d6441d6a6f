//! When a kernel computes its factor again.
#![allow(clippy::float_cmp)] // to the last bit

use super::Kernel;
use crate::error::Error;
use crate::scene::Contact;
use crate::solver::Call;
use nalgebra::{Matrix2, matrix, vector};

/// A bit flips in the factor. Its fingerprint cannot tell, and a solve that fails does.
#[test]
fn a_factor_in_doubt_is_computed_anew_and_not_within_a_solve() -> Result<(), Error> {
    let mut kernel = Kernel::<f64, 2, 2, 1>::new();
    kernel.scene_mut().set_mass(&(Matrix2::identity() * 2.0))?;
    let (jacobian, offset) = (matrix![0.0, 1.0; 1.0, 0.0], vector![0.0, 0.0]);
    kernel.scene_mut().push(&Contact { jacobian, offset, mu: 0.5, key: 0 })?;
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
