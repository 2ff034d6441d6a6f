//! Walls that close on a body have no solution; walls that leave a millionth do.

mod support;

use support::check::{F32, F64, all, scene, solved};
use support::generate::{Class, draw, solvable};
use support::scene_file::SceneFile;
use support::solve::{Answer, Outcome};

/// A point between two walls, the right one moving left: dofs x and z, `room` between the speeds.
fn between_walls(room: f64) -> SceneFile {
    let left: [&[f64]; 2] = [&[1.0, 0.0], &[0.0, 1.0]];
    let right: [&[f64]; 2] = [&[-1.0, 0.0], &[0.0, 1.0]];
    let contacts = [(left, [1.0 + room, 0.0], 0.5), (right, [-1.0, 0.0], 0.5)];
    scene(&format!("room {room:e}"), &[2.0; 2], &[0.1, 0.2], &contacts)
}

fn closing() -> impl Iterator<Item = SceneFile> {
    let drawn = (0..60).map(|index| draw(Class::Squeeze, 1, index).0);
    [-1.0, -1e-1, -1e-3]
        .map(between_walls)
        .into_iter()
        .chain(drawn)
}

fn narrow() -> impl Iterator<Item = SceneFile> {
    let drawn = solvable(Class::Narrow, 60);
    [0.0, 1e-6, 1e-3]
        .map(between_walls)
        .into_iter()
        .chain(drawn)
}

/// Whether the kernel proved that any solution is that many times faster than the walls.
fn is_proved(outcome: &Outcome, factor: f64) -> bool {
    matches!(outcome.answer, Answer::Infeasible { proof } if proof >= factor)
}

#[test]
fn closing_walls_are_proved_infeasible_in_f64() {
    all::<f64>(closing(), F64, |outcome| is_proved(outcome, 1e9));
}

#[test]
fn closing_walls_are_proved_infeasible_in_f32() {
    all::<f32>(closing(), F32, |outcome| is_proved(outcome, 1e3));
}

#[test]
fn narrow_walls_in_f64() {
    solved::<f64>(narrow(), F64);
}

#[test]
fn narrow_walls_in_f32() {
    solved::<f32>(narrow(), F32);
}
