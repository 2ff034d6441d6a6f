//! 100,000 steps: energy that does not grow, a stack that does not creep.

use crate::support::boxes::{BRICK, Cuboid, GRAVITY};
use crate::support::motion::{BALL, Ball, Motion, REACH};
use crate::support::pad;
use crate::support::sizes::cart;
use nalgebra::{Matrix3, SMatrix, SVector, matrix, vector};
use stiction::time_stepping as law;
use stiction::{Contact, Error, Real, Scene};

/// Largest growth of the energy above its lowest so far, as a share of the first one.
fn growth(mut energies: impl Iterator<Item = f64>) -> f64 {
    let first = energies.next().expect("a step");
    let (_, growth) = energies.fold((first, 0.0), |(lowest, growth), energy| {
        (f64::min(lowest, energy), f64::max(growth, energy - lowest))
    });
    growth / first
}

fn ball_growth<T: Real>(restitution: f64, tolerance: f64) -> Result<f64, Error> {
    let ball = Ball { restitution, ..BALL };
    let mut motion = ball.motion::<T>(1e-3, tolerance)?;
    motion.position.y = T::literal(0.5);
    motion.velocity = pad::vector(vector![2.0, 0.0, 60.0].map(T::literal));
    let mut energies = vec![motion.energy()];
    for _ in 0..100_000 {
        ball.advance(&mut motion)?;
        energies.push(motion.energy());
    }
    Ok(growth(energies.into_iter()))
}

/// At `e = 1` it never rests, and what the solver's tolerance and rounding leave of 100,000 steps adds
/// up.
#[test]
fn the_energy_of_a_bouncing_ball_never_grows() -> Result<(), Error> {
    for (e, double, single) in [
        (0.0, 1e-12, 1e-5),
        (0.5, 1e-12, 1e-5),
        (0.9, 1e-12, 1e-5),
        (1.0, 4e5 * f64::EPSILON, 1e4 * f64::from(f32::EPSILON)),
    ] {
        let growth = [ball_growth::<f64>(e, 1e-10)?, ball_growth::<f32>(e, 1e-5)?];
        println!("e = {e}: energy grows by {:.1e} in f64, {:.1e} in f32", growth[0], growth[1]);
        assert!(growth[0] <= double && growth[1] <= single, "e = {e}: {growth:?}");
    }
    Ok(())
}

/// Gap and Jacobian of a corner of a plane box over a floor; position (x, height, angle).
fn corner<T: Real>(position: &SVector<T, 6>, [x, y]: [T; 2]) -> (T, SMatrix<T, 2, 6>) {
    let (sin, cos) = position.z.sin_cos();
    let arm = vector![cos * x - sin * y, sin * x + cos * y];
    let (zero, one) = (T::ZERO, T::ONE);
    (position.y + arm.y, pad::jacobian(&matrix![zero, one, arm.x; one, zero, -arm.y]))
}

/// A box thrown on its edge, 100,000 steps of 1 ms; the growth of its energy and its last speed.
fn tumbling_box<T: Real>(tolerance: f64) -> Result<[f64; 2], Error> {
    let corners = [[0.1, 0.06], [0.1, -0.06], [-0.1, 0.06], [-0.1, -0.06]];
    let corners = corners.map(|corner| corner.map(T::literal));
    let mass = vector![2.0, 2.0, 2.0 * (0.1 * 0.1 + 0.06 * 0.06) / 3.0];
    let mut scene = cart::Scene::<T>::new();
    scene.set_mass(&pad::mass(&Matrix3::from_diagonal(&mass.map(T::literal))))?;
    for &point in &corners {
        let (_, jacobian) = corner(&SVector::zeros(), point);
        scene.push(&Contact { jacobian, offset: SVector::zeros(), mu: T::literal(0.4), key: 0 })?;
    }
    let weight = SVector::ith(1, -2.0 * GRAVITY);
    let mut motion = Motion::new(scene, weight, 1e-3, tolerance)?;
    motion.position = pad::vector(vector![0.0, 0.4, 0.5].map(T::literal));
    motion.velocity = pad::vector(vector![2.0, 0.0, -6.0].map(T::literal));
    let mut energies = vec![motion.energy()];
    for _ in 0..100_000 {
        for (contact, &point) in corners.iter().enumerate() {
            let (gap, jacobian) = corner(&motion.position, point);
            motion.scene.set_jacobian(contact, &jacobian)?;
            motion.offset(
                contact,
                law::Gap { distance: gap, recovery: T::ZERO, reach: T::literal(REACH) }
                    .offset(motion.step)?,
            )?;
        }
        motion.factor.prepare(&motion.scene)?;
        motion.advance()?;
        energies.push(motion.energy());
    }
    let speed = motion.velocity.norm().to_subset().unwrap_or(f64::NAN);
    Ok([growth(energies.into_iter()), speed])
}

