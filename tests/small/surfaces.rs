//! Compliance and shapes of friction: what mechanics says of them.

use crate::support::boxes::{GRAVITY, planar_floor};
use crate::support::sizes::{self, block_rows};
use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, matrix, vector};
use stiction::time_stepping as law;
use stiction::{Contact, ContactMode, Error, Factor, Kernel, List, Scene, Settings, Solver, Surface};

#[test]
fn a_compliant_foot_sinks_by_its_weight_over_its_stiffness() -> Result<(), Error> {
    let (mass, stiffness, relaxation, step) = (3.0, 5e3, 5e-3, 2e-3);
    let rubber = law::Spring { stiffness, relaxation };
    let mut kernel = block_rows::Kernel::<f64>::new();
    kernel.scene_mut().set_mass(&(Matrix2::identity() * mass))?;
    let surface = Surface { compliance: [rubber.compliance(step)?, 0.0], ..Surface::isotropic(0.5) };
    kernel.scene_mut().push_on(&planar_floor(0.5, 0), &surface)?;
    let (mut height, mut velocity) = (0.0, vector![0.0, 0.0]);
    for _ in 0..2000 {
        let gap = law::Gap { distance: height, reach: 10.0, ..law::Gap::default() };
        let gap = rubber.offset(&gap, step)?;
        kernel.scene_mut().set_offset(0, &vector![gap, 0.0])?;
        let push = velocity * mass + vector![0.1, -mass * GRAVITY] * step;
        velocity = kernel.solve(&push, &Settings::new(1e-12))?.velocity;
        height += step * velocity.y;
    }
    assert!((height + mass * GRAVITY / stiffness).abs() < 1e-9, "{height}");
    assert!(velocity.x.abs() < 1e-12); // friction is as rigid as ever
    Ok(())
}

/// A body of this mass and these moments that rolls on a point at distance `radius` below it.
fn rolling(
    mass: f64,
    moment: f64,
    radius: f64,
    surface: &Surface<f64>,
) -> Result<(sizes::rolling::Scene<f64>, SMatrix<f64, 6, 6>), Error> {
    let matrix = SMatrix::from_diagonal(&vector![mass, mass, mass, moment, moment, moment]);
    let mut scene = Scene::new();
    scene.set_mass(&matrix)?;
    let contact =
        Contact { jacobian: testbed::rolling::jacobian(radius), offset: SVector::zeros(), mu: 0.0, key: 0 };
    scene.push_on(&contact, surface)?;
    Ok((scene, matrix))
}

#[test]
fn rolling_resistance_stops_a_coin_at_the_distance_of_its_energy() -> Result<(), Error> {
    let (mass, radius, length, speed, step) = (5e-3, 0.012, 1e-4, 0.3, 1e-4);
    let moment = 0.5 * mass * radius * radius;
    let surface = Surface { roll: [length; 2], spin: 1e-3, ..Surface::isotropic(0.8) };
    let (scene, matrix) = rolling(mass, moment, radius, &surface)?;
    let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
    let mut velocity = vector![speed, 0.0, 0.0, 0.0, speed / radius, 0.0];
    let mut distance = 0.0;
    while velocity[0] > 1e-9 {
        let mut push = matrix * velocity;
        push[2] -= mass * GRAVITY * step;
        let solution = solver.solve(&scene, &factor, &push, &Settings::new(1e-10))?;
        assert!(solution.is_solved(), "{:?} {}", solution.status, solution.error);
        velocity = solution.velocity;
        distance += step * velocity[0];
    }
    // (1 + 1/2) m v² / 2 is spent at `length m g / radius` a metre.
    let expected = 0.75 * speed * speed * radius / (length * GRAVITY);
    assert!((distance / expected - 1.0).abs() < 2e-3, "{distance} {expected}");
    Ok(())
}

