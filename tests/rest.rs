//! A body at rest stays as it is: a warm start does not carry internal forces to the boundaries of their cones.

use crate::support::boxes::{GRAVITY, point_jacobian};
use crate::support::sizes::{bodies, body};
use nalgebra::{SMatrix, SVector, Vector3, vector};
use stiction::time_stepping::free_impulse;
use stiction::{Contact, Error, JointRow, Kernel, Real, RowLaw, Settings};

/// s
const STEP: f64 = 1e-3;

/// Ticks of 100 s, or of so many as `REST_SECONDS` says.
fn ticks() -> usize {
    let seconds = std::env::var("REST_SECONDS").ok();
    let seconds = seconds.and_then(|seconds| seconds.parse::<usize>().ok());
    1_000 * seconds.unwrap_or(100)
}

/// How far tangential impulses have moved in their cones since the start, as shares of friction, and normal ones as shares of
/// themselves: the largest of all ticks.
fn drift<T: Real, const N: usize, const C: usize, const R: usize, const S: usize>(
    kernel: &mut Kernel<T, N, 3, C, R, S>,
    start: &SVector<f64, N>,
    force: &SVector<f64, N>,
) -> Result<[f64; 2], Error> {
    let (mut velocity, force) = (start.map(T::literal), force.map(T::literal));
    let mass = *kernel.scene().mass();
    let double = |x: T| x.to_subset().unwrap_or(f64::NAN);
    let (mut first, mut moved) = (None, [0.0; 2]);
    for _ in 0..ticks() {
        let push = free_impulse(&mass, &velocity, &force, T::literal(STEP));
        let mus: Vec<T> = kernel.scene().contacts().iter().map(|c| c.mu).collect();
        let solution = kernel.solve(&push, &Settings::default())?;
        assert!(solution.is_solved(), "{}", solution.status);
        velocity = solution.velocity;
        let feet = solution.contacts.iter().zip(mus);
        let feet = feet.map(|(foot, mu)| {
            let [normal, x, y] = foot.impulse.into();
            [normal, x.hypot(y) / (mu * normal)].map(double)
        });
        let feet: Vec<_> = feet.collect();
        let first = first.get_or_insert_with(|| feet.clone());
        for ([normal, grip], [normal_first, grip_first]) in feet.iter().zip(first) {
            moved[0] = f64::max(moved[0], grip - *grip_first);
            moved[1] = f64::max(moved[1], (normal / *normal_first - 1.0).abs());
        }
    }
    Ok(moved)
}

/// A box of 12 kg on feet.
fn on_feet<T: Real, const C: usize>(feet: [[f64; 2]; C], slope: f64) -> Result<[f64; 2], Error> {
    let mut kernel = body::Kernel::<T>::new();
    let masses = vector![12.0, 12.0, 12.0, 0.3, 0.5, 0.7];
    let scene = kernel.scene_mut();
    scene.set_mass(&SMatrix::from_diagonal(&masses).map(T::literal))?;
    for (key, [x, y]) in (0..).zip(feet) {
        scene.push(&Contact {
            jacobian: point_jacobian(&Vector3::new(x, y, -0.2)).map(T::literal),
            offset: SVector::zeros(),
            mu: T::literal(0.6),
            key,
        })?;
    }
    let weight = 12.0 * GRAVITY;
    let force = vector![weight * slope.sin(), 0.0, -weight * slope.cos(), 0.0, 0.0, 0.0];
    drift(&mut kernel, &SVector::zeros(), &force)
}

/// A rover of 9 dofs, a body and three wheels, that drives straight at 0.5 m/s: each wheel is driven by a motor with a damping
/// gain and a torque limit.
fn rover<T: Real>() -> Result<[f64; 2], Error> {
    const RADIUS: f64 = 0.1;
    let mut kernel = bodies::Kernel::<T>::new();
    let scene = kernel.scene_mut();
    let masses = vector![8.0, 8.0, 8.0, 0.2, 0.3, 0.4, 0.01, 0.01, 0.01, 1.0];
    scene.set_mass(&SMatrix::from_diagonal(&masses).map(T::literal))?;
    let wheels = [[0.25, 0.0], [-0.2, 0.2], [-0.2, -0.2]];
    for (k, [x, y]) in wheels.into_iter().enumerate() {
        let mut jacobian = SMatrix::<f64, 3, 10>::zeros();
        let body = point_jacobian(&Vector3::new(x, y, -0.15));
        jacobian.fixed_columns_mut::<6>(0).copy_from(&body);
        jacobian[(1, 6 + k)] = -RADIUS; // forward, by a wheel that turns forward
        scene.push(&Contact {
            jacobian: jacobian.map(T::literal),
            offset: SVector::zeros(),
            mu: T::literal(0.7),
            key: u32::try_from(k).unwrap_or(0),
        })?;
        let mut row = SVector::<T, 10>::zeros();
        row[6 + k] = T::ONE;
        let (gain, limit) = (2.0, 3.0); // N·m·s/rad, N·m
        scene.push_row(&JointRow {
            row,
            offset: T::literal(-0.5 / RADIUS),
            law: RowLaw::Box { lower: T::literal(-limit * STEP), upper: T::literal(limit * STEP) },
            compliance: T::literal(1.0 / (STEP * gain)),
            key: u32::try_from(k).unwrap_or(0),
        })?;
    }
    let wheel = 0.5 / RADIUS;
    let start = vector![0.5, 0.0, 0.0, 0.0, 0.0, 0.0, wheel, wheel, wheel, 0.0];
    let mut force = SVector::<f64, 10>::zeros();
    force[2] = -8.0 * GRAVITY;
    drift(&mut kernel, &start, &force)
}

fn stays([grip, normal]: [f64; 2]) {
    println!("moved by {grip:.1e} of friction, {normal:.1e} of normals");
    assert!(grip <= 0.01 && normal <= 0.01, "moved by {grip:.4} of friction, {normal:.4} of normals");
}

const SQUARE: [[f64; 2]; 4] = [[0.3, 0.2], [0.3, -0.2], [-0.3, 0.2], [-0.3, -0.2]];
const UNEVEN: [[f64; 2]; 4] = [[0.35, 0.2], [0.3, -0.25], [-0.2, 0.15], [-0.3, -0.2]];
const TRIPOD: [[f64; 2]; 3] = [[0.3, 0.02], [-0.2, 0.2], [-0.25, -0.2]];

macro_rules! rest {
    ($($name:ident: $scene:expr;)*) => {
        $(#[test]
        fn $name() -> Result<(), Error> {
            stays($scene?);
            Ok(())
        })*
    };
}

rest! {
    a_box_on_four_feet_in_single_precision: on_feet::<f32, 4>(SQUARE, 0.0);
    a_box_on_four_feet_in_double_precision: on_feet::<f64, 4>(SQUARE, 0.0);
    a_box_on_uneven_feet_in_single_precision: on_feet::<f32, 4>(UNEVEN, 0.2);
    a_box_on_uneven_feet_in_double_precision: on_feet::<f64, 4>(UNEVEN, 0.2);
    a_box_on_three_feet_in_single_precision: on_feet::<f32, 3>(TRIPOD, 0.0);
    a_box_on_three_feet_in_double_precision: on_feet::<f64, 3>(TRIPOD, 0.0);
    a_rover_that_drives_straight_in_single_precision: rover::<f32>();
    a_rover_that_drives_straight_in_double_precision: rover::<f64>();
}
