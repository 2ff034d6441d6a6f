//! Classes of scenes with one body: slopes, rods, wedges.

use super::Candidate;
use super::bodies::{Assembly, DOWN, GRAVITY, around, at_rest, corners, set_in_motion};
use super::random::{Random, real};
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// How far the tangent of a slope is from `mu`, relative.
const OFF_LIMIT: [f64; 7] = [0.0, 1e-3, -1e-3, 1e-6, -1e-6, 0.3, -0.3];
/// How far a redundant contact is from its original, m.
const NEARLY: [f64; 5] = [0.0, 1e-12, 1e-9, 1e-6, 1e-3];

pub(super) fn box_on_slope(random: &mut Random) -> (Assembly, Vector3<f64>) {
    let mut bodies = Assembly::new(random.dimension());
    let half = Vector3::new(random.uniform(0.1, 1.0), random.uniform(0.1, 1.0), random.uniform(0.05, 1.5));
    let mu = random.uniform(0.1, 1.2);
    let tangent = mu * (1.0 + random.pick(&OFF_LIMIT));
    let cos = 1.0 / (1.0 + tangent * tangent).sqrt();
    let turned = bodies.dim == 3 && random.one_in(2);
    let azimuth = if turned { random.uniform(0.0, TAU) } else { 0.0 };
    let (y, x) = libm::sincos(azimuth);
    let gravity = Vector3::new(x * tangent, y * tangent, -1.0) * (GRAVITY * cos);
    let mass = random.log_uniform(0.01, 100.0);
    let center = Vector3::new(0.0, 0.0, half.z);
    let body = bodies.push_box(mass, half, center, gravity);
    let yaw = random.uniform(0.0, TAU);
    for corner in corners(bodies.dim, half.x, half.y) {
        bodies.touch((body, None), corner, Vector3::z(), mu, yaw);
    }
    set_in_motion(&mut bodies, random);
    (bodies, half)
}

/// A box on a slope whose tangent is `mu`, or next to it.
pub(super) fn slope(random: &mut Random) -> Candidate {
    at_rest(&box_on_slope(random).0)
}

/// A box on a slope with contacts that are the same, or nearly the same and nearly parallel.
pub(super) fn redundant_slope(random: &mut Random) -> Candidate {
    let (mut bodies, half) = box_on_slope(random);
    let near = random.pick(&NEARLY);
    for _ in 0..random.count(1, 8) {
        let mut shift = || {
            let off_plane = near * random.normal();
            let y = if bodies.dim == 2 { 0.0 } else { off_plane };
            Vector3::new(near * random.normal(), y, 0.0)
        };
        let (move_by, tilt) = (shift(), shift());
        let corner = random.pick(&corners(bodies.dim, half.x, half.y)) + move_by;
        let (mu, yaw) = (random.friction(), random.uniform(0.0, TAU));
        bodies.touch((0, None), corner, Vector3::z() + tilt, mu, yaw);
    }
    at_rest(&bodies)
}

/// A rod that slides on one end, with friction high enough for Painlevé's paradox.
pub(super) fn painleve(random: &mut Random) -> Candidate {
    let mut bodies = Assembly::new(random.dimension());
    let (length, mass) = (random.uniform(0.3, 1.0), random.log_uniform(0.1, 10.0));
    let (rise, run) = libm::sincos(random.uniform(0.2, 1.5));
    let azimuth = random.uniform(0.0, TAU);
    let heading = if bodies.dim == 2 { Vector3::x() } else { around(3, azimuth, 0.0) };
    let inertia = Vector3::repeat(mass * length * length / 3.0);
    let center = Vector3::z() * (length * rise);
    let arm = heading * (length * run) + center;
    let body = bodies.push(mass, inertia, center, DOWN);
    let (mu, yaw) = (random.uniform(0.5, 6.0), random.uniform(0.0, TAU));
    bodies.touch((body, None), center - arm, Vector3::z(), mu, yaw);
    if random.one_in(3) {
        let wall = Vector3::z() * (0.2 * random.normal()) - heading;
        bodies.touch((body, None), center + arm, wall, random.friction(), 0.0);
    }
    let slide = heading * -random.log_uniform(0.01, 10.0);
    bodies.before.fixed_rows_mut::<3>(0).copy_from(&slide);
    if random.one_in(2) {
        bodies.before[2] = -random.normal().abs();
    }
    if random.one_in(2) {
        for dof in [0, 1, 3, 4, 5] {
            bodies.before[dof] += 0.3 * random.normal();
        }
    }
    at_rest(&bodies)
}

/// A body on two to six inclined walls, steep ones among them; some walls move.
///
/// Most moving walls move with one rigid motion, which is in `K*`; a few each for itself, so that
/// no solution need exist.
pub(super) fn wedge(random: &mut Random) -> Candidate {
    let mut bodies = Assembly::new(random.dimension());
    let radius = 0.1;
    let mass = random.log_uniform(0.1, 10.0);
    let body = bodies.push_box(mass, Vector3::repeat(radius), Vector3::zeros(), DOWN);
    let spatial = bodies.dim == 3;
    let walls = random.count(2, if spatial { 6 } else { 3 });
    let (mu, any) = (random.friction(), random.uniform(0.05, 1.4));
    let tilt = random.pick(&[any, any, 1e-3]);
    let regular = if spatial { walls } else { 2 };
    let turn = TAU / real(regular);
    let mut angle = if spatial { random.uniform(0.0, TAU) } else { 0.0 };
    for wall in 0..walls {
        let (rise, run) = libm::sincos(tilt);
        let normal = around(3, angle, 0.0) * run + Vector3::z() * rise;
        let shift = if wall > 2 { 0.05 * random.normal() } else { 0.0 };
        let point = normal * -radius + Vector3::x() * shift;
        bodies.touch((body, None), point, normal, mu, 0.0);
        angle += turn;
    }
    set_in_motion(&mut bodies, random);
    let Candidate { mut scene, witness } = at_rest(&bodies);
    if random.one_in(10) {
        scene.w.iter_mut().for_each(|w| *w = 0.3 * random.normal());
    } else if random.one_in(3) {
        let witness = witness.map(|_| random.normal());
        scene.w = -(&scene.h * &witness);
        return Candidate { scene, witness };
    }
    Candidate { scene, witness }
}
