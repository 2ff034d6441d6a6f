//! Statements of mechanics: what boxes, balls and blocks do under Coulomb's law.

use crate::support::boxes::{BRICK, GRAVITY};
use crate::support::pad;
use crate::support::random::{draws, scenes};
use crate::support::sizes::spinning;
use nalgebra::{DMatrix, DVector, Matrix4, SMatrix, SVector, matrix, vector};
use proptest::prelude::*;
use stiction::{Contact, ContactMode, Error, Model, Scene, Settings, SlipUpdate, Status, Surface};
use testbed::measure::{Law, error_of, impulses};
use testbed::method::Method;

const STEP: f64 = 0.01;

fn exactly() -> Settings<f64> {
    Settings { budget: 10_000, ..Settings::new(1e-12) }
}

/// A point mass of 2 kg over a floor; normal `z` first.
fn ball(mu: f64, offset: SVector<f64, 3>) -> Result<Scene<f64, 3, 3, 3>, Error> {
    let mut scene = Scene::new();
    scene.set_mass(&SMatrix::from_diagonal_element(2.0))?;
    scene.push(&Contact {
        jacobian: matrix![0.0, 0.0, 1.0; 1.0, 0.0, 0.0; 0.0, 1.0, 0.0],
        offset,
        mu,
        key: 0,
    })?;
    Ok(scene)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn a_box_below_the_friction_angle_stays_put(mu in 0.1..1.5, share in 0.0..0.98) {
        let (scene, slope) = (BRICK.on_plane(mu)?, f64::atan(mu) * share);
        let push = BRICK.free_impulse(slope, STEP);
        let solution = Method::Default.solve(&scene, &push, &exactly())?;
        prop_assert_eq!(solution.status, Status::Solved);
        prop_assert!(solution.velocity.norm() <= 1e-9 * GRAVITY * STEP);
    }

    #[test]
    fn a_box_above_the_friction_angle_slides_as_on_paper(mu in 0.0..0.8, excess in 0.02..0.5) {
        let (scene, slope) = (BRICK.on_plane(mu)?, f64::atan(mu) + excess);
        let push = BRICK.free_impulse(slope, STEP);
        let solution = Method::Default.solve(&scene, &push, &exactly())?;
        prop_assert_eq!(solution.status, Status::Solved);
        let speed = STEP * GRAVITY * (slope.sin() - mu * slope.cos());
        let expected = vector![speed, 0.0, 0.0, 0.0, 0.0, 0.0];
        prop_assert!((solution.velocity - expected).norm() <= 1e-8 * GRAVITY * STEP);
    }

    /// `v_N = mu v_T` and `v_T = h g (sin - mu cos) / (1 + mu²)`, where Coulomb's law has `v_N = 0`.
    #[test]
    fn the_convex_relaxation_lifts_a_sliding_box(mu in 0.05..0.8, excess in 0.02..0.5) {
        let (scene, slope) = (BRICK.on_plane(mu)?, f64::atan(mu) + excess);
        let push = BRICK.free_impulse(slope, STEP);
        let relaxed = Settings { model: Model::ConvexRelaxation, ..exactly() };
        let solution = Method::Default.solve(&scene, &push, &relaxed)?;
        prop_assert_eq!(solution.status, Status::Solved);
        prop_assert!(error_of(&scene, &push, &solution, Law::Relaxed) <= relaxed.tolerance);
        prop_assert!(error_of(&scene, &push, &solution, Law::Coulomb) > 1e-3 * mu * excess);
        let speed = STEP * GRAVITY * (slope.sin() - mu * slope.cos()) / (1.0 + mu * mu);
        let expected = vector![speed, 0.0, mu * speed, 0.0, 0.0, 0.0];
        prop_assert!((solution.velocity - expected).norm() <= 1e-8 * GRAVITY * STEP);
    }

    #[test]
    fn an_outer_loop_finds_what_every_iteration_finds(mu in 0.1..0.8, slope in 0.1..0.9) {
        let scene = BRICK.on_plane(mu)?;
        let push = BRICK.free_impulse(slope, STEP);
        let settings = Settings { budget: 20_000, ..Settings::new(1e-9) };
        for method in [Method::Plain, Method::Restart] {
            let solve = |update| method.solve_with(update, &scene, &push, &settings);
            let [inner, outer] = [SlipUpdate::EveryIteration, SlipUpdate::OuterLoop].map(solve);
            let (inner, outer) = (inner?, outer?);
            prop_assert_eq!((inner.status, outer.status), (Status::Solved, Status::Solved));
            prop_assert!((inner.velocity - outer.velocity).norm() <= 1e-6 * GRAVITY * STEP);
        }
    }

    /// `min ½ vᵀMv + fᵀv` with `u_N >= 0`: the one of `2^C` sets of closed contacts without
    /// pulling and without penetration. The objective is strongly convex: the square of the
    /// distance is a multiple of what is left of the complementarity.
    #[test]
    fn a_frictionless_scene_is_a_quadratic_programme((scene, push) in scenes::<6, 3, 4>(4, 0.0)) {
        let solution = Method::Default.solve(&scene, &push, &exactly())?;
        prop_assert_eq!(solution.status, Status::Solved);
        let expected = active_set(&scene, &push);
        let difference = (solution.velocity - expected).norm();
        prop_assert!(difference <= exactly().tolerance.sqrt() * push.norm(), "{difference:e}");
    }

    #[test]
    fn one_row_contacts_are_a_quadratic_programme((scene, push) in scenes::<5, 1, 4>(4, 1.0)) {
        let solution = Method::Default.solve(&scene, &push, &exactly())?;
        prop_assert_eq!(solution.status, Status::Solved);
        let expected = active_set(&scene, &push);
        let difference = (solution.velocity - expected).norm();
        prop_assert!(difference <= exactly().tolerance.sqrt() * push.norm(), "{difference:e}");
    }

    /// `u_N + e u_N⁻ >= 0`: Newton's restitution as an offset.
    #[test]
    fn a_ball_bounces_with_its_restitution(e in 0.0..1.0_f64, speed in 0.1..10.0_f64, mu in 0.0..1.0) {
        let scene = ball(mu, vector![-(e * speed), 0.0, 0.0])?;
        let push = vector![0.0, 0.0, -2.0 * speed];
        let solution = Method::Default.solve(&scene, &push, &exactly())?;
        prop_assert_eq!(solution.status, Status::Solved);
        prop_assert!((solution.velocity.z - e * speed).abs() <= 1e-9 * speed);
    }

    #[test]
    fn no_contact_leaves_the_free_velocity((full, push) in scenes::<6, 3, 4>(2, 1.0)) {
        let mut scene = full;
        scene.clear_contacts();
        let free = scene.mass().cholesky().expect("positive definite").solve(&push);
        for method in Method::ALL {
            let solution = method.solve(&scene, &push, &exactly())?;
            prop_assert_eq!((solution.status, solution.work.total()), (Status::Solved, 0));
            prop_assert!(solution.contacts.is_empty());
            prop_assert!((solution.velocity - free).norm() <= 1e-14 * free.norm());
        }
    }

    #[test]
    fn without_an_impulse_nothing_moves((scene, _) in scenes::<6, 3, 4>(2, 1.0)) {
        for method in Method::ALL {
            let solution = method.solve(&scene, &SVector::zeros(), &Settings::new(0.0))?;
            prop_assert_eq!((solution.status, solution.work.total()), (Status::Solved, 0));
            prop_assert!(solution.velocity.iter().all(|&v| v == 0.0));
            prop_assert!(impulses(&solution).iter().all(|&r| r == 0.0));
            prop_assert!(solution.error.to_bits() == 0);
        }
    }

    #[test]
    fn a_planar_block_sticks_or_slides(mu in 0.05..1.0, slope in 0.05..1.0) {
        prop_assume!(f64::abs(mu - f64::tan(slope)) > 1e-3);
        let mut scene = Scene::<f64, 2, 2, 2>::new();
        scene.set_mass(&SMatrix::from_diagonal_element(3.0))?;
        scene.push(&Contact {
            jacobian: matrix![0.0, 1.0; 1.0, 0.0],
            offset: SVector::zeros(),
            mu,
            key: 0,
        })?;
        let impulse = 3.0 * GRAVITY * STEP;
        let push = vector![impulse * slope.sin(), -impulse * slope.cos()];
        let solution = Method::Default.solve(&scene, &push, &exactly())?;
        let speed = GRAVITY * STEP * (slope.sin() - mu * slope.cos()).max(0.0);
        prop_assert_eq!(solution.status, Status::Solved);
        prop_assert!((solution.velocity - vector![speed, 0.0]).norm() <= 1e-9 * GRAVITY * STEP);
        let sticks = solution.contacts[0].mode == ContactMode::Stick;
        prop_assert_eq!(sticks, f64::tan(slope) < mu);
    }

    /// Dofs (x, y, z, spin); the fourth row is the spin times the radius of the patch.
    #[test]
    fn a_spinning_disc_is_braked_by_torsional_friction(mu in 0.05..1.0, spin in 1.0..50.0) {
        let (mass, inertia, radius) = (0.5, 0.002, 0.03);
        let mut kernel = spinning::Kernel::<f64>::new();
        let scene = kernel.scene_mut();
        scene.set_mass(&pad::mass(&Matrix4::from_diagonal(&vector![mass, mass, mass, inertia])))?;
        let disc = Contact {
            jacobian: pad::jacobian(&matrix![
                0.0, 0.0, 1.0, 0.0;
                1.0, 0.0, 0.0, 0.0;
                0.0, 1.0, 0.0, 0.0;
                0.0, 0.0, 0.0, radius
            ]),
            offset: SVector::zeros(),
            mu,
            key: 0,
        };
        scene.push_on(&disc, &Surface { spin: mu, ..Surface::isotropic(mu) })?;
        let weight = mass * GRAVITY * STEP;
        let push = pad::vector(vector![0.0, 0.0, -weight, inertia * spin]);
        let solution = kernel.solve(&push, &exactly())?;
        let left = f64::max(spin - radius * mu * weight / inertia, 0.0);
        prop_assert_eq!(solution.status, Status::Solved);
        prop_assert!((solution.velocity - SVector::ith(3, left)).norm() <= 1e-8 * spin);
    }
}

