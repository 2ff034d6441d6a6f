//! Columns of a Jacobian that are zero are left out; the others are not, wherever they are.

use nalgebra::{SMatrix, SVector, vector};
use stiction::{Contact, ContactMode, Error, Factor, Scene, Settings, Solution, Solver, Status};

/// Three rows that move three dofs from `first` on.
fn limb<const N: usize>(first: usize) -> SMatrix<f64, 3, N> {
    let mut jacobian = SMatrix::<f64, 3, N>::zeros();
    let rows = SMatrix::<f64, 3, 3>::new(1.0, 0.25, 0.5, -0.5, 1.0, 0.25, 0.125, -0.25, 1.0);
    jacobian.fixed_view_mut::<3, 3>(0, first).copy_from(&rows);
    jacobian
}

fn contact<const N: usize>(jacobian: SMatrix<f64, 3, N>) -> Contact<f64, N, 3> {
    Contact { jacobian, offset: SVector::zeros(), mu: 0.5, key: 0 }
}

fn solve<const N: usize>(
    scene: &Scene<f64, N, 3, 12>,
    factor: &Factor<f64, N, 3, 12>,
    push: SVector<f64, N>,
) -> Result<Solution<f64, N, 3, 12>, Error> {
    let mut solver = Solver::new();
    let solution = solver.solve(scene, factor, &push, &Settings::new(1e-10))?;
    assert_eq!(solution.status, Status::Solved);
    Ok(solution.clone())
}

/// One contact of 56 dofs, which moves three of them, at every place.
#[test]
fn a_contact_moves_its_dofs_wherever_they_are() -> Result<(), Error> {
    const N: usize = 56;
    for first in 0..=N - 3 {
        let mut scene = Scene::<f64, N, 3, 12>::new();
        scene.set_mass(&SMatrix::identity())?;
        scene.push(&contact(limb(first)))?;
        let mut push = SVector::<f64, N>::repeat(-1.0);
        push.fixed_rows_mut::<3>(first).copy_from(&vector![-3.0, -0.5, -0.25]);
        let solution = solve(&scene, &Factor::new(&scene)?, push)?;
        assert_eq!(solution.contacts[0].mode, ContactMode::Stick);
        let moved = solution.velocity.fixed_rows::<3>(first).norm();
        assert!(moved < 1e-9, "dofs from {first} on move by {moved}");
        let others = solution.velocity.sum();
        assert!((others + 53.0).abs() < 1e-9, "the others by {others}");
    }
    Ok(())
}

const N: usize = 18;

/// A mass matrix with entries where dofs are coupled.
fn mass(are_coupled: impl Fn(usize, usize) -> bool) -> SMatrix<f64, N, N> {
    SMatrix::from_fn(|i, j| match (i == j, are_coupled(i, j)) {
        (true, _) => 4.0,
        (_, true) => 0.125,
        _ => 0.0,
    })
}

/// Of a base of six dofs with four legs.
fn robot() -> SMatrix<f64, N, N> {
    mass(|i, j| i < 6 || j < 6)
}

/// The dofs of a leg, or of half a body, and six others.
fn pair(first: usize, other: usize) -> SMatrix<f64, 3, N> {
    limb(first) + limb(other) + limb(other + 3)
}

/// A foot that becomes another one.
#[test]
fn a_jacobian_is_replaced_by_one_with_other_columns() -> Result<(), Error> {
    let push = SVector::from_fn(|i, _| if i % 3 == 0 { -2.0 } else { 0.25 });
    let mut replaced = Scene::new();
    replaced.set_mass(&robot())?;
    replaced.push(&contact(pair(6, 0)))?;
    let mut factor = Factor::new(&replaced)?;
    for first in [9, 12, 15, 6] {
        let mut fresh = Scene::new();
        fresh.set_mass(&robot())?;
        fresh.push(&contact(pair(first, 0)))?;
        replaced.set_jacobian(0, &pair(first, 0))?;
        factor.prepare(&replaced)?;
        let expected = solve(&fresh, &Factor::new(&fresh)?, push)?;
        let found = solve(&replaced, &factor, push)?;
        assert_eq!(found.velocity, expected.velocity);
        assert_eq!(found.contacts, expected.contacts);
    }
    Ok(())
}
