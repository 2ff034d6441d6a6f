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
    Contact {
        jacobian,
        offset: SVector::zeros(),
        mu: 0.5,
        key: 0,
    }
}

fn solve<const N: usize>(
    scene: &Scene<f64, N, 3, 1>,
    factor: &Factor<f64, N, 3, 1>,
    push: SVector<f64, N>,
) -> Result<Solution<f64, N, 3, 1>, Error> {
    let mut solver = Solver::new();
    let solution = solver.solve(scene, factor, &-push, &Settings::new(1e-10))?;
    assert_eq!(solution.status, Status::Solved);
    Ok(solution.clone())
}

/// One contact of 56 dofs, which moves three of them, at every place.
#[test]
fn a_contact_moves_its_dofs_wherever_they_are() -> Result<(), Error> {
    const N: usize = 56;
    for first in 0..=N - 3 {
        let mut scene = Scene::<f64, N, 3, 1>::new();
        scene.set_mass(&SMatrix::identity())?;
        scene.push(&contact(limb(first)))?;
        let mut push = SVector::<f64, N>::repeat(-1.0);
        push.fixed_rows_mut::<3>(first)
            .copy_from(&vector![-3.0, -0.5, -0.25]);
        let solution = solve(&scene, &Factor::new(&scene)?, push)?;
        assert_eq!(solution.contacts[0].mode, ContactMode::Stick);
        let moved = solution.velocity.fixed_rows::<3>(first).norm();
        assert!(moved < 1e-9, "dofs from {first} on move by {moved}");
        let others = solution.velocity.sum();
        assert!((others + 53.0).abs() < 1e-9, "the others by {others}");
    }
    Ok(())
}

/// A foot that becomes another one, of a robot with a base of six dofs and four legs.
#[test]
fn a_jacobian_is_replaced_by_one_with_other_columns() -> Result<(), Error> {
    const N: usize = 18;
    let mass = SMatrix::<f64, N, N>::from_fn(|i, j| {
        let coupled = i < 6 || j < 6;
        if i == j {
            4.0
        } else if coupled {
            0.125
        } else {
            0.0
        }
    });
    let leg = |first: usize| limb::<N>(first) + limb::<N>(0) + limb::<N>(3);
    let push = SVector::from_fn(|i, _| if i % 3 == 0 { -2.0 } else { 0.25 });
    let mut replaced = Scene::<f64, N, 3, 1>::new();
    replaced.set_mass(&mass)?;
    replaced.push(&contact(leg(6)))?;
    let mut factor = Factor::new(&replaced)?;
    for first in [9, 12, 15, 6] {
        let mut fresh = Scene::<f64, N, 3, 1>::new();
        fresh.set_mass(&mass)?;
        fresh.push(&contact(leg(first)))?;
        replaced.set_jacobian(0, &leg(first))?;
        factor.update(&replaced)?;
        let complete = Factor::new(&fresh)?;
        let found = complete
            .parts()
            .expect("all contacts and a resolvent")
            .delassus;
        let inverse = mass.try_inverse().expect("positive definite");
        let wanted = leg(first) * inverse * leg(first).transpose();
        for (row, [entries]) in found[0].iter().enumerate() {
            for (column, entry) in entries.iter().enumerate() {
                assert!((entry - wanted[(row, column)]).abs() < 1e-12);
            }
        }
        let expected = solve(&fresh, &complete, push)?;
        let found = solve(&replaced, &factor, push)?;
        assert_eq!(found.velocity, expected.velocity);
        assert_eq!(found.contacts, expected.contacts);
    }
    Ok(())
}
