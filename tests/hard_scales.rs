//! One velocity, mass matrices next to singular, data from 1e-12 to 1e12.

mod support;

use support::check::{F32, F64, honest, scene, solved};
use support::generate::{Class, solvable};
use support::scene_file::SceneFile;

/// A point that falls on a slippery slope, in units of mass and velocity far apart.
fn point() -> impl Iterator<Item = SceneFile> {
    let floor: [&[f64]; 2] = [&[0.0, 1.0], &[1.0, 0.0]];
    [
        (1e-12, 1.0),
        (1e12, 1.0),
        (1.0, 1e-12),
        (1.0, 1e12),
        (1e12, 1e-12),
        (1e-12, 1e12),
    ]
    .into_iter()
    .map(move |(mass, velocity)| {
        let (load, w) = (mass * velocity, [0.1 * velocity, 0.2 * velocity]);
        let name = format!("mass {mass:e}, velocity {velocity:e}");
        scene(&name, &[mass; 2], &[-load, load], &[(floor, w, 0.5)])
    })
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
fn one_dof_in_f64() {
    solved::<f64>(solvable(Class::OneDof, 48), F64);
}

#[test]
fn one_dof_in_f32() {
    solved::<f32>(solvable(Class::OneDof, 48), F32);
}

#[test]
fn near_singular_mass_in_f64() {
    solved::<f64>(solvable(Class::NearSingular, 48), F64);
}

/// A mass matrix of condition 1e10, rounded to f32, need not be positive definite.
#[test]
fn near_singular_mass_in_f32_makes_no_false_claim() {
    honest::<f32>(solvable(Class::NearSingular, 200), F32);
}

#[test]
fn other_units_in_f64() {
    solved::<f64>(solvable(Class::Scaled, 60), F64);
}

#[test]
fn other_units_in_f32_make_no_false_claim() {
    honest::<f32>(solvable(Class::Scaled, 200), F32);
}
