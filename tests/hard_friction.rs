//! Friction coefficients 0, 1e-6, 5 and 10 in one scene.

mod support;

use support::check::{F32, F64, scene, solved};
use support::generate::{Class, solvable};
use support::scene_file::SceneFile;

const MIXED: [f64; 4] = [0.0, 1e-6, 5.0, 10.0];

/// A point in a corner, pressed against the wall and the floor: dofs y, x, z.
fn point_in_a_corner() -> impl Iterator<Item = SceneFile> {
    MIXED.into_iter().flat_map(|floor_mu| {
        MIXED.map(|wall_mu| {
            let (y, x, z): (&[f64], &[f64], &[f64]) =
                (&[1.0, 0.0, 0.0], &[0.0, 1.0, 0.0], &[0.0, 0.0, 1.0]);
            let contacts = [
                ([z, x, y], [0.0; 3], floor_mu),
                ([x, y, z], [0.0; 3], wall_mu),
            ];
            let name = format!("floor {floor_mu}, wall {wall_mu}");
            scene(&name, &[1.0; 3], &[-0.3, 0.2, 0.1], &contacts)
        })
    })
}

#[test]
fn corner_in_f64() {
    solved::<f64>(point_in_a_corner(), F64);
}

#[test]
fn corner_in_f32() {
    solved::<f32>(point_in_a_corner(), F32);
}

#[test]
fn mixed_in_f64() {
    solved::<f64>(solvable(Class::MixedFriction, 60), F64);
}

#[test]
fn mixed_in_f32() {
    solved::<f32>(solvable(Class::MixedFriction, 60), F32);
}
