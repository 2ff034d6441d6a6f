//! Time steps differentiated through and through.

use crate::support::boxes::{BRICK, GRAVITY, point_jacobian};
use nalgebra::{SMatrix, SVector, Vector3, vector};
use stiction::{Contact, ContactMode, Error, Inputs, Kernel, Outputs, Settings};

const STEP: f64 = 0.01;
const STEPS: usize = 100;
const SETTINGS: Settings<f64> = Settings::new(1e-13);

type Body = Kernel<f64, 6, 3, 4>;
type Vector = SVector<f64, 6>;

/// Motion of a body from a velocity: kernels with the solution of each step, and the velocities behind them. One geometry for all
/// steps, as that of a ball or of a box that slides on a plane.
fn roll(body: &Body, start: &Vector, force: &Vector) -> Result<(Vec<Body>, Vec<Vector>), Error> {
    let (mut kernels, mut velocities) = (Vec::new(), Vec::new());
    let (mut kernel, mut v) = (body.clone(), *start);
    for _ in 0..STEPS {
        let push = kernel.scene().mass() * v + force * STEP;
        let solution = kernel.solve(&push, &SETTINGS)?;
        assert!(solution.is_usable(1e-11));
        v = solution.velocity;
        velocities.push(v);
        kernels.push(kernel.clone());
    }
    Ok((kernels, velocities))
}

/// How velocities and positions at the end move with the start's velocity and the friction.
fn forward(kernels: &[Body], start: &Vector, friction: f64) -> Result<(Vector, Vector), Error> {
    let (mut v, mut x) = (*start, Vector::zeros());
    for kernel in kernels {
        let mut change = Inputs::zero();
        change.free_impulse = kernel.scene().mass() * v;
        change.friction = [friction; 4];
        v = kernel.derivative(&SETTINGS)?.forward(&change).velocity;
        x += v * STEP;
    }
    Ok((v, x))
}

/// The gradient of `weights · x` at the end with respect to the start's velocity and the friction.
fn backward(kernels: &[Body], weights: &Vector) -> Result<(Vector, f64), Error> {
    let (mut v, mut friction) = (Vector::zeros(), 0.0);
    for kernel in kernels.iter().rev() {
        let mut outputs = Outputs::zero();
        outputs.velocity = v + weights * STEP;
        let gradient = kernel.derivative(&SETTINGS)?.adjoint(&outputs);
        friction += gradient.friction.iter().sum::<f64>();
        v = kernel.scene().mass() * gradient.free_impulse;
    }
    Ok((v, friction))
}

#[test]
fn the_stopping_distance_of_a_box_has_the_derivative_of_its_formula() -> Result<(), Error> {
    let (mu, speed) = (0.3, 2.2);
    let mut body = Body::new();
    *body.scene_mut() = BRICK.on_plane(mu)?;
    let (start, along) = (vector![speed, 0.0, 0.0, 0.0, 0.0, 0.0], Vector::x());
    let weight = vector![0.0, 0.0, -BRICK.mass * GRAVITY, 0.0, 0.0, 0.0];
    let (kernels, velocities) = roll(&body, &start, &weight)?;
    let distance: f64 = velocities.iter().map(|v| v.x * STEP).sum();
    // It slides for n steps, v_k = v_0 - k mu g h, and stands from the next one on.
    let slowdown = mu * GRAVITY * STEP;
    let n = (speed / slowdown).floor();
    assert!((distance - STEP * (n * speed - slowdown * n * (n + 1.0) / 2.0)).abs() < 1e-9);
    let by_speed = n * STEP;
    let by_friction = -GRAVITY * STEP * STEP * n * (n + 1.0) / 2.0;
    // In continuous time v² / (2 mu g).
    assert!((by_speed - speed / (mu * GRAVITY)).abs() < STEP);

    let (v, x) = forward(&kernels, &along, 0.0)?;
    assert!((x.x - by_speed).abs() < 1e-9 && v.norm() < 1e-9, "{x} {v}");
    let (_, x) = forward(&kernels, &Vector::zeros(), 1.0)?;
    assert!((x.x - by_friction).abs() < 1e-9 * by_friction.abs(), "{x}");
    let (by_start, friction) = backward(&kernels, &along)?;
    assert!((by_start.x - by_speed).abs() < 1e-9);
    assert!((friction - by_friction).abs() < 1e-9 * by_friction.abs());
    Ok(())
}

