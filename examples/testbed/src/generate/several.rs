//! Classes of scenes with several bodies, stacks and hands, and their surfaces in motion.

use super::Candidate;
use super::bodies::{Assembly, DOWN, GRAVITY, STEP, around, at_rest, corners, set_in_motion};
use super::random::{Random, real};
use super::single::box_on_slope;
use nalgebra::{DVector, Vector3};
use std::f64::consts::{PI, TAU};

/// A stack, and the motion that opens all its contacts.
fn pile(random: &mut Random) -> (Assembly, DVector<f64>) {
    let dim = random.dimension();
    let mut bodies = Assembly::new(dim);
    let count = random.count(2, if dim == 2 { 5 } else { 3 });
    let any = random.log_uniform(1.0, 1e6);
    let ratio = random.pick(&[any, any, 1e6]);
    let mut below: Option<(usize, Vector3<f64>)> = None;
    let mut height = 0.0;
    for level in 0..count {
        let half =
            Vector3::new(random.uniform(0.2, 0.5), random.uniform(0.2, 0.5), random.uniform(0.05, 0.8));
        let heavy = if level + 1 == count { ratio } else { random.pick(&[1.0, ratio.sqrt()]) };
        let mass = if random.one_in(6) { 1.0 / heavy } else { heavy };
        let center = Vector3::new(0.0, 0.0, height + half.z);
        let body = bodies.push_box(mass, half, center, DOWN);
        let support = below.map_or(half, |(_, lower)| lower.inf(&half));
        let mu = random.friction();
        for corner in corners(dim, support.x, support.y) {
            let point = corner + Vector3::z() * height;
            let other = below.map(|(body, _)| body);
            bodies.touch((body, other), point, Vector3::z(), mu, 0.0);
        }
        if random.one_in(4) {
            let push = mass * GRAVITY * STEP * random.uniform(0.0, 1.5);
            bodies.push_with(body, Vector3::x() * push);
        }
        below = Some((body, half));
        height += 2.0 * half.z;
    }
    set_in_motion(&mut bodies, random);
    let mut opening = DVector::zeros(6 * count);
    let mut speed = 0.0;
    for body in 0..count {
        speed += 1.0;
        opening[6 * body + 2] = speed;
    }
    (bodies, opening)
}

/// Two to five boxes on each other, masses up to 1e6 apart.
pub(super) fn stack(random: &mut Random) -> Candidate {
    at_rest(&pile(random).0)
}

/// A grasped object, and the motion that lets it go.
fn grasp(random: &mut Random) -> (Assembly, DVector<f64>) {
    let dim = random.dimension();
    let mut bodies = Assembly::new(dim);
    let (radius, finger) = (random.uniform(0.02, 0.1), 0.02);
    let mass = random.log_uniform(0.01, 10.0);
    let half = Vector3::repeat(radius);
    let object = bodies.push_box(mass, half, Vector3::zeros(), DOWN);
    let squeeze = random.log_uniform(0.1, 100.0) * GRAVITY * mass * STEP;
    let ratio = random.log_uniform(1.0, 1e6);
    let mu = random.friction();
    let (fingers, start) = (random.count(2, 4), random.uniform(0.0, TAU));
    let mut opening = DVector::zeros(6 * (fingers + 1));
    let mut angle = start;
    for _ in 0..fingers {
        let lift = random.pick(&[0.0, 0.3]) * random.normal();
        let outward = around(dim, angle + random.pick(&[0.0, 0.2]) * random.normal(), lift);
        let side = around(dim, angle + PI / 2.0, 0.0);
        angle += TAU / real(fingers);
        let (half, center) = (Vector3::repeat(finger), outward * (radius + finger));
        let body = bodies.push_box(mass / ratio, half, center, DOWN);
        bodies.push_with(body, outward * -squeeze);
        opening.fixed_rows_mut::<3>(6 * body).copy_from(&outward);
        for _ in 0..random.count(1, 3) {
            let point = outward * radius + side * (0.01 * random.normal());
            let yaw = random.uniform(0.0, TAU);
            bodies.touch((object, Some(body)), point, -outward, mu, yaw);
        }
    }
    if random.one_in(3) {
        set_in_motion(&mut bodies, random);
    }
    (bodies, opening)
}

/// An object between two to four fingers, each a free body, masses up to 1e6 apart.
pub(super) fn hand(random: &mut Random) -> Candidate {
    at_rest(&grasp(random).0)
}

/// A slope, stack or hand whose surfaces move, whose bodies bounce, or whose gaps are open.
///
/// The opening motion, fast enough, is in `K*` whatever the surfaces do.
pub(super) fn moving(random: &mut Random) -> Candidate {
    let (bodies, opening) = match random.count(0, 2) {
        0 => (box_on_slope(random).0, DVector::from_row_slice(&[0.0, 0.0, 1.0, 0.0, 0.0, 0.0])),
        1 => pile(random),
        _ => grasp(random),
    };
    let mut scene = bodies.scene();
    let approach = &scene.h * bodies.dofs(&bodies.before);
    let opening = bodies.dofs(&opening);
    let restitution = random.pick(&[0.0, 0.5, 1.0]);
    let mut speed = 0.0_f64;
    for (i, &mu) in scene.mu.iter().enumerate() {
        let normal = i * scene.dim;
        let gap = random.pick(&[0.0, 0.3]) * random.normal().abs();
        scene.w[normal] = gap + restitution * approach[normal].min(0.0);
        let mut belt = scene.w.rows_mut(normal + 1, scene.dim - 1);
        belt.iter_mut().for_each(|w| *w = random.pick(&[0.0, 0.5]) * random.normal());
        let needed = mu * belt.norm() - scene.w[normal];
        speed = speed.max(1.01 * needed / scene.h.row(normal).dot(&opening.transpose()));
    }
    let witness = opening * speed;
    Candidate { scene, witness }
}
