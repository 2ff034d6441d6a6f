//! `W` against a computation with dense matrices.
#![allow(clippy::indexing_slicing, clippy::expect_used, clippy::unreadable_literal)]

use crate::{Contact, Error, Factor, Real, Scene};
use nalgebra::{Matrix3, SMatrix, SVector, matrix};

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

/// The estimate of the rounding of `W` covers it for a mass that single precision hardly tells from a singular one, although its pivots
/// do not say so.
#[test]
fn a_mass_that_is_nearly_singular_leaves_w_uncertain() -> Result<(), Error> {
    let mass: Matrix3<f32> = matrix![
        0.00026551797, -0.0065695215, -0.009640205;
        -0.0065695215, 0.31880343, 0.46596348;
        -0.009640205, 0.46596348, 0.681064];
    let jacobian = matrix![0.0, 0.0, 1.0];
    let single = factor::<f32>(&mass, &jacobian)?;
    let double = factor::<f64>(&mass.cast(), &jacobian.cast())?;
    let (w, wanted) = (f64::from(single.delassus().trace(0)), double.delassus().trace(0));
    let off = (w / wanted - 1.0).abs();
    assert!(off > 0.5 && f64::from(single.uncertainty()) > off, "{off} {}", single.uncertainty());
    assert!(double.uncertainty() < 1e-5, "{}", double.uncertainty());
    assert!(single.is_uncertain() && !double.is_uncertain());
    Ok(())
}

/// The factor of a mass and one row without tangents.
fn factor<T: Real>(mass: &Matrix3<T>, jacobian: &SMatrix<T, 1, 3>) -> Result<Factor<T, 3, 1, 1>, Error> {
    let mut scene = Scene::<T, 3, 1, 1>::new();
    scene.set_mass(mass)?;
    scene.push(&Contact { jacobian: *jacobian, offset: SVector::zeros(), mu: T::ZERO, key: 0 })?;
    Factor::new(&scene)
}
