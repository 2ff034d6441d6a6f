//! A body at rest under a load that friction can hold stays, though Coulomb's law may have another solution which slides. One that
//! friction cannot hold leaves.

use crate::support::boxes::{BRICK, GRAVITY, point_jacobian};
use crate::support::random::{draws, numbers};
use crate::support::sizes::bodies;
use nalgebra::{SMatrix, SVector, Vector3};
use serde_json::Value;
use stiction::time_stepping::free_impulse;
use stiction::{Contact, Error, JointRow, Real, RowLaw, Settings};

/// s
const STEP: f64 = 2e-3;

/// Ticks under the weight alone, and under weight and load.
const TICKS: [usize; 2] = [5, 300];

/// A body that moves by more has slid off, m/s.
const SLIDES: f64 = 1e-3;

/// One that leaves has at least this speed in the end, m/s.
const LEAVES: f64 = 1e-4;

/// Room for boxes of up to eight points and for rovers of four wheels.
type Room<T> = bodies::Kernel<T>;

type Force = SVector<f64, 10>;

/// Bodies with the largest loads that friction can hold, by `cargo run --release -p rest -- --bodies 42 --write FILE`.
const CRITICAL: &str = include_str!("rest_kept.json");

struct Foot {
    point: Vector3<f64>,
    normal: Vector3<f64>,
    mu: f64,
}

/// Its axes are those of a slope: down, across, out of it.
struct Body {
    kind: String,
    /// Of the body, of its rotation, of wheels.
    masses: Force,
    feet: Vec<Foot>,
    /// Radius of wheels, m.
    radius: f64,
    /// Largest torques of their brakes, N·m; none if a wheel is locked.
    brakes: Vec<Option<f64>>,
    weight: Force,
    load: Force,
}

impl Body {
    fn kernel<T: Real>(&self) -> Result<Room<T>, Error> {
        let mut kernel = Room::new();
        let scene = kernel.scene_mut();
        let mass = SMatrix::from_diagonal(&self.masses);
        scene.set_mass(&mass.map(T::literal))?;
        for (key, (foot, wheel)) in (0..).zip(self.feet.iter().zip(6..)) {
            let mut velocity = SMatrix::<f64, 3, 10>::zeros();
            let [z, x, y] = [0, 1, 2].map(|row| point_jacobian(&foot.point).row(row).into_owned());
            for (mut target, row) in velocity.row_iter_mut().zip([x, y, z]) {
                target.columns_mut(0, 6).copy_from(&row);
            }
            if !self.brakes.is_empty() {
                velocity[(0, wheel)] = -self.radius;
            }
            let normal = foot.normal.normalize().map(T::literal);
            let velocity = velocity.map(T::literal);
            scene.push(&Contact::at_point(&normal, &velocity, T::literal(foot.mu), key)?)?;
        }
        for (key, (brake, wheel)) in (0..).zip(self.brakes.iter().zip(6..)) {
            let law = brake.map_or(RowLaw::Equality, |torque| {
                let upper = T::literal(torque * STEP);
                RowLaw::Box { lower: -upper, upper }
            });
            let mut row = SVector::<T, 10>::zeros();
            row[wheel] = T::ONE;
            scene.push_row(&JointRow { row, offset: T::ZERO, law, compliance: T::ZERO, key })?;
        }
        Ok(kernel)
    }

    /// The largest speed of a contact under weight and `share` of the load (m/s). Errors up to the tolerance are left out.
    ///
    /// With no ticks under the weight alone the first solve, which is cold, has the load; it is told that nothing moved before.
    fn speed<T: Real>(&self, share: f64, tolerance: f64, ticks: [usize; 2]) -> Result<f64, Error> {
        let mut kernel = self.kernel::<T>()?;
        if ticks[0] == 0 {
            kernel.solver_mut().presume_rest();
        }
        let mass = *kernel.scene().mass();
        let settings = Settings::new(T::literal(tolerance));
        let forces = [self.weight, self.weight + self.load * share];
        let mut velocity = SVector::zeros();
        let mut fastest = 0.0;
        for (force, ticks) in forces.iter().zip(ticks) {
            for _ in 0..ticks {
                let push = free_impulse(&mass, &velocity, &force.map(T::literal), T::literal(STEP));
                let solution = kernel.solve(&push, &settings)?;
                assert!(solution.is_solved(), "{}: {}", self.kind, solution.status);
                velocity = solution.velocity;
                let impulse =
                    solution.contacts.iter().fold(T::ZERO, |sum, contact| sum + contact.impulse.norm());
                let error = settings.tolerance * impulse * T::literal(100.0 / self.masses[0]);
                for contact in &solution.contacts {
                    let speed = contact.velocity.norm() - error;
                    fastest = f64::max(fastest, speed.to_subset().unwrap_or(f64::NAN));
                }
            }
        }
        Ok(fastest)
    }

