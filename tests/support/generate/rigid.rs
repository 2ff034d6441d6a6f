//! Classes of scenes made of rigid bodies: slopes, stacks, hands, rods, wedges.

use super::Candidate;
use super::bodies::{Assembly, GRAVITY, STEP};
use super::random::{Random, real};
use nalgebra::{DVector, Vector3};
use std::f64::consts::{PI, TAU};

/// How far the tangent of a slope is from `mu`, relative.
const OFF_LIMIT: [f64; 7] = [0.0, 1e-3, -1e-3, 1e-6, -1e-6, 0.3, -0.3];
/// How far a redundant contact is from its original, m.
const NEARLY: [f64; 5] = [0.0, 1e-12, 1e-9, 1e-6, 1e-3];
const DOWN: Vector3<f64> = Vector3::new(0.0, 0.0, -GRAVITY);

/// Spatial three times in four.
pub fn dimension(random: &mut Random) -> usize {
    random.pick(&[2, 3, 3, 3])
}

/// `w = 0`: rest is in `K*`.
fn at_rest(bodies: &Assembly) -> Candidate {
    let scene = bodies.scene();
    let witness = DVector::zeros(scene.n_dof);
    Candidate { scene, witness }
}

/// The corners of a rectangle, or the ends of a segment in the plane.
fn corners(dim: usize, x: f64, y: f64) -> Vec<Vector3<f64>> {
    if dim == 2 {
        return [-x, x].map(|x| Vector3::new(x, 0.0, 0.0)).to_vec();
    }
    [(-x, -y), (-x, y), (x, -y), (x, y)]
        .map(|(x, y)| Vector3::new(x, y, 0.0))
        .to_vec()
}

/// A unit vector at an angle around the vertical, or in the vertical plane.
fn around(dim: usize, angle: f64, lift: f64) -> Vector3<f64> {
    let (sin, cos) = libm::sincos(angle);
    if dim == 2 {
        Vector3::new(cos, 0.0, sin)
    } else {
        Vector3::new(cos, sin, lift).normalize()
    }
}

/// Rest, any motion, sliding or spinning.
fn set_in_motion(bodies: &mut Assembly, random: &mut Random) {
    let dofs: &[usize] = random.pick(&[&[][..], &[0, 1, 2, 3, 4, 5], &[0, 1], &[5]]);
    for body in 0..bodies.len() {
        for dof in dofs {
            bodies.before[6 * body + dof] = random.normal();
        }
    }
}

fn box_on_slope(random: &mut Random) -> (Assembly, Vector3<f64>) {
    let mut bodies = Assembly::new(dimension(random));
    let half = Vector3::new(
        random.uniform(0.1, 1.0),
        random.uniform(0.1, 1.0),
        random.uniform(0.05, 1.5),
    );
    let mu = random.uniform(0.1, 1.2);
    let tangent = mu * (1.0 + random.pick(&OFF_LIMIT));
    let cos = 1.0 / (1.0 + tangent * tangent).sqrt();
    let turned = bodies.dim == 3 && random.one_in(2);
    let azimuth = if turned {
        random.uniform(0.0, TAU)
    } else {
        0.0
    };
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
pub fn slope(random: &mut Random) -> Candidate {
    at_rest(&box_on_slope(random).0)
}

/// A box on a slope with contacts that are the same, or nearly the same and nearly parallel.
pub fn redundant_slope(random: &mut Random) -> Candidate {
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

/// A stack, and the motion that opens all its contacts.
fn pile(random: &mut Random) -> (Assembly, DVector<f64>) {
    let dim = dimension(random);
    let mut bodies = Assembly::new(dim);
    let count = random.count(2, if dim == 2 { 5 } else { 3 });
    let any = random.log_uniform(1.0, 1e6);
    let ratio = random.pick(&[any, any, 1e6]);
    let mut below: Option<(usize, Vector3<f64>)> = None;
    let mut height = 0.0;
    for level in 0..count {
        let half = Vector3::new(
            random.uniform(0.2, 0.5),
            random.uniform(0.2, 0.5),
            random.uniform(0.05, 0.8),
        );
        let heavy = if level + 1 == count {
            ratio
        } else {
            random.pick(&[1.0, ratio.sqrt()])
        };
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
pub fn stack(random: &mut Random) -> Candidate {
    at_rest(&pile(random).0)
}

/// A grasped object, and the motion that lets it go.
fn grasp(random: &mut Random) -> (Assembly, DVector<f64>) {
    let dim = dimension(random);
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
        let outward = around(
            dim,
            angle + random.pick(&[0.0, 0.2]) * random.normal(),
            lift,
        );
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
pub fn hand(random: &mut Random) -> Candidate {
    at_rest(&grasp(random).0)
}

/// A slope, stack or hand whose surfaces move, whose bodies bounce, or whose gaps are open.
///
/// The opening motion, fast enough, is in `K*` whatever the surfaces do.
pub fn moving(random: &mut Random) -> Candidate {
    let (bodies, opening) = match random.count(0, 2) {
        0 => (
            box_on_slope(random).0,
            DVector::from_row_slice(&[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
        ),
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
        belt.iter_mut()
            .for_each(|w| *w = random.pick(&[0.0, 0.5]) * random.normal());
        let needed = mu * belt.norm() - scene.w[normal];
        speed = speed.max(1.01 * needed / scene.h.row(normal).dot(&opening.transpose()));
    }
    let witness = opening * speed;
    Candidate { scene, witness }
}

/// A rod that slides on one end, with friction high enough for Painlevé's paradox.
pub fn painleve(random: &mut Random) -> Candidate {
    let mut bodies = Assembly::new(dimension(random));
    let (length, mass) = (random.uniform(0.3, 1.0), random.log_uniform(0.1, 10.0));
    let (rise, run) = libm::sincos(random.uniform(0.2, 1.5));
    let azimuth = random.uniform(0.0, TAU);
    let heading = if bodies.dim == 2 {
        Vector3::x()
    } else {
        around(3, azimuth, 0.0)
    };
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
pub fn wedge(random: &mut Random) -> Candidate {
    let mut bodies = Assembly::new(dimension(random));
    let radius = 0.1;
    let mass = random.log_uniform(0.1, 10.0);
    let body = bodies.push_box(mass, Vector3::repeat(radius), Vector3::zeros(), DOWN);
    let spatial = bodies.dim == 3;
    let walls = random.count(2, if spatial { 6 } else { 3 });
    let (mu, any) = (random.friction(), random.uniform(0.05, 1.4));
    let tilt = random.pick(&[any, any, 1e-3]);
    let regular = if spatial { walls } else { 2 };
    let turn = TAU / real(regular);
    let mut angle = if spatial {
        random.uniform(0.0, TAU)
    } else {
        0.0
    };
    for wall in 0..walls {
        let (rise, run) = libm::sincos(tilt);
        let normal = around(3, angle, 0.0) * run + Vector3::z() * rise;
        let shift = if wall > 2 {
            0.05 * random.normal()
        } else {
            0.0
        };
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
