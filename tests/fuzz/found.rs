//! What was found, as plain tests.

use nalgebra::{SVector, matrix, vector};
use stiction::{Contact, Error, Kernel, Settings};

/// Squares of the impulses to expect overflow: nothing is solved, but what is said is made of numbers.
#[test]
fn a_push_beyond_all_squares_gives_numbers() -> Result<(), Error> {
    let mut kernel = Kernel::<f64, 3, 3, 3>::new();
    let scene = kernel.scene_mut();
    scene.set_mass(&matrix![1.252_279, 0.0, 0.0; 0.0, 0.012_399, 0.0; 0.0, 0.0, 0.012_399])?;
    scene.push(&Contact {
        jacobian: matrix![
            0.0, 1.0, -1.004_497_572_191_590_7;
            0.0, 0.0, -1.200_548_914_731_759;
            0.350_631_397_096_667_1, 0.0, 0.0],
        offset: SVector::zeros(),
        mu: 0.0,
        key: 0,
    })?;
    let push = vector![0.0, -7.904_247_334_010_491e154, 0.0];
    let solution = kernel.solve(&push, &Settings::new(1e-9))?;
    assert!(!solution.is_solved());
    let impulses = solution
        .contacts
        .iter()
        .flat_map(|contact| contact.impulse.iter());
    assert!(impulses.chain(&solution.velocity).all(|x| x.is_finite()));
    Ok(())
}
