//! More contacts than a body needs: the same one several times, or nearly parallel ones.

mod support;

use support::check::{F32, F64, scene, solved};
use support::generate::{Class, solvable};
use support::scene_file::SceneFile;

/// A point on a floor that is there three times, turned by an angle each time.
fn same_floor_three_times() -> impl Iterator<Item = SceneFile> {
    [0.0, 1e-12, 1e-9, 1e-6, 1e-3].into_iter().map(|angle| {
        let floor = [-1.0, 0.0, 1.0].map(|side| {
            let (sin, cos) = libm::sincos(side * angle);
            ([-sin, cos], [cos, sin])
        });
        let contacts = floor
            .each_ref()
            .map(|(normal, tangent)| ([&normal[..], &tangent[..]], [0.0; 2], 0.5));
        scene(&format!("{angle:e}"), &[2.0, 2.0], &[-0.05, 0.2], &contacts)
    })
}

#[test]
fn same_floor_in_f64() {
    solved::<f64>(same_floor_three_times(), F64);
}

#[test]
fn same_floor_in_f32() {
    solved::<f32>(same_floor_three_times(), F32);
}

#[test]
fn redundant_contacts_in_f64() {
    solved::<f64>(solvable(Class::Redundant, 60), F64);
}

#[test]
fn redundant_contacts_in_f32() {
    solved::<f32>(solvable(Class::Redundant, 60), F32);
}
