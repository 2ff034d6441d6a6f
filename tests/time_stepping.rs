//! Bodies followed over many steps: what Moreau-Jean stepping with this kernel keeps of mechanics.

use crate::support::boxes::{BRICK, Cuboid, GRAVITY};
use crate::support::motion::{BALL, Ball, REACH, box_on_slope};
use crate::support::pad;
use nalgebra::{SMatrix, SVector, matrix, vector};
use proptest::prelude::*;
use stiction::time_stepping as law;
use stiction::{Contact, ContactMode, Error, Factor, Scene, Settings, Solver, Status};

#[test]
fn a_sliding_box_stops_after_v_squared_over_two_mu_g() -> Result<(), Error> {
    let (mu, speed) = (0.35, 1.7);
    let expected = speed * speed / (2.0 * mu * GRAVITY);
    let mut errors = Vec::new();
    for step in [8e-3, 4e-3, 2e-3, 1e-3, 5e-4] {
        let mut motion = box_on_slope(&BRICK, mu, 0.0, step)?;
        motion.velocity.x = speed;
        while motion.velocity.x > 1e-6 {
            motion.advance()?;
        }
        errors.push((motion.position.x - expected).abs());
    }
    println!("errors of the stopping distance as h is halved: {errors:?}");
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((0.9..1.1).contains(&order), "order {order}");
    }
    assert!(errors[4] <= 5e-4 * speed);
    Ok(())
}

#[test]
fn a_box_tips_where_its_weight_leaves_its_base() -> Result<(), Error> {
    // 8 x 16 x 20 cm: on friction that holds it, it tips when tan(slope) is above 0.04 / 0.1.
    let cuboid = Cuboid { mass: 2.0, half: [0.04, 0.08, 0.1] };
    let [a, _, c] = cuboid.half;
    for excess in [-0.1, -1e-3, -1e-6, 1e-6, 1e-3, 0.1] {
        let (step, slope) = (0.001, f64::atan(a / c) + excess);
        let mut motion = box_on_slope(&cuboid, 2.0, slope, step)?;
        motion.advance()?;
        let spin = motion.velocity[4];
        // About the lower edge: moment over moment of inertia.
        let inertia = cuboid.mass_matrix()[(4, 4)] + cuboid.mass * (a * a + c * c);
        let moment = cuboid.mass * GRAVITY * (slope.sin() * c - slope.cos() * a);
        let expected = f64::max(step * moment / inertia, 0.0);
        assert!((spin - expected).abs() <= 1e-9, "{excess}: {spin:e} for {expected:e}");
    }
    Ok(())
}