/// A ball of 1 kg and 10 cm on the floor.
fn ball(mu: f64) -> Result<Body, Error> {
    let mut body = Body::new();
    let mut mass = SMatrix::identity();
    for k in 3..6 {
        mass[(k, k)] = 0.4 * 0.1 * 0.1;
    }
    body.scene_mut().set_mass(&mass)?;
    body.scene_mut().push(&Contact {
        jacobian: point_jacobian(&Vector3::new(0.0, 0.0, -0.1)),
        offset: SVector::zeros(),
        mu,
        key: 0,
    })?;
    Ok(body)
}

#[test]
fn a_ball_that_slides_and_then_rolls_moves_as_differences_say() -> Result<(), Error> {
    let mu = 0.2;
    // Backspin and sidespin: the slide turns.
    let (start, weight) =
        (vector![1.0, 0.3, 0.0, 4.0, -9.0, 2.0], vector![0.0, 0.0, -GRAVITY, 0.0, 0.0, 0.0]);
    let body = ball(mu)?;
    let (kernels, _) = roll(&body, &start, &weight)?;
    let mode = |kernel: &Body| kernel.solution().contacts[0].mode;
    assert_eq!(mode(&kernels[0]), ContactMode::Slip);
    assert_eq!(mode(&kernels[STEPS - 1]), ContactMode::Stick);
    let direction = vector![0.3, -0.5, 0.0, 1.0, 2.0, 0.7];
    let end = |h: f64| -> Result<[Vector; 2], Error> {
        let body = ball(mu * (1.0 + h))?;
        let (_, velocities) = roll(&body, &(start + direction * h), &weight)?;
        Ok([velocities[STEPS - 1], velocities.iter().sum::<Vector>() * STEP])
    };
    let difference = |h: f64| -> Result<[Vector; 2], Error> {
        let ([v, x], [v_back, x_back]) = (end(h)?, end(-h)?);
        Ok([(v - v_back) / (2.0 * h), (x - x_back) / (2.0 * h)])
    };
    let (wide, narrow) = (difference(2e-4)?, difference(1e-4)?);
    let (v, x) = forward(&kernels, &direction, mu)?;
    for ((found, wide), narrow) in [v, x].iter().zip(wide).zip(narrow) {
        let expected = (narrow * 4.0 - wide) / 3.0;
        let error = (found - expected).norm() / expected.norm();
        assert!(error < 1e-6, "{error:e}");
    }
    let weights = vector![1.0, 2.0, 0.0, 0.1, -0.3, 0.0];
    let (by_start, friction) = backward(&kernels, &weights)?;
    let gap = weights.dot(&x) - by_start.dot(&direction) - friction * mu;
    assert!(gap.abs() < 1e-12, "{gap:e}");
    Ok(())
}

#[test]
fn a_warm_start_changes_nothing() -> Result<(), Error> {
    let start = vector![1.0, 0.3, 0.0, 4.0, -9.0, 2.0];
    let weight = vector![0.0, 0.0, -GRAVITY, 0.0, 0.0, 0.0];
    let (kernels, velocities) = roll(&ball(0.2)?, &start, &weight)?;
    let mut before = start;
    for (kernel, v) in kernels.iter().zip(velocities) {
        let mut cold = kernel.clone();
        cold.solver_mut().reset();
        cold.solve(&(kernel.scene().mass() * before + weight * STEP), &SETTINGS)?;
        before = v;
        let mut change = Inputs::zero();
        change.free_impulse = vector![0.3, -0.5, 0.1, 1.0, 2.0, 0.7];
        change.friction = [1.0; 4];
        let [one, other] = [kernel, &cold].map(|kernel| {
            let derivative = kernel.derivative(&SETTINGS);
            derivative.map(|derivative| derivative.forward(&change))
        });
        let (one, other) = (one?, other?);
        assert!((one.velocity - other.velocity).norm() < 1e-8 * one.velocity.norm());
        assert!((one.impulses[0] - other.impulses[0]).norm() < 1e-8 * one.impulses[0].norm());
    }
    Ok(())
}