#[test]
fn an_impact_never_gains_energy() -> Result<(), Error> {
    let mut solved = 0;
    for (scene, push) in draws(scenes::<6, 3, 4>(3, 1.5), 256) {
        let energy = |v: SVector<f64, 6>| v.dot(&(scene.mass() * v)) / 2.0;
        let free = scene.mass().cholesky().expect("positive definite").solve(&push);
        let solution = Method::Default.solve(&scene, &push, &exactly())?;
        if solution.status != Status::Solved {
            continue;
        }
        solved += 1;
        let gain = energy(solution.velocity) / energy(free) - 1.0;
        assert!(gain <= 1e-9, "{gain:e}");
        for contact in &solution.contacts {
            let work = contact.impulse.dot(&contact.velocity);
            assert!(work <= 1e-9 * energy(free), "a contact works: {work:e}");
        }
    }
    assert!(solved >= 254, "{solved} of 256");
    Ok(())
}

#[test]
fn a_box_exactly_at_the_friction_angle_is_solved() -> Result<(), Error> {
    for mu in [0.1, 0.25, 0.5, 1.0] {
        let scene = BRICK.on_plane(mu)?;
        let push = BRICK.free_impulse(f64::atan(mu), STEP);
        let solution = Method::Default.solve(&scene, &push, &Settings::new(1e-9))?;
        assert_eq!(solution.status, Status::Solved, "mu = {mu}");
        let error = error_of(&scene, &push, &solution, Law::Coulomb);
        assert!(error <= 1e-9, "mu = {mu}: {error:e}");
        assert!(solution.velocity.norm() <= 1e-6 * GRAVITY * STEP);
    }
    Ok(())
}

