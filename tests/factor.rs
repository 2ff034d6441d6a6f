//! Factors that are hard to compute, or were of another scene.

use crate::support::sizes::joints;
use nalgebra::{SMatrix, SVector, matrix, vector};
use stiction::{AdmmFactor, Contact, Error, Factor, Scene, Settings, Solver, Status, Work};

/// A feather twice on the floor beside five blocks: too light for the penalty of all.
#[test]
fn masses_too_unlike_for_a_resolvent_are_solved_all_the_same() -> Result<(), Error> {
    let masses = SVector::<f32, 12>::from_fn(|dof, _| if dof < 2 { 1e-8 } else { 1.0 });
    let mut scene = Scene::<f32, 12, 2, 7>::new();
    scene.set_mass(&SMatrix::from_diagonal(&masses))?;
    for (key, body) in (0..).zip([0, 0, 1, 2, 3, 4, 5]) {
        let mut jacobian = SMatrix::<f32, 2, 12>::zeros();
        (jacobian[(0, 2 * body + 1)], jacobian[(1, 2 * body)]) = (1.0, 1.0);
        scene.push(&Contact { jacobian, offset: SVector::zeros(), mu: 0.5, key })?;
    }
    let refused = AdmmFactor::new(&scene).err();
    assert_eq!(refused, Some(Error::InvalidPenalty));
    let mut factor = Factor::empty();
    factor.prepare(&scene)?;
    let mut solver = Solver::new();
    let solution = solver.solve(&scene, &factor, &-masses, &Settings::new(1e-4))?;
    assert_eq!(solution.status, Status::Solved);
    Ok(())
}

/// Where `W` overflows, at one contact among others, nothing can be said of its error.
#[test]
fn an_infinite_delassus_operator_is_refused() -> Result<(), Error> {
    let mut scene = joints::Scene::<f32>::new();
    scene.set_mass(&SMatrix::from_diagonal(&vector![1.0, 1e-12]))?;
    for (key, jacobian) in (0..).zip([matrix![1.0, 0.0], matrix![0.0, 1e14]]) {
        scene.push(&Contact { jacobian, offset: vector![0.0], mu: 0.0, key })?;
    }
    let mut factor = Factor::empty();
    assert_eq!(factor.prepare(&scene), Err(Error::DelassusOutOfRange { contact: 1 }));
    assert!(!factor.is_current(&scene));
    Ok(())
}

/// A factor that was of more contacts has nothing of them left.
#[test]
fn walls_are_proved_to_close_with_a_factor_that_was_another_scene_s() -> Result<(), Error> {
    let scene = |normals: &[[f64; 2]], offset| -> Result<_, Error> {
        let mut scene = Scene::<f64, 2, 2, 4>::new();
        scene.set_mass(&SMatrix::identity())?;
        for (key, &[x, y]) in (0..).zip(normals) {
            scene.push(&Contact {
                jacobian: matrix![x, y; y, -x],
                offset: vector![offset, 0.0],
                mu: 0.3,
                key,
            })?;
        }
        Ok(scene)
    };
    let mut factor = Factor::empty();
    factor.prepare(&scene(&[[1.0, 0.0], [1.0, 0.0], [-3.0, 0.0], [-3.0, 0.0]], 0.0)?)?;
    let walls = scene(&[[1.0, 0.0], [-1.0, 0.0]], -1.0)?;
    factor.prepare(&walls)?;
    let mut solver = Solver::new();
    let solution = solver.solve(&walls, &factor, &vector![-0.1, -0.05], &Settings::default())?;
    assert_eq!(solution.status, Status::Infeasible);
    Ok(())
}

/// Numbers from outside may be too large to be added up.
#[test]
fn work_from_outside_does_not_overflow() {
    let most = usize::MAX;
    let work =
        Work { iterations: most, sweeps: most, chord_steps: most, newton_steps: most, proof_searches: most };
    assert_eq!(work.total(), most);
}