#[test]
fn torsional_friction_stops_a_spinning_ball_at_the_time_of_its_momentum() -> Result<(), Error> {
    let (mass, radius, length, speed, step) = (0.1, 0.02, 2e-3, 20.0, 1e-3);
    let moment = 0.4 * mass * radius * radius;
    let surface = Surface { spin: length, ..Surface::isotropic(0.5) };
    let (scene, matrix) = rolling(mass, moment, radius, &surface)?;
    let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
    let mut velocity = SVector::ith(5, speed);
    let mut time = 0.0;
    while velocity[5] > 1e-9 {
        let mut push = matrix * velocity;
        push[2] -= mass * GRAVITY * step;
        let solution = solver.solve(&scene, &factor, &push, &Settings::new(1e-10))?;
        velocity = solution.velocity;
        time += step;
        // In physical units: a length times the normal impulse.
        let [normal, _, _, torque, ..]: [f64; 6] = solution.contacts[0].impulse.into();
        assert!((torque.abs() - length * normal).abs() < 1e-9 * normal || velocity[5] < 1e-9);
    }
    let expected = moment * speed / (length * mass * GRAVITY);
    assert!((time - expected).abs() < 1.5 * step, "{time} {expected}");
    Ok(())
}

#[test]
fn elliptic_friction_slides_as_maximum_dissipation_says() -> Result<(), Error> {
    let mass = 2.0;
    let mut scene = Scene::<f64, 3, 3, 3, 0, 1>::new();
    scene.set_mass(&(Matrix3::identity() * mass))?;
    let contact = Contact {
        jacobian: matrix![0.0, 0.0, 1.0; 1.0, 0.0, 0.0; 0.0, 1.0, 0.0],
        offset: SVector::zeros(),
        mu: 0.0,
        key: 0,
    };
    let friction = [0.8, 0.3];
    let surface = Surface { friction, ..Surface::isotropic(0.0) };
    scene.push_on(&contact, &surface)?;
    let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
    let push = vector![0.05, 0.03, -0.02];
    let solution = solver.solve(&scene, &factor, &push, &Settings::new(1e-12))?;
    let found = solution.contacts[0];
    assert_eq!(found.mode, ContactMode::Slip);
    let [normal, x, y] = found.impulse.into();
    let power = |x: f64, y: f64| -(x * found.velocity[1] + y * found.velocity[2]);
    // On the ellipse, and no other impulse there takes as much power.
    assert!(((x / friction[0]).hypot(y / friction[1]) - normal).abs() < 1e-12);
    for k in 0..360 {
        let (sin, cos) = f64::from(k).to_radians().sin_cos();
        let other = power(friction[0] * normal * cos, friction[1] * normal * sin);
        assert!(other <= power(x, y) + 1e-12);
    }
    Ok(())
}

/// A surface without friction is a contact without friction.
#[test]
fn what_slides_on_a_surface_without_friction_slips() -> Result<(), Error> {
    let mut kernel = Kernel::<f64, 3, 3, 3, 0, 1>::new();
    kernel.scene_mut().set_mass(&Matrix3::identity())?;
    let contact = Contact {
        jacobian: matrix![0.0, 0.0, 1.0; 1.0, 0.0, 0.0; 0.0, 1.0, 0.0],
        offset: SVector::zeros(),
        mu: 0.7,
        key: 0,
    };
    let scene = kernel.scene_mut();
    scene.push_on(&contact, &Surface::isotropic(0.0))?;
    let solution = kernel.solve(&vector![5.0, 0.0, -1.0], &Settings::new(1e-9))?;
    let found = solution.contacts[0];
    assert_eq!(found.mode, ContactMode::Slip);
    assert!((found.impulse - vector![1.0, 0.0, 0.0]).norm() < 1e-9);
    assert!((found.velocity - vector![0.0, 5.0, 0.0]).norm() < 1e-9);
    // How its rows are scaled depends on it.
    let refused = Err(Error::InvalidFriction { contact: 0, row: 1 });
    let scene = kernel.scene_mut();
    assert_eq!(scene.set_friction(0, 0.5), refused);
    scene.clear_contacts();
    scene.push_on(&contact, &Surface::isotropic(0.5))?;
    assert_eq!(scene.set_friction(0, 0.0), refused);
    assert_eq!(scene.set_friction(0, 0.1), Ok(()));
    scene.clear_contacts();
    let spins = Surface { spin: 0.1, ..Surface::isotropic(0.0) };
    scene.push_on(&contact, &spins)?;
    assert_eq!(scene.set_friction(0, 0.1), refused);
    Ok(())
}

