//! `W` against a computation with dense matrices.
#![allow(clippy::indexing_slicing, clippy::expect_used)]

use crate::{Contact, Error, Factor, Scene};
use nalgebra::{Matrix3, SMatrix, SVector};

const N: usize = 18;

/// A mass matrix with off-diagonal entries for coupled dofs.
fn mass(are_coupled: impl Fn(usize, usize) -> bool) -> SMatrix<f64, N, N> {
    SMatrix::from_fn(|i, j| match (i == j, are_coupled(i, j)) {
        (true, _) => 4.0,
        (_, true) => 0.125,
        _ => 0.0,
    })
}

/// A Jacobian whose three rows move three groups of three dofs each.
fn jacobian(first: [usize; 3]) -> SMatrix<f64, 3, N> {
    let rows = Matrix3::new(1.0, 0.25, 0.5, -0.5, 1.0, 0.25, 0.125, -0.25, 1.0);
    let mut jacobian = SMatrix::<f64, 3, N>::zeros();
    for first in first {
        jacobian.fixed_view_mut::<3, 3>(0, first).copy_from(&rows);
    }
    jacobian
}

/// `W = H M⁻¹ Hᵀ` of the feet of a robot, and of a pile of bodies, which the mass matrix does not couple.
#[test]
fn the_delassus_operator_is_that_of_dense_matrices() -> Result<(), Error> {
    let robot = mass(|i, j| i < 6 || j < 6);
    let pile = mass(|i, j| i.div_euclid(6) == j.div_euclid(6));
    let cases = [(robot, [[6, 0, 3], [9, 0, 3], [15, 0, 3]]), (pile, [[3, 6, 9], [3, 12, 15], [9, 12, 15]])];
    for (mass, groups) in cases {
        let inverse = mass.try_inverse().expect("positive definite");
        let mut scene = Scene::<f64, N, 3, 3>::new();
        scene.set_mass(&mass)?;
        for first in groups {
            scene.push(&Contact { jacobian: jacobian(first), offset: SVector::zeros(), mu: 0.5, key: 0 })?;
        }
        let factor = Factor::new(&scene)?;
        for (rows, left) in factor.delassus().contacts.iter().zip(groups) {
            for (column, right) in groups.into_iter().enumerate() {
                let wanted = jacobian(left) * inverse * jacobian(right).transpose();
                let block = SMatrix::from_fn(|i, j| rows[i][column][j]);
                assert!((block - wanted).norm() < 1e-12, "{block} {wanted}");
            }
        }
    }
    Ok(())
}
