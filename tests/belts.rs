//! Two boxes on each other fall onto a belt, bounce, slide and go with it: a thousand steps, each judged by a stranger.

use crate::support::boxes::{BRICK, GRAVITY, point_jacobian};
use nalgebra::{DMatrix, DVector, Vector3, matrix, vector};
use stiction::time_stepping::{Gap, Restitution, moving_surface};
use stiction::{Error, Settings, Status};
use testbed::kernel::{Constructor, Shape, smallest};
use testbed::measure::{self, Law};
use testbed::method::Method;
use testbed::scene_file::SceneFile;

/// Velocities, 6 of each box, and contact rows, 4 contacts under each.
const N: usize = 12;
const ROWS: usize = 24;
/// m/s
const BELT: f64 = 0.4;
/// s
const STEP: f64 = 2e-3;

/// Positions and small turns of both boxes, and their velocities.
struct State {
    position: DVector<f64>,
    velocity: DVector<f64>,
}

/// The next step's scene.
fn scene(state: &State, e: f64) -> Result<SceneFile, Error> {
    let half = BRICK.half[2];
    let mut file = SceneFile {
        name: "boxes on a belt".to_owned(),
        n_dof: N,
        n_contacts: 8,
        dim: 3,
        mass: DMatrix::zeros(N, N),
        h: DMatrix::zeros(ROWS, N),
        f: DVector::zeros(N),
        w: DVector::zeros(ROWS),
        mu: vec![0.6; 8],
        keys: (0..8).collect(),
    };
    let mass = BRICK.mass_matrix();
    for body in [0, 6] {
        file.mass.view_mut((body, body), (6, 6)).copy_from(&mass);
        let velocity = state.velocity.rows(body, 6);
        let mut push = mass * velocity;
        push[2] -= BRICK.mass * GRAVITY * STEP;
        file.f.rows_mut(body, 6).copy_from(&-push);
    }
    let frame = matrix![0.0, 0.0, 1.0; 1.0, 0.0, 0.0; 0.0, 1.0, 0.0]; // normal z, tangents x, y
    let belt = moving_surface(&frame, &vector![BELT, 0.0, 0.0]);
    for (k, corner) in BRICK.corners().into_iter().enumerate() {
        let top = Vector3::new(corner.x, corner.y, half);
        for (contact, body) in [(k, 0), (4 + k, 6)] {
            let mut rows = file.h.rows_mut(3 * contact, 3);
            rows.columns_mut(body, 6).copy_from(&point_jacobian(&corner));
            if body == 6 {
                rows.columns_mut(0, 6).copy_from(&-point_jacobian(&top));
            }
            let normal = file.h.row(3 * contact).transpose();
            let rest = if body == 6 { 2.0 * half } else { half };
            let distance = normal.dot(&state.position) - rest;
            let gap = Gap { distance, recovery: 0.5, reach: 50.0 };
            let offset = gap.offset(STEP)?;
            let approach = normal.dot(&state.velocity);
            file.w[3 * contact] = Restitution { coefficient: e, threshold: 0.1 }.offset(approach, offset)?;
            if body == 0 {
                file.w[3 * contact + 1] += belt.y;
                file.w[3 * contact + 2] += belt.z;
            }
        }
    }
    Ok(file)
}

fn run(constructor: Constructor, e: f64, tolerance: f64) -> Result<(), Error> {
    let shape = Shape { dofs: N, dim: 3, contacts: 8 };
    let mut kernel = constructor(shape).expect("a size is compiled");
    let half = BRICK.half[2];
    let mut state = State { position: DVector::zeros(N), velocity: DVector::zeros(N) };
    (state.position[2], state.position[8]) = (half + 0.05, 3.0 * half + 0.05);
    let (mut fastest, mut bounces) = (0.0_f64, 0);
    for step in 0..1_000 {
        let file = scene(&state, e)?;
        kernel.load(&file)?;
        kernel.prepare(Method::Default)?;
        kernel.solve(Method::Default, &Settings::new(tolerance))?;
        let answer = kernel.answer();
        assert_eq!(answer.status, Status::Solved, "step {step} of e = {e}");
        let error = measure::error(&kernel.rounded(&file), &answer.v, &answer.r, Law::Coulomb);
        assert!(error <= tolerance, "step {step} of e = {e}: {error:e}");
        let velocity = DVector::from_vec(answer.v);
        bounces += usize::from(state.velocity[2] < -0.1 && velocity[2] > 0.02);
        state.position += &velocity * STEP;
        state.velocity = velocity;
        // Friction drives both, and none faster than the belt: but for what a step may be wrong by.
        let mean = f64::midpoint(state.velocity[0], state.velocity[6]);
        fastest = fastest.max(mean);
    }
    assert!(fastest <= BELT * (1.0 + 1_000.0 * tolerance), "{fastest}");
    assert_eq!(bounces > 0, e > 0.0, "{bounces} bounces with e = {e}");
    for body in [0, 6] {
        let velocity = state.velocity.rows(body, 6);
        let (along, rest) = (velocity[0], velocity.rows(1, 5));
        let moved = (along - BELT).abs().max(rest.norm());
        assert!(moved < 1e-3, "e = {e}: {moved}");
    }
    Ok(())
}

#[test]
fn boxes_bounce_on_a_belt_and_go_with_it_in_double_precision() -> Result<(), Error> {
    run(smallest::<f64>, 0.0, 1e-8)?;
    run(smallest::<f64>, 0.4, 1e-8)
}

#[test]
fn boxes_bounce_on_a_belt_and_go_with_it_in_single_precision() -> Result<(), Error> {
    run(smallest::<f32>, 0.0, 1e-4)?;
    run(smallest::<f32>, 0.4, 1e-4)
}