/// Velocity of the frictionless scene, by trying every set of closed contacts.
fn active_set<const N: usize, const D: usize, const C: usize>(
    scene: &Scene<f64, N, D, C>,
    push: &SVector<f64, N>,
) -> SVector<f64, N> {
    let mass = scene.mass().cholesky().expect("M is positive definite");
    let free = mass.solve(push);
    let normals = SMatrix::<f64, C, N>::from_fn(|i, j| scene.contacts()[i].jacobian[(0, j)]);
    let reach = mass.solve(&normals.transpose());
    let (delassus, speeds) = (normals * reach, normals * free);
    let candidates = (0_u32..1 << C).filter_map(|set| {
        let closed = |i: usize| set >> i & 1 == 1;
        // An open contact has the equation r = 0, a closed one W r = -u_free.
        let matrix = SMatrix::<f64, C, C>::from_fn(|i, j| match (closed(i), closed(j)) {
            (true, true) => delassus[(i, j)],
            _ => f64::from(u8::from(i == j)),
        });
        let rhs = SVector::<f64, C>::from_fn(|i, _| if closed(i) { -speeds[i] } else { 0.0 });
        let impulses = DMatrix::from_column_slice(C, C, matrix.as_slice())
            .lu()
            .solve(&DVector::from_column_slice(rhs.as_slice()))?;
        let impulses = SVector::<f64, C>::from_column_slice(impulses.as_slice());
        let v = free + reach * impulses;
        let pulls = impulses.iter().any(|&r| r < 0.0);
        let penetrates = (normals * v).iter().any(|&u| u < -1e-12);
        (!pulls && !penetrates).then_some(v)
    });
    let candidates: Vec<_> = candidates.collect();
    assert!(!candidates.is_empty(), "a quadratic programme has a solution");
    candidates[0]
}
