//! Stacks and hands whose masses are up to a million apart.

mod support;

use support::check::{F32, F64, scene, solved};
use support::generate::{Class, solvable};
use support::scene_file::SceneFile;

/// Dofs x, z below, x, z above: a light point on the floor, a heavy one on it, pushed sideways.
fn heavy_on_light() -> impl Iterator<Item = SceneFile> {
    [1.0, 1e2, 1e4, 1e6].into_iter().flat_map(|ratio| {
        [0.0, 0.03, 0.06].map(|push| {
            let weight = 0.0981;
            scene(
                &format!("1:{ratio:e}, push {push}"),
                &[1.0, 1.0, ratio, ratio],
                &[0.0, weight, -push * ratio, weight * ratio],
                &[
                    (
                        [&[0.0, 1.0, 0.0, 0.0], &[1.0, 0.0, 0.0, 0.0]],
                        [0.0; 2],
                        0.5,
                    ),
                    (
                        [&[0.0, -1.0, 0.0, 1.0], &[-1.0, 0.0, 1.0, 0.0]],
                        [0.0; 2],
                        0.5,
                    ),
                ],
            )
        })
    })
}

#[test]
fn heavy_on_light_in_f64() {
    solved::<f64>(heavy_on_light(), F64);
}

#[test]
fn heavy_on_light_in_f32() {
    solved::<f32>(heavy_on_light(), F32);
}

#[test]
fn stacks_in_f64() {
    solved::<f64>(solvable(Class::Stack, 48), F64);
}

#[test]
fn stacks_in_f32() {
    solved::<f32>(solvable(Class::Stack, 48), F32);
}

#[test]
fn hands_in_f64() {
    solved::<f64>(solvable(Class::Hand, 48), F64);
}

#[test]
fn hands_in_f32() {
    solved::<f32>(solvable(Class::Hand, 48), F32);
}
