//! Finds the push after which a three-legged box stops at a mark.
//!
//! The push acts on a corner, so the box turns as it slides. Gauss-Newton's method on the two components of the push: each step
//! differentiates 200 time steps through and through, contacts that turn with the box included.
//!
//! `cargo run --release -p pictures --bin push_to_mark [FILE.svg]`

use nalgebra::{Matrix2, Matrix6, SMatrix, SVector, Vector2, Vector3, matrix, vector};
use pictures::{curve, dots, panel};
use std::error::Error;
use stiction::time_stepping::free_impulse;
use stiction::{Contact, Inputs, Kernel, Settings};

const STEP: f64 = 5e-3;
const STEPS: usize = 200;
const MU: f64 = 0.35;
const MASS: f64 = 2.0;
const GRAVITY: f64 = 9.81;
const HEIGHT: f64 = 0.05;
const MARK: Vector2<f64> = Vector2::new(0.7, 0.25);
/// Where it is pushed, from its centre (m).
const CORNER: Vector2<f64> = Vector2::new(-0.1, 0.04);
const LABELS: [&str; 8] = ["first push", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth"];

/// Velocity of a point of the box, normal first.
fn point_jacobian(p: &Vector3<f64>) -> SMatrix<f64, 3, 6> {
    let turning = turning(p);
    let mut jacobian = matrix![
        0.0, 0.0, 1.0, 0.0, 0.0, 0.0;
        1.0, 0.0, 0.0, 0.0, 0.0, 0.0;
        0.0, 1.0, 0.0, 0.0, 0.0, 0.0
    ];
    jacobian.fixed_columns_mut::<3>(3).copy_from(&turning);
    jacobian
}

/// What of it is linear in the point.
fn turning(p: &Vector3<f64>) -> SMatrix<f64, 3, 3> {
    matrix![p.y, -p.x, 0.0; 0.0, p.z, -p.y; -p.z, 0.0, p.x]
}

/// The feet of a box that has turned.
fn feet(angle: f64) -> [Vector3<f64>; 3] {
    let (sin, cos) = angle.sin_cos();
    [(0.1, 0.0), (-0.1, 0.08), (-0.1, -0.08)]
        .map(|(x, y)| vector![cos * x - sin * y, sin * x + cos * y, -HEIGHT])
}

/// A slide: where the centre was, where it ends, and how the end moves with the push.
struct Slide {
    path: Vec<(f64, f64)>,
    end: Vector2<f64>,
    slope: Matrix2<f64>,
    margin: f64,
}

fn slide(kernel: &mut Kernel<f64, 6, 3, 3>, push: &Vector2<f64>) -> Result<Slide, Box<dyn Error>> {
    let settings = Settings::new(1e-11);
    let inertia = vector![0.01, 0.01, 0.012];
    let mass = Matrix6::from_diagonal(&vector![MASS, MASS, MASS, inertia.x, inertia.y, inertia.z]);
    let weight = vector![0.0, 0.0, -MASS * GRAVITY, 0.0, 0.0, 0.0];
    // The push sets the velocity at the beginning.
    let turn = CORNER.perp(push) / inertia.z;
    let mut v: SVector<f64, 6> = vector![push.x / MASS, push.y / MASS, 0.0, 0.0, 0.0, turn];
    let mut v_slopes = SMatrix::<f64, 6, 2>::zeros();
    (v_slopes[(0, 0)], v_slopes[(1, 1)]) = (1.0 / MASS, 1.0 / MASS);
    (v_slopes[(5, 0)], v_slopes[(5, 1)]) = (-CORNER.y / inertia.z, CORNER.x / inertia.z);
    // Position (x, y, angle).
    let (mut at, mut slopes) = (Vector3::zeros(), SMatrix::<f64, 3, 2>::zeros());
    let (mut path, mut margin) = (vec![(0.0, 0.0)], f64::INFINITY);
    for _ in 0..STEPS {
        let feet = feet(at.z);
        kernel.scene_mut().clear_contacts();
        kernel.scene_mut().set_mass(&mass)?;
        for (foot, key) in feet.iter().zip(0..) {
            let (jacobian, offset) = (point_jacobian(foot), SVector::zeros());
            kernel.scene_mut().push(&Contact { jacobian, offset, mu: MU, key })?;
        }
        let solution = kernel.solve(&free_impulse(&mass, &v, &weight, STEP), &settings)?;
        if !solution.is_usable(1e-9) {
            return Err(format!("{}", solution.status).into());
        }
        v = solution.velocity;
        let derivative = kernel.derivative(&settings)?;
        margin = margin.min(derivative.margin());
        for column in 0..2 {
            let mut change = Inputs::zero();
            change.free_impulse = mass * v_slopes.column(column);
            for (i, foot) in feet.iter().enumerate() {
                // The foot turns with the box, and its Jacobian with it.
                let moved = Vector3::z().cross(foot) * slopes[(2, column)];
                let moved = turning(&vector![moved.x, moved.y, 0.0]);
                let spin = v.fixed_rows::<3>(3);
                let pull = moved.transpose() * kernel.solution().contacts[i].impulse;
                let mut rows = change.free_impulse.fixed_rows_mut::<3>(3);
                rows += pull;
                change.offsets[i] = moved * spin;
            }
            v_slopes.set_column(column, &derivative.forward(&change).velocity);
        }
        for (k, place) in [0, 1, 5].into_iter().enumerate() {
            at[k] += STEP * v[place];
            let moved = slopes.row(k) + v_slopes.row(place) * STEP;
            slopes.set_row(k, &moved);
        }
        path.push((at.x, at.y));
    }
    if v.norm() > 1e-9 {
        return Err("it has not come to rest".into());
    }
    let (end, slope) = (at.xy(), slopes.fixed_rows::<2>(0).into_owned());
    Ok(Slide { path, end, slope, margin })
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut kernel = Kernel::new();
    // What would do if it were pushed through its centre.
    let speed = (2.0 * MU * GRAVITY * MARK.norm()).sqrt();
    let mut push = MARK.normalize() * (MASS * speed);
    let (mut paths, mut misses) = (Vec::new(), Vec::new());
    for (label, iteration) in LABELS.into_iter().zip(0..) {
        let found = slide(&mut kernel, &push)?;
        let miss = MARK - found.end;
        println!(
            "push {:.4}, {:.4} N·s: stops {:.2e} m from the mark; margin {:.1e}",
            push.x,
            push.y,
            miss.norm(),
            found.margin
        );
        paths.push(curve(label, found.path));
        misses.push((f64::from(iteration), miss.norm().max(1e-16).log10()));
        if miss.norm() < 1e-9 {
            break;
        }
        let step = found.slope.lu().solve(&miss).ok_or("no push moves the end")?;
        push += step;
    }
    paths.push(dots("mark", vec![(MARK.x, MARK.y)]));
    pictures::draw(
        "push_to_mark",
        &[
            panel("A box is pushed at a corner", "x (m)", "y (m)", paths),
            panel(
                "How far from the mark it stops",
                "iteration",
                "log10 of the distance (m)",
                [curve("", misses)],
            ),
        ],
    )
}
