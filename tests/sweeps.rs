//! Where impulses are unique a solve starts with Gauss-Seidel sweeps: on one contact they are all of it.

use crate::support::{check, random};
use nalgebra::{SMatrix, SVector};
use proptest::prelude::*;
use stiction::{Contact, Factor, Model, Scene, Settings, Solution, Solver, Status};
use testbed::generate::{self, Class};
use testbed::kernel::{self, smallest};
use testbed::measure::{self, Law};
use testbed::method::Method;
use testbed::solve::patient;

/// A contact of a body with as many dofs, its rows a little askew.
fn solve<const D: usize>(
    masses: &[f64],
    askew: &[f64],
    push: &[f64],
    mu: f64,
    model: Model,
) -> Solution<f64, D, D, D> {
    let mut scene = Scene::<f64, D, D, D>::new();
    let masses = SVector::<f64, D>::from_column_slice(&masses[..D]);
    scene.set_mass(&SMatrix::from_diagonal(&masses)).expect("positive masses");
    let askew = SMatrix::<f64, D, D>::from_column_slice(&askew[..D * D]);
    let contact = Contact { jacobian: SMatrix::identity() + askew, offset: SVector::zeros(), mu, key: 0 };
    scene.push(&contact).expect("a contact");
    let factor = Factor::new(&scene).expect("a factor");
    let free_impulse = SVector::<f64, D>::from_column_slice(&push[..D]);
    let mut solver = Solver::new();
    let settings = Settings { model, ..Settings::new(1e-9) };
    let solution = solver.solve(&scene, &factor, &free_impulse, &settings);
    solution.expect("finite data").clone()
}

proptest! {
    #[test]
    fn one_contact_is_solved_without_newton(
        masses in prop::array::uniform3(0.5_f64..2.0),
        askew in prop::array::uniform9(-0.15_f64..0.15),
        push in prop::array::uniform3(-1.0_f64..1.0),
        mu in 0.0_f64..0.6,
    ) {
        // Two tangents: each sweep begins with the `λ` of the one before.
        let spatial = solve::<3>(&masses, &askew, &push, mu, Model::Coulomb);
        prop_assert_eq!(spatial.status, Status::Solved);
        prop_assert_eq!(spatial.work.newton_steps, 0);
        prop_assert!(spatial.work.total() <= 2 * 3, "{}", spatial.work.total());
        // One tangent or none: exact at once.
        let planar = solve::<2>(&masses, &askew, &push, mu, Model::Coulomb);
        prop_assert_eq!((planar.status, planar.work.newton_steps), (Status::Solved, 0));
        prop_assert!(planar.work.total() <= 2, "{}", planar.work.total());
        let normal = solve::<1>(&masses, &askew, &push, mu, Model::Coulomb);
        prop_assert_eq!((normal.status, normal.work.newton_steps), (Status::Solved, 0));
        prop_assert!(normal.work.total() <= 2, "{}", normal.work.total());
    }
}

/// Each sweep is a step of Newton's method along the cone. Of a planar contact it is the end.
#[test]
fn one_contact_of_the_convex_relaxation_is_solved_without_newton() {
    let contacts = (
        prop::array::uniform3(0.5_f64..2.0),
        prop::array::uniform9(-0.15_f64..0.15),
        prop::array::uniform3(-1.0_f64..1.0),
        0.0_f64..0.6,
    );
    for (masses, askew, push, mu) in random::draws(contacts, 5000) {
        let spatial = solve::<3>(&masses, &askew, &push, mu, Model::ConvexRelaxation);
        assert_eq!((spatial.status, spatial.work.newton_steps), (Status::Solved, 0));
        assert!(spatial.work.total() <= 2 * 5, "{}", spatial.work.total());
        let planar = solve::<2>(&masses, &askew, &push, mu, Model::ConvexRelaxation);
        assert_eq!((planar.status, planar.work.newton_steps), (Status::Solved, 0));
        assert!(planar.work.total() <= 2, "{}", planar.work.total());
    }
}

/// A stranger measures that they obey the relaxed law.
#[test]
fn drawn_scenes_of_the_convex_relaxation() {
    let settings = Settings { model: Model::ConvexRelaxation, ..patient(1e-9) };
    let mut work = 0;
    for file in Class::DRAWN.iter().flat_map(|&class| generate::solvable(class, 20)) {
        let mut kernel = kernel::prepared(smallest::<f64>, &file, Method::Default).expect("a size");
        kernel.solve(Method::Default, &settings).expect("finite data");
        let answer = kernel.answer();
        assert_eq!(answer.status, Status::Solved, "{}", file.name);
        let error = measure::error(&file, &answer.v, &answer.r, Law::Relaxed);
        assert!(error <= 1e-9, "{}: {error:e}", file.name);
        work += answer.work.total();
    }
    assert!(check::is_no_more((work, 5436)), "{work}");
}
