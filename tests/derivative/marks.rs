//! What has no derivative says so.

use crate::support::boxes::{BRICK, BoxScene, planar_floor};
use nalgebra::{Matrix2, Vector3, vector};
use stiction::{ContactMode, Derivative, Error, Factor, Inputs, Kernel, Outputs, Settings, Solver};

const SETTINGS: Settings<f64> = Settings::new(1e-12);

/// The derivative of a brick on a plane, and how its legs are loaded and moved by what comes on top.
fn brick(push: [f64; 6]) -> Result<(Kernel<f64, 6, 3, 4>, ContactMode), Error> {
    let mut kernel = Kernel::new();
    let scene: BoxScene<f64> = BRICK.on_plane(0.5)?;
    *kernel.scene_mut() = scene;
    let mode = kernel.solve(&push.into(), &SETTINGS)?.contacts[0].mode;
    Ok((kernel, mode))
}

#[test]
fn four_legs_at_rest_have_a_velocity_and_share_a_load() -> Result<(), Error> {
    let (kernel, mode) = brick([0.01, 0.0, -0.2, 0.0, 0.0, 0.0])?;
    assert_eq!(mode, ContactMode::Stick);
    let derivative = kernel.derivative(&SETTINGS)?;
    assert!(!derivative.has_unique_impulses() && derivative.has_unique_velocity());
    let mut change = Inputs::<f64, 6, 3, 4>::zero();
    change.free_impulse.z = -1.0;
    let response = derivative.forward(&change);
    assert!(response.velocity.norm() < 1e-12 && derivative.misfit(&change) < 1e-12);
    for leg in response.impulses {
        assert!((leg - Vector3::new(0.25, 0.0, 0.0)).norm() < 1e-12, "{leg}");
    }
    // The floor rises under one leg: not all can stay.
    let mut change = Inputs::<f64, 6, 3, 4>::zero();
    change.offsets[0].x = 1.0;
    assert!(derivative.misfit(&change) > 0.1);
    Ok(())
}

#[test]
fn what_slides_straight_has_a_velocity_and_what_turns_has_none() -> Result<(), Error> {
    let (straight, mode) = brick([1.0, 0.0, -0.2, 0.0, 0.0, 0.0])?;
    assert_eq!(mode, ContactMode::Slip);
    let derivative = straight.derivative(&SETTINGS)?;
    assert!(!derivative.has_unique_impulses() && derivative.has_unique_velocity());
    let (turning, mode) = brick([1.0, 0.0, -0.2, 0.0, 0.0, 0.1])?;
    assert_eq!(mode, ContactMode::Slip);
    let derivative = turning.derivative(&SETTINGS)?;
    assert!(!derivative.has_unique_impulses() && !derivative.has_unique_velocity());
    Ok(())
}

/// 2 kg on a floor (x, height).
fn block(push: [f64; 2]) -> Result<Kernel<f64, 2, 2, 2>, Error> {
    let mut kernel = Kernel::new();
    kernel.scene_mut().set_mass(&(Matrix2::identity() * 2.0))?;
    kernel.scene_mut().push(&planar_floor(0.5, 0))?;
    kernel.solve(&push.into(), &SETTINGS)?;
    Ok(kernel)
}

#[test]
fn the_margin_shrinks_towards_a_change_of_mode() -> Result<(), Error> {
    // It slips from 0.1 N·s on.
    for (push, mode) in [(0.0999, ContactMode::Stick), (0.1001, ContactMode::Slip)] {
        let kernel = block([push, -0.2])?;
        assert_eq!(kernel.solution().contacts[0].mode, mode);
        let margin = kernel.derivative(&SETTINGS)?.margin();
        // 1e-4 of an impulse of 0.2 and 0.1 N·s
        let expected = 1e-4 / 0.05_f64.sqrt();
        assert!((margin / expected - 1.0).abs() < 0.01, "{margin}");
    }
    let open = block([0.0, 0.01])?.derivative(&SETTINGS)?.margin();
    assert!((open - 1.0).abs() < 1e-12); // of its motion: nothing pushes
    Ok(())
}

#[test]
fn at_the_end_of_friction_the_derivative_is_that_of_the_mode() -> Result<(), Error> {
    let kernel = block([0.1, -0.2])?;
    let derivative = kernel.derivative(&SETTINGS)?;
    assert!(derivative.margin() < 1e-9);
    let mut change = Inputs::<f64, 2, 2, 2>::zero();
    change.free_impulse.x = 1.0;
    let moved = derivative.forward(&change).velocity.x;
    let expected = match kernel.solution().contacts[0].mode {
        ContactMode::Stick => 0.0,
        _ => 0.5,
    };
    assert!((moved - expected).abs() < 1e-12);
    Ok(())
}

#[test]
fn without_a_solution_there_is_no_derivative() -> Result<(), Error> {
    let mut kernel = block([0.0, -0.2])?;
    let scene = kernel.scene().clone();
    let factor = Factor::new(&scene)?;
    let solver = Solver::<f64, 2, 2, 2>::new();
    let refused = Derivative::new(&scene, &factor, solver.solution(), &SETTINGS);
    assert_eq!(refused.err(), Some(Error::NoSolution));
    kernel.scene_mut().clear_contacts();
    let refused = kernel.derivative(&SETTINGS);
    assert_eq!(refused.err(), Some(Error::StaleFactor));
    kernel.prepare()?;
    let refused = kernel.derivative(&SETTINGS);
    assert_eq!(refused.err(), Some(Error::SceneChanged));
    Ok(())
}

#[test]
fn single_precision_gives_the_same_to_its_digits() -> Result<(), Error> {
    let push = [0.03, 0.01, -0.2, 0.0, 0.001, 0.0];
    let double = brick(push)?.0;
    let mut single = Kernel::<f32, 6, 3, 4>::new();
    *single.scene_mut() = BRICK.on_plane(0.5)?;
    #[allow(clippy::cast_possible_truncation)]
    let push = push.map(|x| x as f32);
    let settings = Settings::new(1e-5);
    single.solve(&push.into(), &settings)?;
    let (one, other) = (double.derivative(&SETTINGS)?, single.derivative(&settings)?);
    assert_eq!(one.has_unique_impulses(), other.has_unique_impulses());
    assert_eq!(one.has_unique_velocity(), other.has_unique_velocity());
    let (mut weights, mut weights_32) = (Outputs::zero(), Outputs::zero());
    weights.impulses[0] = vector![1.0, 0.5, 0.25];
    weights_32.impulses[0] = vector![1.0, 0.5, 0.25];
    let (one, other) = (one.adjoint(&weights), other.adjoint(&weights_32));
    for (a, b) in one.free_impulse.iter().zip(&other.free_impulse) {
        let scale = one.free_impulse.amax();
        assert!((a - f64::from(*b)).abs() < 1e-4 * scale, "{one:?} {other:?}");
    }
    Ok(())
}