#[test]
fn a_bouncing_ball_rises_to_e_squared_of_its_height() -> Result<(), Error> {
    let (drop, speed) = (1.0, f64::sqrt(2.0 * GRAVITY));
    for (restitution, step) in [(0.5, 1e-3), (0.5, 1e-4), (0.8, 1e-3), (0.8, 1e-4), (1.0, 1e-4)] {
        let ball = Ball { restitution, ..BALL };
        let mut motion = ball.motion::<f64>(step, 1e-10)?;
        motion.position.y = drop;
        let mut heights = Vec::new();
        while heights.len() < 4 {
            let before = motion.velocity.y;
            ball.advance(&mut motion)?;
            if before > 0.0 && motion.velocity.y <= 0.0 {
                heights.push(motion.position.y);
            }
        }
        for (k, height) in (1..).zip(heights) {
            // It bounces within a step of the floor, as far as it falls in one.
            let error = (height - drop * restitution.powi(2 * k)).abs();
            let allowed = f64::from(k) * step * speed;
            assert!(error <= allowed, "e = {restitution}, rebound {k}: {error:e}");
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Friction keeps the angular momentum about the line the ball runs on.
    #[test]
    fn a_ball_with_backspin_ends_up_rolling(
        mu in 0.1..1.0, speed in 1.0..5.0_f64, spin in -40.0..40.0_f64, e in 0.0..0.8,
    ) {
        let ball = Ball { mu, restitution: e, ..BALL };
        let mut motion = ball.motion::<f64>(2e-3, 1e-11)?;
        motion.position.y = 0.02;
        motion.velocity = pad::vector(vector![speed, 0.0, spin]);
        for _ in 0..5_000 {
            ball.advance(&mut motion)?;
        }
        let rolling = 5.0 / 7.0 * speed - 2.0 / 7.0 * ball.radius * spin;
        let size = speed + ball.radius * spin.abs();
        prop_assert!((motion.velocity.x - rolling).abs() <= 1e-9 * size);
        prop_assert!((motion.velocity.x + ball.radius * motion.velocity.z).abs() <= 1e-9 * size);
    }

    /// Two discs with spin hit each other off centre, with friction and restitution.
    #[test]
    fn a_pair_left_alone_keeps_its_momentum(
        masses in [0.1..10.0, 0.1..10.0_f64],
        velocities in [-5.0..5.0, -5.0..5.0, -30.0..30.0, -5.0..5.0, -5.0..5.0, -30.0..30.0_f64],
        angle in -3.0..3.0_f64, mu in 0.0..1.0, e in 0.0..1.0,
    ) {
        let radii = [0.1, 0.17];
        let inertia = |i: usize| masses[i] * radii[i] * radii[i] / 2.0;
        let normal = vector![angle.cos(), angle.sin()];
        let tangent = vector![-normal.y, normal.x];
        // Velocity of the second against the first where they touch; its arm is minus the normal.
        let jacobian = matrix![
            -normal.x, -normal.y, 0.0, normal.x, normal.y, 0.0;
            -tangent.x, -tangent.y, -radii[0], tangent.x, tangent.y, -radii[1]
        ];
        let before = SVector::<f64, 6>::from(velocities);
        let approach = (jacobian * before)[0];
        prop_assume!(approach < -0.01);
        let mut scene = Scene::<f64, 6, 2, 4>::new();
        let masses = vector![masses[0], masses[0], inertia(0), masses[1], masses[1], inertia(1)];
        let mass = SMatrix::from_diagonal(&masses);
        scene.set_mass(&mass)?;
        let offset = vector![law::Restitution { coefficient: e, threshold: 0.0 }.offset(approach, 0.0)?, 0.0];
        scene.push(&Contact { jacobian, offset, mu, key: 0 })?;
        let push = law::free_impulse(&mass, &before, &SVector::zeros(), 1e-3);
        let mut solver = Solver::new();
        let factor = Factor::new(&scene)?;
        let solution = solver.solve(&scene, &factor, &push, &Settings::new(1e-9))?;
        prop_assert_eq!(solution.status, Status::Solved);
        prop_assert!(solution.contacts[0].mode != ContactMode::Open);
        let (after, centres) = (solution.velocity, [vector![0.0, 0.0], normal * (0.1 + 0.17)]);
        let momentum = |v: &SVector<f64, 6>| {
            let p = mass * v;
            let turn = |c: SVector<f64, 2>, i: usize| c.x * p[i + 1] - c.y * p[i] + p[i + 2];
            vector![p[0] + p[3], p[1] + p[4], turn(centres[0], 0) + turn(centres[1], 3)]
        };
        let change = momentum(&after) - momentum(&before);
        let size = (mass * before).abs().sum() + solution.contacts[0].impulse.norm();
        prop_assert!(change.amax() <= 4.0 * f64::EPSILON * size, "{change:?} of {size}");
    }

    #[test]
    fn a_belt_takes_a_box_along_with_its_friction(mu in 0.1..0.8, belt in 0.5..2.0_f64) {
        let step = 0.01;
        let mut motion = box_on_slope(&BRICK, mu, 0.0, step)?;
        let frame = matrix![0.0, 0.0, 1.0; 1.0, 0.0, 0.0; 0.0, 1.0, 0.0];
        let offset = law::moving_surface(&frame, &vector![belt, 0.0, 0.0]);
        for corner in 0..4 {
            motion.scene.set_offset(corner, &offset)?;
        }
        let mut expected = 0.0;
        for _ in 0..300 {
            motion.advance()?;
            expected = f64::min(expected + mu * GRAVITY * step, belt);
            prop_assert!((motion.velocity.x - expected).abs() <= 1e-8 * belt);
        }
        prop_assert!((motion.velocity.x - belt).abs() <= 1e-9 * belt);
    }

    #[test]
    fn what_falls_lands_where_the_floor_is(drop in 1e-3..1.0_f64) {
        let ball = Ball { restitution: 0.0, ..BALL };
        let mut motion = ball.motion::<f64>(1e-3, 1e-10)?;
        motion.position.y = drop;
        for _ in 0..1000 {
            ball.advance(&mut motion)?;
            prop_assert!(motion.position.y >= -1e-12);
        }
        prop_assert!(motion.position.y <= 1e-12);
    }

    /// What is left of that speed when it is out makes a small leap.
    #[test]
    fn penetration_is_removed_at_a_bounded_speed(depth in 1e-3..0.1_f64, recovery in 0.05..0.5_f64) {
        let mut motion = BALL.motion::<f64>(1e-3, 1e-10)?;
        motion.position.y = -depth;
        while motion.position.y < -1e-9 {
            let before = motion.position.y;
            motion.offset(0, law::Gap { distance: before, recovery, reach: REACH }.offset(motion.step)?)?;
            motion.advance()?;
            prop_assert!(motion.velocity.y <= recovery * (1.0 + 1e-9));
            let expected = f64::min(before + 1e-3 * recovery, 0.0);
            prop_assert!(motion.position.y >= expected - 1e-9);
        }
        let leap = recovery * (1e-3 + recovery / (2.0 * GRAVITY));
        for _ in 0..1000 {
            motion.offset(0, law::Gap { distance: motion.position.y, recovery, reach: REACH }.offset(motion.step)?)?;
            motion.advance()?;
            prop_assert!((-1e-9..=leap).contains(&motion.position.y));
        }
        prop_assert!(motion.position.y.abs() <= 1e-9);
    }
}
