//! The start of a cold solve of a cube that lies, is pushed, slides and flies.

#![allow(clippy::indexing_slicing)]

use crate::linalg::stacked::Stacked;
use crate::problem::{Age, Problem};
use crate::solver::fixtures::{cube, pressed, with_problem};
use crate::{Error, Factor, JointRow, RowLaw, Scene, Settings};
use nalgebra::SVector;

/// Is a cube on `corners` corners likely to stick, if it is pushed `sideways` and `up`?
fn likely(corners: usize, mu: f64, sideways: f64, up: f64) -> Result<bool, Error> {
    let mut push = pressed(sideways);
    push.z += up;
    with_problem(&cube(corners, mu)?, &push, |problem| problem.is_likely_to_stick())
}

#[test]
fn the_mode_of_a_cube_is_expected() -> Result<(), Error> {
    assert!(likely(4, 0.5, 0.0, 0.0)?);
    assert!(likely(4, 0.5, 0.3, 0.0)?);
    assert!(!likely(1, 0.5, 0.0, 0.0)?); // three rows, six dofs
    assert!(!likely(4, 0.5, 0.6, 0.0)?); // more than friction holds
    assert!(!likely(4, 0.5, 4.0, 0.0)?); // slides: one row a contact
    assert!(!likely(4, 0.5, 0.0, 2.0)?); // flies
    assert!(!likely(4, 0.0, 0.0, 0.0)?); // no friction, no tangential rows
    Ok(())
}

#[test]
fn the_guess_has_every_contact_pushed_and_sticking() -> Result<(), Error> {
    with_problem(&cube(4, 0.5)?, &pressed(0.1), |problem| {
        let mut z = Stacked::zero();
        problem.all_sticking(&mut z);
        assert_eq!(problem.sets.contacts().len(), z.contacts.len());
        for (&z, set) in z.contacts.iter().zip(problem.sets.contacts()) {
            let z = SVector::from(z);
            let impulse = set.cone.dual().nearest(&z) - z;
            assert!(set.cone.is_interior(&impulse), "{impulse}");
        }
    })
}

#[test]
fn impulses_of_a_corner_are_unique_and_those_of_four_are_not() -> Result<(), Error> {
    with_problem(&cube(4, 0.5)?, &pressed(0.0), |problem| {
        let push = [1.0, 0.0, 0.0];
        let is_hyperstatic = |contacts| {
            let r = Stacked { contacts, rows: [] };
            problem.is_hyperstatic(&r, problem.sets.holding_rows(&r))
        };
        let none = [0.0; 3];
        assert!(is_hyperstatic([push; 4]));
        assert!(!is_hyperstatic([push, none, none, none]));
        // Two corners have six rows, and nothing stops a turn about the line between them.
        assert!(is_hyperstatic([push, push, none, none]));
    })
}

/// Dry friction of joints beside three corners: the impulse of a slipping row is known, so it adds no unknown.
#[test]
fn rows_at_their_bounds_make_no_impulse_ambiguous() -> Result<(), Error> {
    let mut scene = Scene::<f64, 6, 3, 3, 6>::new();
    for contact in cube(3, 0.5)?.contacts() {
        scene.set_mass(cube(3, 0.5)?.mass())?;
        scene.push(contact)?;
    }
    for axis in 0..6 {
        let mut row = SVector::zeros();
        row[axis] = 1.0;
        let (lower, upper) = (-0.1, 0.1);
        scene.push_row(&JointRow {
            row,
            offset: 0.0,
            law: RowLaw::Box { lower, upper },
            compliance: 0.0,
            key: 0,
        })?;
    }
    let (factor, push) = (Factor::new(&scene)?, pressed(0.0));
    let mut problem = Problem::new(&scene, &factor, &push, &Settings::default(), Age::New);
    problem.fill(true);
    let corner = [1.0, 0.0, 0.0];
    let is_hyperstatic = |rows| {
        let r = Stacked { contacts: [corner, [0.0; 3], [0.0; 3]], rows };
        problem.is_hyperstatic(&r, problem.sets.holding_rows(&r))
    };
    let (slipping, holding) = ([1e3; 6], [0.0; 6]);
    assert!(!is_hyperstatic(slipping));
    assert!(is_hyperstatic(holding));
    Ok(())
}
