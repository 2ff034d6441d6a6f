//! Moving surfaces, impacts, no load, no contact that touches.

mod support;

use support::check::{F32, F64, scene, solved};
use support::generate::{Class, solvable};
use support::scene_file::SceneFile;

/// A point over a floor, dofs x and z: `f`, then `w`.
fn point() -> impl Iterator<Item = SceneFile> {
    let floor: [&[f64]; 2] = [&[0.0, 1.0], &[1.0, 0.0]];
    [
        ("nothing", [0.0, 0.0], [0.0, 0.0]),
        ("belt", [0.0, 0.2], [0.0, 1.0]),
        ("fast belt", [0.0, 0.2], [0.0, 1e6]),
        ("belt, no load", [0.0, 0.0], [0.0, 1.0]),
        ("impact", [-1.0, 4.0], [-1.5, 0.0]),
        ("gap", [0.1, 0.2], [3.0, 0.0]),
        ("touching at the end", [0.0, 0.25], [0.125, 0.0]),
        ("rising floor, no load", [0.0, 0.0], [-1.0, 0.5]),
    ]
    .into_iter()
    .map(move |(name, f, w)| scene(name, &[2.0; 2], &f, &[(floor, w, 0.5)]))
}

#[test]
fn point_in_f64() {
    solved::<f64>(point(), F64);
}

#[test]
fn point_in_f32() {
    solved::<f32>(point(), F32);
}

#[test]
fn belts_and_impacts_in_f64() {
    solved::<f64>(solvable(Class::Moving, 60), F64);
}

#[test]
fn belts_and_impacts_in_f32() {
    solved::<f32>(solvable(Class::Moving, 60), F32);
}

#[test]
fn no_load_in_f64() {
    solved::<f64>(solvable(Class::Unloaded, 36), F64);
}

#[test]
fn no_load_in_f32() {
    solved::<f32>(solvable(Class::Unloaded, 36), F32);
}

#[test]
fn all_open_in_f64() {
    solved::<f64>(solvable(Class::Open, 36), F64);
}

#[test]
fn all_open_in_f32() {
    solved::<f32>(solvable(Class::Open, 36), F32);
}