/// The impulses of a body that slides into a corner, to the last bit.
fn impulses<const S: usize>(scene: &Scene<f64, 3, 3, 3, 0, S>) -> Result<Vec<u64>, Error> {
    let (factor, mut solver) = (Factor::new(scene)?, Solver::new());
    let push = vector![-0.7, 0.4, -1.0];
    let solution = solver.solve(scene, &factor, &push, &Settings::new(1e-10))?;
    assert!(solution.is_solved());
    let impulses = solution.contacts.iter().flat_map(|c| c.impulse.iter());
    Ok(impulses.map(|x| x.to_bits()).collect())
}

/// The count counts, not the place.
#[test]
fn as_many_contacts_as_there_is_room_for_may_have_surfaces() -> Result<(), Error> {
    let floor = Contact {
        jacobian: matrix![0.0, 0.0, 1.0; 1.0, 0.0, 0.0; 0.0, 1.0, 0.0],
        offset: SVector::zeros(),
        mu: 0.5,
        key: 0,
    };
    let wall = Contact { jacobian: Matrix3::identity(), key: 1, ..floor };
    let track = Surface { friction: [0.5, 0.2], compliance: [0.1, 0.0], ..Surface::isotropic(0.0) };
    let mut plain = Scene::<f64, 3, 3, 3>::new();
    plain.set_mass(&Matrix3::identity())?;
    plain.push(&wall)?;
    let mut scene = Scene::<f64, 3, 3, 3, 0, 1>::new();
    scene.set_mass(&Matrix3::identity())?;
    assert_eq!(scene.push_on(&floor, &track), Ok(0));
    let (before, alone) = (scene.clone(), impulses(&scene)?);
    let full = Err(Error::ListFull { list: List::Surfaces, capacity: 1 });
    let is_as_before = |scene: &Scene<f64, 3, 3, 3, 0, 1>| -> Result<bool, Error> {
        let is_current = Factor::new(&before)?.is_current(scene);
        Ok(is_current && scene.contacts() == before.contacts() && impulses(scene)? == alone)
    };
    let mut refused = scene.clone();
    assert_eq!(refused.push_on(&wall, &track), full);
    assert!(Factor::new(&before)?.is_current(&refused) && refused.contacts() == before.contacts());
    // One without a surface comes and goes behind it.
    assert_eq!(scene.push(&wall), Ok(1));
    assert_eq!(impulses(&scene)?.len(), 6);
    scene.remove_contact(1)?;
    assert!(is_as_before(&scene)?);
    // And takes its place.
    scene.push(&wall)?;
    scene.remove_contact(0)?;
    assert!(Factor::new(&plain)?.is_current(&scene));
    assert_eq!(impulses(&scene)?, impulses(&plain)?);
    // The surface comes back behind it.
    assert_eq!(scene.push_on(&floor, &track), Ok(1));
    let mut refused = scene.clone();
    refused.remove_contact(0)?;
    assert_eq!(refused.push_on(&wall, &track), full);
    let mut roomy = Scene::<f64, 3, 3, 3, 0, 2>::new();
    roomy.set_mass(&Matrix3::identity())?;
    roomy.push(&wall)?;
    roomy.push_on(&floor, &track)?;
    assert!(Factor::new(&roomy)?.is_current(&scene));
    assert_eq!(impulses(&scene)?, impulses(&roomy)?);
    scene.remove_contact(0)?;
    assert!(is_as_before(&scene)?);
    scene.clear_contacts();
    assert_eq!(scene.push_on(&floor, &track), Ok(0));
    assert!(is_as_before(&scene)?);
    Ok(())
}