/// Errors are relative to the free velocities, of which gaps may be [`REACH`]; a spin is ten times
/// the speed of a corner.
#[test]
fn the_energy_of_a_tumbling_box_never_grows() -> Result<(), Error> {
    let runs = [(1e-10, tumbling_box::<f64>(1e-10)?), (1e-5, tumbling_box::<f32>(1e-5)?)];
    for (tolerance, [growth, speed]) in runs {
        println!("solved to {tolerance:e}: energy grows by {growth:.1e}, last speed {speed:.1e}");
        assert!(growth <= 10.0 * tolerance, "{growth:e}");
        assert!(speed <= 20.0 * REACH * tolerance, "{speed:e}");
    }
    Ok(())
}

/// Three boxes of 1, 10 and 100 kg on a slope, held by friction. As long as they do not move their
/// Jacobians do not either, and the gaps follow from the small displacement.
#[test]
fn a_resting_stack_does_not_creep() -> Result<(), Error> {
    let (slope, step, steps) = (0.2_f64, 1e-3, 100_000);
    let layers = [1.0, 10.0, 100.0].map(|mass| Cuboid { mass, ..BRICK });
    let mut mass = SMatrix::<f64, 18, 18>::zeros();
    let mut force = SVector::<f64, 18>::zeros();
    let mut scene = Scene::<f64, 18, 3, 12>::new();
    let mut contacts = Vec::new();
    for (layer, cuboid) in layers.iter().enumerate() {
        let at = 6 * layer;
        mass.fixed_view_mut::<6, 6>(at, at).copy_from(&cuboid.mass_matrix());
        force.fixed_rows_mut::<6>(at).copy_from(&cuboid.free_impulse::<f64>(slope, 1.0));
        let plane = cuboid.on_plane::<f64>(0.5)?;
        for (contact, corner) in plane.contacts().iter().zip(cuboid.corners()) {
            let mut jacobian = SMatrix::<f64, 3, 18>::zeros();
            jacobian.fixed_columns_mut::<6>(at).copy_from(&contact.jacobian);
            if let Some(below) = at.checked_sub(6) {
                // The same point as seen from the box below, a whole height further up.
                let up = vector![corner.x, corner.y, -corner.z];
                let rows = crate::support::boxes::point_jacobian(&up);
                jacobian.fixed_columns_mut::<6>(below).copy_from(&-rows);
            }
            contacts.push(Contact { jacobian, offset: SVector::zeros(), mu: 0.5, key: 0 });
        }
    }
    scene.set_mass(&mass)?;
    for contact in &contacts {
        scene.push(contact)?;
    }
    let mut motion = Motion::new(scene, force, step, 1e-9)?;
    for _ in 0..steps {
        for (i, contact) in contacts.iter().enumerate() {
            let gap = (contact.jacobian * motion.position)[0];
            motion.offset(i, law::Gap { distance: gap, recovery: 0.1, reach: REACH }.offset(step)?)?;
        }
        motion.advance()?;
    }
    let drift = motion.position.amax() / (step * f64::from(steps));
    println!("drift of a resting stack: {drift:.1e} m per simulated second");
    assert!(drift < 1e-9, "{drift:e}");
    Ok(())
}
