//! Random bodies at rest.

use crate::body::{Body, Brake, Foot, GRAVITY, Kind};
use crate::limit::{holds_weight, largest_load};
use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, Vector3, vector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::TAU;
use stiction::contact_frame;

/// The Go2 as it stands.
const GO2: &str = include_str!("../../tests/scenes/go2_stand.json");

/// Torque of a Go2's motor, N·m.
const GO2_TORQUE: f64 = 23.7;

/// The weight alone is to be held by less of friction than weight and load.
const WEIGHT_SHARE: f64 = 0.97;

struct Random(Pcg64Mcg);

impl Random {
    /// With four digits, so that a file of bodies stays short.
    fn uniform(&mut self, low: f64, high: f64) -> f64 {
        short(low + (high - low) * self.0.random::<f64>())
    }

    fn exp(&mut self, low: f64, high: f64) -> f64 {
        short(self.uniform(low, high).exp())
    }

    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.0.random::<f64>()).ln()).sqrt();
        radius * (TAU * self.0.random::<f64>()).cos()
    }

    fn chance(&mut self, share: f64) -> bool {
        self.0.random::<f64>() < share
    }
}

fn short(x: f64) -> f64 {
    (x * 1e4).round() / 1e4
}

/// Loaded with the largest load of full friction along a direction if `is_critical`, else with that of 0.6 to 0.95 of friction.
pub(crate) fn body(seed: u64, index: u64, is_critical: bool) -> Body {
    let mut random = Random(Pcg64Mcg::seed_from_u64(seed.rotate_left(32) ^ index));
    let turn = usize::try_from(index).unwrap_or(0) % Kind::ALL.len();
    loop {
        let mut body = match Kind::ALL[turn] {
            kind @ (Kind::Free | Kind::Held) => go2(kind, &mut random),
            kind => rigid(kind, &mut random),
        };
        let share = random.uniform(0.6, 0.95);
        let share = if is_critical { 1.0 } else { share };
        let direction = direction(&body, share, &mut random);
        if let Some((largest, force)) = largest_load(&body, share, &direction)
            && (1e-3..20.0).contains(&largest)
            && holds_weight(&body, WEIGHT_SHARE * share, &direction)
        {
            body.load = direction * (largest * (1.0 - 1e-6));
            body.force = force;
            return body;
        }
    }
}

/// The direction of a load, of the size of the weight.
fn direction(body: &Body, share: f64, random: &mut Random) -> DVector<f64> {
    if body.kind == Kind::Free {
        // Joints that nothing holds bear no other load than forces of the feet.
        return held_by_feet(body, share, random) - &body.weight;
    }
    let lever = match body.kind {
        Kind::Held => 0.3,
        _ => body.feet[0].point[..2].iter().map(|x| x.abs()).sum::<f64>() / 2.0,
    };
    let mut direction = DVector::zeros(body.weight.len());
    for (i, entry) in direction.iter_mut().take(6).enumerate() {
        *entry = random.normal() * if i < 3 { 1.0 } else { lever };
    }
    let weight = body.kilograms() * GRAVITY;
    direction.normalize() * weight
}

/// What random forces of the feet hold, at up to this share of friction.
fn held_by_feet(body: &Body, share: f64, random: &mut Random) -> DVector<f64> {
    let mut forces = DVector::zeros(3 * body.mu.len());
    for (i, mu) in body.mu.iter().enumerate() {
        let (normal, angle) = (random.uniform(5.0, 80.0), random.uniform(0.0, TAU));
        let part = if random.chance(0.5) { 1.0 } else { random.uniform(0.0, 1.0) };
        let tangent = share * part * mu * normal;
        let force = [normal, tangent * angle.cos(), tangent * angle.sin()];
        forces.rows_mut(3 * i, 3).copy_from_slice(&force);
    }
    -body.jacobian.tr_mul(&forces)
}

fn go2(kind: Kind, random: &mut Random) -> Body {
    let scene: serde_json::Value = serde_json::from_str(GO2).expect("it is a scene");
    let matrix = |name: &str| {
        let rows = scene[name].as_array().expect("it is a matrix");
        let entries = rows.iter().flat_map(|row| row.as_array().expect("it is a row"));
        let entries = entries.map(|entry| entry.as_f64().expect("it is a number"));
        DMatrix::from_row_iterator(rows.len(), 18, entries)
    };
    let (mass, jacobian) = (matrix("M"), matrix("H"));
    let mu = vec![random.uniform(0.3, 1.0); jacobian.nrows() / 3];
    let slope = random.uniform(0.0, 0.5);
    let fall = mass.column(0) * slope.sin() + mass.column(2) * slope.cos();
    let is_locked = random.chance(0.3);
    let torque = if is_locked { f64::INFINITY } else { GO2_TORQUE };
    let brakes = (6..18).map(|column| Brake { column, torque });
    let mut body = Body {
        kind,
        weight: fall * -GRAVITY,
        load: DVector::zeros(18),
        brakes: if kind == Kind::Held { brakes.collect() } else { Vec::new() },
        mass,
        jacobian,
        mu,
        force: 0.0,
        feet: Vec::new(),
        radius: 0.0,
    };
    if kind == Kind::Free {
        body.weight = held_by_feet(&body, 0.4, random);
    }
    body
}

