//! Slopes at the friction angle, and a little off it.

mod support;

use support::check::{F32, F64, scene, solved};
use support::generate::{Class, solvable};
use support::scene_file::SceneFile;

/// A point on a slope with `tan = mu (1 + off)`, dofs along and across the slope.
fn point_at_the_limit() -> impl Iterator<Item = SceneFile> {
    [0.0, 1e-6, -1e-6, 1e-3, -1e-3].into_iter().flat_map(|off| {
        [1e-3, 0.5, 5.0].map(|mu| {
            let floor: [&[f64]; 2] = [&[0.0, 1.0], &[1.0, 0.0]];
            let load = [-0.1 * mu * (1.0 + off), 0.1];
            let name = format!("mu {mu}, off by {off:e}");
            scene(&name, &[2.0; 2], &load, &[(floor, [0.0; 2], mu)])
        })
    })
}

#[test]
fn point_in_f64() {
    solved::<f64>(point_at_the_limit(), F64);
}

#[test]
fn point_in_f32() {
    solved::<f32>(point_at_the_limit(), F32);
}

#[test]
fn boxes_in_f64() {
    solved::<f64>(solvable(Class::Slope, 60), F64);
}

#[test]
fn boxes_in_f32() {
    solved::<f32>(solvable(Class::Slope, 60), F32);
}
