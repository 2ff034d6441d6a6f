//! Bodies wedged between walls: impulses that friction locks in have no unique value.

mod support;

use support::check::{F32, F64, scene, solved};
use support::generate::{Class, solvable};
use support::scene_file::SceneFile;

/// A point in a groove, dofs x and z; the walls rise by an angle from the vertical.
fn groove() -> impl Iterator<Item = SceneFile> {
    [1e-3, 0.1, 0.5, 1.2].into_iter().flat_map(|angle| {
        [0.0, 0.1, 1.0, 10.0].map(|mu| {
            let (sin, cos) = libm::sincos(angle);
            let left: [&[f64]; 2] = [&[cos, sin], &[-sin, cos]];
            let right: [&[f64]; 2] = [&[-cos, sin], &[sin, cos]];
            let contacts = [(left, [0.0; 2], mu), (right, [0.0; 2], mu)];
            let name = format!("angle {angle}, mu {mu}");
            scene(&name, &[2.0; 2], &[0.03, 0.2], &contacts)
        })
    })
}

#[test]
fn groove_in_f64() {
    solved::<f64>(groove(), F64);
}

#[test]
fn groove_in_f32() {
    solved::<f32>(groove(), F32);
}

#[test]
fn wedges_in_f64() {
    solved::<f64>(solvable(Class::Wedge, 60), F64);
}

#[test]
fn wedges_in_f32() {
    solved::<f32>(solvable(Class::Wedge, 60), F32);
}
