//! Painlevé's rod: sliding friction so strong that the contact needs an impact without collision.

mod support;

use support::check::{F32, F64, scene, solved};
use support::generate::{Class, solvable};
use support::scene_file::SceneFile;

/// A rod of 1 kg and 2 m on one end, dofs x, z and angle; the end slides forward.
fn rod() -> impl Iterator<Item = SceneFile> {
    [0.5, 4.0 / 3.0, 2.0, 6.0].into_iter().flat_map(|mu| {
        [0.3, 0.8, 1.1, 1.4].map(|angle| {
            let (rise, run) = libm::sincos(angle);
            let end: [&[f64]; 2] = [&[0.0, 1.0, -run], &[1.0, 0.0, -rise]];
            let name = format!("mu {mu}, angle {angle}");
            let inertia = 1.0 / 3.0;
            scene(
                &name,
                &[1.0, 1.0, inertia],
                &[1.0, 0.0981, 0.0],
                &[(end, [0.0; 2], mu)],
            )
        })
    })
}

#[test]
fn rod_in_f64() {
    solved::<f64>(rod(), F64);
}

#[test]
fn rod_in_f32() {
    solved::<f32>(rod(), F32);
}

#[test]
fn rods_in_f64() {
    solved::<f64>(solvable(Class::Painleve, 60), F64);
}

#[test]
fn rods_in_f32() {
    solved::<f32>(solvable(Class::Painleve, 60), F32);
}
