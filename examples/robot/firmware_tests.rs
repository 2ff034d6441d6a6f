//! The dynamics of `examples/robot_firmware`, which are written for a microcontroller, are those of `dynibo`.

use crate::{Base, World};
use dynamics::{Dynamics, N, State};
use model::RADIUS;
use nalgebra::{SMatrix, SVector, UnitQuaternion, Vector3};
use spatial::sin_cos;
use std::path::Path;

#[path = "../robot_firmware/dynamics.rs"]
mod dynamics;
#[path = "../robot_firmware/model.rs"]
mod model;
#[path = "../robot_firmware/spatial.rs"]
mod spatial;

const LEGS: [&str; 4] = ["FL", "FR", "RL", "RR"];
const PARTS: [&str; 3] = ["hip", "thigh", "calf"];

/// Random numbers between -1 and 1, the same in each run (a linear congruential generator).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f32 {
        const FACTOR: u64 = 6_364_136_223_846_793_005;
        self.0 = self.0.wrapping_mul(FACTOR).wrapping_add(1);
        let high = i16::try_from((self.0 >> 48) & 0x7fff).unwrap();
        f32::from(high - 0x4000) / f32::from(0x4000_i16)
    }
}

/// Draws a state: any orientation, angles up to 1 rad from the middle of each joint, rates up to 5 rad/s.
fn draw(numbers: &mut Numbers) -> State {
    let mut axis = || Vector3::from_fn(|_, _| numbers.next());
    let (turn, angular, linear) = (axis() * 3.0, axis() * 5.0, axis() * 2.0);
    let middle = [0.0, 0.5, -1.35];
    let angles = [(); 4].map(|()| middle.map(|angle| angle + numbers.next()));
    let mut velocity = SVector::<f32, N>::from_fn(|_, _| numbers.next() * 5.0);
    velocity.fixed_rows_mut::<3>(0).copy_from(&angular);
    velocity.fixed_rows_mut::<3>(3).copy_from(&linear);
    let turn = UnitQuaternion::from_scaled_axis(turn);
    State { turn, angles, velocity }
}

/// Dynamics by `dynibo`, with the joints in the firmware's order.
struct Reference {
    mass: SMatrix<f64, N, N>,
    bias: SVector<f64, N>,
    /// Place (m) and Jacobian of the point of each foot.
    feet: [(Vector3<f64>, SMatrix<f64, 3, N>); 4],
}

/// Computes them.
fn reference(world: &mut World<N>, state: &State) -> Reference {
    let tree = &mut world.trees[0];
    tree.turn = state.turn.cast();
    tree.turn.renormalize();
    // Where each of dynibo's velocities stands in the firmware's.
    let mut order: Vec<usize> = (0..6).collect();
    for joint in &mut tree.joints {
        let (leg, part) = joint.name.split_once('_').unwrap();
        let leg = LEGS.iter().position(|name| *name == leg).unwrap();
        let part = PARTS.iter().position(|name| *name == part).unwrap();
        order.push(6 + 3 * leg + part);
        joint.angle = f64::from(state.angles[leg][part]);
    }
    world.velocity = SVector::from_fn(|i, _| f64::from(state.velocity[order[i]]));
    let theirs = world.dynamics().unwrap();
    let back = |i: usize| order.iter().position(|&at| at == i).unwrap();
    let feet = LEGS.map(|leg| {
        let body = world.body(&format!("{leg}_foot")).unwrap();
        let point = theirs.origins[body] - Vector3::z() * f64::from(RADIUS);
        let jacobian = theirs.jacobian(body, &point);
        let sorted = SMatrix::from_fn(|row, column| jacobian[(row, back(column))]);
        (point, sorted)
    });
    Reference {
        mass: SMatrix::from_fn(|i, j| theirs.mass[(back(i), back(j))]),
        bias: SVector::from_fn(|i, _| -theirs.force[back(i)]),
        feet,
    }
}

#[test]
fn the_dynamics_on_the_chip_are_those_of_dynibo() {
    let mut world = World::<N>::new(0.8, [60.0, 1.0]);
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("quadruped.urdf");
    world.load(&file, Base::Free, [0.0; 3]).unwrap();
    let (mut numbers, mut dynamics) = (Numbers(1), Dynamics::new());
    let mut worst = [0.0_f64; 4];
    for _ in 0..1_000 {
        let state = draw(&mut numbers);
        dynamics.update(&state);
        let theirs = reference(&mut world, &state);
        let mass = dynamics.mass.cast::<f64>();
        // An entry of `M` is small or large beside its diagonal's.
        for i in 0..N {
            for j in 0..N {
                let scale = (theirs.mass[(i, i)] * theirs.mass[(j, j)]).sqrt();
                worst[0] = worst[0].max((mass[(i, j)] - theirs.mass[(i, j)]).abs() / scale);
            }
        }
        let bias = dynamics.bias.cast::<f64>();
        worst[1] = worst[1].max((bias - theirs.bias).amax() / theirs.bias.amax());
        let feet = dynamics.feet.iter().zip(&theirs.feet);
        for (key, (foot, (point, jacobian))) in (0..).zip(feet) {
            worst[2] = worst[2].max((foot.point.cast::<f64>() - point).amax());
            // Upwards, ahead, to the left.
            let rows = [2, 0, 1].map(|axis| jacobian.row(axis).into_owned());
            let ours = foot.contact(0.0, 0.5, key).jacobian.cast::<f64>();
            worst[3] = worst[3].max((ours - SMatrix::from_rows(&rows)).amax());
        }
    }
    println!("M {:.1e}, bias {:.1e}, feet {:.1e} m, H {:.1e}", worst[0], worst[1], worst[2], worst[3]);
    let [mass, others @ ..] = worst;
    assert!(mass < 5e-6 && others.iter().all(|&error| error < 5e-7), "{worst:?}");
}

#[test]
fn sines_and_cosines_are_right_to_the_last_digits() {
    let mut worst = 0.0_f64;
    for i in -30_000_i16..30_000 {
        let angle = f32::from(i) * 3e-4;
        let ((sin, cos), exact) = (sin_cos(angle), f64::from(angle).sin_cos());
        let error = (f64::from(sin) - exact.0).abs().max((f64::from(cos) - exact.1).abs());
        worst = worst.max(error);
    }
    assert!(worst < 1e-7, "{worst:e}");
    for broken in [f32::NAN, f32::INFINITY] {
        let (sin, cos) = sin_cos(broken);
        assert!(!sin.is_finite() && !cos.is_finite());
    }
}