    /// [`Self::speed`] in each of the settings.
    fn speeds(&self, share: f64, ticks: [usize; 2]) -> Result<[f64; 3], Error> {
        Ok([
            self.speed::<f64>(share, 1e-9, ticks)?,
            self.speed::<f64>(share, 1e-4, ticks)?,
            self.speed::<f32>(share, 1e-4, ticks)?,
        ])
    }

    /// The settings in which it slides off.
    fn slides_off(&self, share: f64, ticks: [usize; 2]) -> Result<Vec<String>, Error> {
        let settings = ["f64, 1e-9", "f64, 1e-4", "f32, 1e-4"];
        let speeds = settings.into_iter().zip(self.speeds(share, ticks)?);
        let slid = speeds.filter(|(_, speed)| *speed > SLIDES);
        let line = |(setting, speed)| format!("{} at {share}, {setting}: {speed:.1e} m/s", self.kind);
        Ok(slid.map(line).collect())
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("it is a number")
}

fn list(value: &Value) -> Vec<f64> {
    let list = value.as_array().expect("it is a list");
    list.iter().map(number).collect()
}

/// With `rest` behind the numbers.
fn padded(numbers: &[f64], rest: f64) -> Force {
    Force::from_fn(|i, _| numbers.get(i).copied().unwrap_or(rest))
}

/// The bodies of the file, with the largest loads that friction can hold.
fn critical() -> Vec<Body> {
    let bodies: Value = serde_json::from_str(CRITICAL).expect("it is JSON");
    let bodies = bodies.as_array().expect("it is a list");
    let foot = |foot: &Value| Foot {
        point: Vector3::from_vec(list(&foot[0])),
        normal: Vector3::from_vec(list(&foot[1])),
        mu: number(&foot[2]),
    };
    let feet = |feet: &Value| feet.as_array().into_iter().flatten().map(foot).collect();
    let brakes = |list: &Value| list.as_array().into_iter().flatten().map(Value::as_f64).collect();
    let body = |body: &Value| Body {
        kind: body["kind"].as_str().unwrap_or_default().to_owned(),
        masses: padded(&list(&body["masses"]), 1.0),
        feet: feet(&body["feet"]),
        radius: number(&body["radius"]),
        brakes: brakes(&body["brakes"]),
        weight: padded(&list(&body["weight"]), 0.0),
        load: padded(&list(&body["load"]), 0.0),
    };
    bodies.iter().map(body).collect()
}

/// A brick on a slope of 20 degrees, mu 0.6, on its corners, or on the middles of its edges as well.
fn brick(points: usize) -> Body {
    let [x, y, z] = BRICK.half;
    let edges = [(x, 0.0), (-x, 0.0), (0.0, y), (0.0, -y)].map(|(x, y)| Vector3::new(x, y, -z));
    let points = BRICK.corners().into_iter().chain(edges).take(points);
    let feet = points.map(|point| Foot { point, normal: Vector3::z(), mu: 0.6 });
    let slope = 20.0_f64.to_radians();
    let weight = BRICK.mass * GRAVITY;
    Body {
        kind: "brick".to_owned(),
        masses: padded(BRICK.mass_matrix().diagonal().as_slice(), 1.0),
        feet: feet.collect(),
        radius: 0.0,
        brakes: Vec::new(),
        weight: padded(&[weight * slope.sin(), 0.0, -weight * slope.cos()], 0.0),
        load: Force::zeros(),
    }
}

/// A load that only forces at 0.95 of friction hold, all against one slide, from numbers between -1 and 1.
fn load(body: &Body, numbers: &[f64]) -> Result<Force, Error> {
    let slide = padded(&[numbers[0], numbers[1], 0.0, 0.0, 0.0, 20.0 * numbers[2]], 0.0);
    let normals = numbers.iter().skip(3).map(|x| 1.0 + 0.9 * x);
    let kernel = body.kernel::<f64>()?;
    let contacts = kernel.scene().contacts();
    let sum: f64 = normals.clone().take(contacts.len()).sum();
    let mut force = -body.weight;
    for (contact, normal) in contacts.iter().zip(normals) {
        let normal = normal * -body.weight[2] / sum;
        let mut impulse = contact.jacobian * slide;
        impulse *= 0.95 * contact.mu * normal / impulse.norm();
        impulse[0] = normal;
        force -= contact.jacobian.tr_mul(&impulse);
    }
    Ok(force)
}

fn none_slides(bodies: &[Body], shares: &[f64], ticks: [usize; 2]) -> Result<(), Error> {
    let mut slid = Vec::new();
    for share in shares {
        for body in bodies {
            slid.extend(body.slides_off(*share, ticks)?);
        }
    }
    assert!(
        slid.is_empty(),
        "{} of {} slid:\n{}",
        slid.len(),
        3 * bodies.len() * shares.len(),
        slid.join("\n")
    );
    Ok(())
}

#[test]
fn bricks_keep_their_rest() -> Result<(), Error> {
    let mut bodies = Vec::new();
    for points in [4, 8] {
        for numbers in draws(numbers(3 + points), 20) {
            let mut body = brick(points);
            body.load = load(&body, &numbers)?;
            bodies.push(body);
        }
    }
    none_slides(&bodies, &[1.0], TICKS)
}

#[test]
fn bodies_keep_their_rest_up_to_the_largest_load() -> Result<(), Error> {
    none_slides(&critical(), &[0.9, 0.99], TICKS)
}

/// A thousandth below the largest load the errors of ticks that are solved as they begin must not add up to a slide.
#[test]
fn bodies_do_not_creep_away_just_below_the_largest_load() -> Result<(), Error> {
    none_slides(&critical(), &[0.999], [5, 1_000])
}

/// The normal impulses of a tick without the load, before and after ticks with it.
fn normals_around(body: &Body, tolerance: f64) -> Result<[Vec<f64>; 2], Error> {
    let mut kernel = body.kernel::<f64>()?;
    let mass = *kernel.scene().mass();
    let settings = Settings::new(tolerance);
    let mut velocity = SVector::zeros();
    let mut normals = Vec::new();
    for (share, ticks) in [(0.0, 500), (1.0, 200), (0.0, 500)] {
        for _ in 0..ticks {
            let force = body.weight + body.load * share;
            let push = free_impulse(&mass, &velocity, &force, STEP);
            velocity = kernel.solve(&push, &settings)?.velocity;
        }
        let contacts = &kernel.solution().contacts;
        normals.push(contacts.iter().map(|contact| contact.impulse[0]).collect());
    }
    Ok([normals.swap_remove(0), normals.swap_remove(0)])
}

/// After a push that did not move it a body bears its weight as before.
#[test]
fn internal_forces_go_back_after_a_nudge() -> Result<(), Error> {
    let mut body = brick(4);
    let [a, b, c] = [0.2, 0.15, 0.1].map(|half: f64| half * half);
    let moments = [b + c, a + c, a + b].map(|square| square * 2.0 / 3.0);
    body.masses = padded(&[&[2.0; 3], moments.as_slice()].concat(), 1.0);
    for foot in &mut body.feet {
        let sign = foot.point.map(f64::signum);
        foot.point = Vector3::new(0.2, 0.15, 0.1).component_mul(&sign);
    }
    body.weight *= 2.0 / BRICK.mass;
    body.load = padded(&[0.0, 4.0, 0.0, 1.0, 0.0, 0.6], 0.0);
    let sum = body.weight[2].abs() * STEP;
    for tolerance in [1e-4, 1e-6, 1e-9] {
        let [before, after] = normals_around(&body, tolerance)?;
        for (before, after) in before.iter().zip(&after) {
            let moved = (after - before).abs() / sum;
            assert!(moved < 0.01, "to {tolerance:.0e} {moved:.3} of the weight");
        }
    }
    Ok(())
}

#[test]
fn a_cold_solve_keeps_the_rest_that_it_is_told_of() -> Result<(), Error> {
    none_slides(&critical(), &[0.9, 0.99], [0, 300])
}

#[test]
fn bodies_leave_beyond_the_largest_load() -> Result<(), Error> {
    for body in critical() {
        let speeds = body.speeds(1.001, TICKS)?;
        let leaves = speeds.iter().all(|&speed| speed > LEAVES);
        assert!(leaves, "{} stays: {speeds:?} m/s", body.kind);
    }
    Ok(())
}
