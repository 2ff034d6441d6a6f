//! "No slip": a friction coefficient of a thousand to a million solves like one of 1.

use crate::support::pad;
use crate::support::random::{draws, numbers};
use crate::support::sizes::cart;
use nalgebra::{SMatrix, SVector, matrix, vector};
use stiction::{Contact, Error, Real, Settings};

const COEFFICIENTS: [f64; 6] = [1.0, 1e2, 1e3, 1e4, 1e5, 1e6];

/// A driven wheel of a radius, and a caster without friction, for 0.4 s: its speed (m/s) over that of rolling.
fn rover<T: Real>(mu: f64, radius: f64, torque: f64, tolerance: f64) -> Result<f64, Error> {
    let (step, mass, wheel) = (2e-3, 3.0, 0.8 * radius * radius);
    let mut kernel = cart::Kernel::<T>::new(); // x, height, pitch, wheel
    let scene = kernel.scene_mut();
    let masses = SMatrix::<f64, 4, 4>::from_diagonal(&vector![mass, mass, 0.03, wheel]);
    let masses = pad::mass(&masses.map(T::literal));
    scene.set_mass(&masses)?;
    let driven = matrix![0.0, 1.0, 0.08, 0.0; 1.0, 0.0, 0.01, -radius];
    let caster = matrix![0.0, 1.0, -0.12, 0.0; 1.0, 0.0, 0.06, 0.0];
    for (jacobian, mu, key) in [(driven, mu, 0), (caster, 0.0, 1)] {
        scene.push(&Contact {
            jacobian: pad::jacobian(&jacobian.map(T::literal)),
            offset: SVector::zeros(),
            mu: T::literal(mu),
            key,
        })?;
    }
    let force = vector![0.0, -mass * 9.81, -torque, torque] * step;
    let force = pad::vector(force.map(T::literal));
    let mut velocity = SVector::<T, 6>::zeros();
    for tick in 0..200 {
        let push = masses * velocity + force;
        let solution = kernel.solve(&push, &Settings::new(T::literal(tolerance)))?;
        assert!(solution.is_solved(), "mu {mu}, {tick}: {}", solution.error);
        velocity = solution.velocity;
    }
    let rolls = torque / radius / (mass + wheel / (radius * radius)) * 0.4;
    Ok(velocity[0].to_subset().unwrap_or(f64::NAN) / rolls)
}

#[test]
fn a_wheel_that_cannot_slip_rolls() -> Result<(), Error> {
    for drawn in draws(numbers(2), 5) {
        let [x, y] = [drawn[0], drawn[1]];
        let (radius, torque) = (0.05 + 0.02 * x, 0.1 + 0.05 * y);
        for mu in COEFFICIENTS {
            for share in [rover::<f64>(mu, radius, torque, 1e-9)?, rover::<f32>(mu, radius, torque, 1e-4)?] {
                assert!((share - 1.0).abs() < 1e-3, "mu {mu}: {share}");
            }
        }
    }
    Ok(())
}