/// A box or a body on wheels. Its axes are those of the slope: down, across, out of it.
fn rigid(kind: Kind, random: &mut Random) -> Body {
    let mass = random.exp(-1.0, 3.0);
    let half: [f64; 3] = [0; 3].map(|_| random.exp(-2.5, -1.0));
    let slope = random.uniform(0.0, 0.5);
    let feet = feet(kind, half, random);
    let wheels = if kind == Kind::Rover { feet.len() } else { 0 };
    let n = 6 + wheels;
    let radius = short(0.8 * half[2]);
    let [a, b, c] = half.map(|half| half * half);
    let inertia = vector![b + c, a + c, a + b] * (mass / 3.0);
    let wheel = short(mass / 40.0 * radius * radius * 1e4) / 1e4;
    let masses = DVector::from_fn(n, |i, _| match i {
        0..3 => mass,
        3..6 => short(inertia[i - 3] * 1e3) / 1e3,
        _ => wheel,
    });
    let mut weight = DVector::zeros(n);
    weight[0] = -mass * GRAVITY * slope.sin();
    weight[2] = -mass * GRAVITY * slope.cos();
    let mut jacobian = DMatrix::zeros(3 * feet.len(), n);
    for (i, foot) in feet.iter().enumerate() {
        let normal = Vector3::from(foot.normal).normalize();
        let frame = contact_frame(&normal).expect("its length is 1");
        let mut velocity = DMatrix::zeros(3, n); // along the slope by a wheel that turns forward, too
        velocity.view_mut((0, 0), (3, 6)).copy_from(&point(foot));
        if wheels > 0 {
            velocity[(0, 6 + i)] = -radius;
        }
        let rows = frame.transpose() * velocity;
        jacobian.rows_mut(3 * i, 3).copy_from(&rows);
    }
    let same = random.uniform(0.3, 1.0);
    let is_same = random.chance(0.7);
    let mu: Vec<f64> = feet
        .iter()
        .map(|_| {
            let own = random.uniform(0.3, 1.0);
            if is_same { same } else { own }
        })
        .collect();
    let grip = same * mass * GRAVITY / 4.0 * radius;
    let brakes = (6..n).map(|column| Brake {
        column,
        torque: if random.chance(0.25) {
            f64::INFINITY
        } else {
            short(grip * random.uniform(0.3, 2.0) * 1e2) / 1e2
        },
    });
    Body {
        kind,
        mass: DMatrix::from_diagonal(&masses),
        brakes: brakes.collect(),
        load: DVector::zeros(n),
        jacobian,
        mu,
        weight,
        force: 0.0,
        feet,
        radius,
    }
}

/// Velocity of a point of a rigid body.
fn point(foot: &Foot) -> SMatrix<f64, 3, 6> {
    let mut velocity = SMatrix::<f64, 3, 6>::zeros();
    velocity.fixed_columns_mut::<3>(0).copy_from(&Matrix3::identity());
    let arm = Vector3::from(foot.point).cross_matrix();
    velocity.fixed_columns_mut::<3>(3).copy_from(&-arm);
    velocity
}

fn feet(kind: Kind, [x, y, z]: [f64; 3], random: &mut Random) -> Vec<Foot> {
    let up = [0.0, 0.0, 1.0];
    let foot = |point| Foot { point, normal: up };
    let corners = [(x, y), (x, -y), (-x, y), (-x, -y)].map(|(x, y)| [x, y, -z]);
    let mut feet = Vec::from(corners.map(foot));
    match kind {
        Kind::Box8 => {
            let sides = [(x, 0.0), (-x, 0.0), (0.0, y), (0.0, -y)];
            feet.extend(sides.map(|(x, y)| foot([x, y, -z])));
        }
        Kind::Uneven => {
            for foot in &mut feet {
                let [x, y, z] = foot.point;
                foot.point = [
                    short(x * random.uniform(0.7, 1.2)),
                    short(y * random.uniform(0.7, 1.2)),
                    short(z * random.uniform(0.5, 1.5)),
                ];
                foot.normal = up.map(|n| short(n + 0.25 * random.normal()));
            }
        }
        Kind::Corner => {
            let normal = [1.0, 0.0, 0.0];
            for (y, z) in [(-y, -z), (y, z)] {
                let point = [-x, y, short(0.5 * z)];
                feet.push(Foot { point, normal });
            }
        }
        _ => {}
    }
    feet
}
