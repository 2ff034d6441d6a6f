//! The cheap bound on the impulse that stops the motion, against that impulse.

use super::{Age, Problem, expected};
use crate::{Contact, Error, Factor, Scene, Settings, Surface};
use nalgebra::{Matrix4, SVector, vector};

#[test]
fn a_patch_that_spins_is_stopped_by_no_more_than_its_bound() -> Result<(), Error> {
    let mut scene = Scene::<f64, 4, 4, 1, 0, 1>::new();
    scene.set_mass(&Matrix4::identity())?;
    let contact = Contact {
        jacobian: Matrix4::identity(),
        offset: vector![10.0, 0.0, 0.0, 1.0], // far, and spins
        mu: 0.0,
        key: 0,
    };
    let surface = Surface {
        spin: 4.0, // m: forty times the coefficient of the tangents
        ..Surface::isotropic(0.1)
    };
    scene.push_on(&contact, &surface)?;
    let (factor, push) = (Factor::new(&scene)?, SVector::zeros());
    let mut problem = Problem::new(&scene, &factor, &push, &Settings::default(), Age::New);
    problem.fill(true);
    let bound = problem.stopping_bound.sqrt() * 4.0 * expected::SHARE;
    problem.count_stopping();
    let size = problem.expected_size;
    assert!(problem.r0_norm == 0.0 && size > 0.0 && size <= bound);
    Ok(())
}
