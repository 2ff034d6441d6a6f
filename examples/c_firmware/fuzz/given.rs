//! Numbers as Rust and C are given them.

use crate::c;
use crate::c::{D, N, Real};
use crate::steps::Law;
use nalgebra::{SMatrix, SVector};
use stiction::{Contact, JointRow, RowLaw, Surface};

pub(crate) fn number(x: f64) -> Real {
    stiction::Real::literal(x)
}

pub(crate) fn at(numbers: &[f64], i: usize) -> Real {
    number(numbers[i % numbers.len()])
}

pub(crate) fn vector<const K: usize>(numbers: &[f64]) -> SVector<Real, K> {
    SVector::from_fn(|i, _| at(numbers, i))
}

/// A matrix row by row, as C has it.
pub(crate) fn rows<const K: usize>(matrix: &SMatrix<Real, K, N>) -> [[Real; N]; K] {
    matrix.transpose().into()
}

pub(crate) fn contact(x: &[f64], mu: f64, key: u32) -> Contact<Real, N, D> {
    Contact {
        jacobian: SMatrix::from_fn(|row, dof| at(x, row * N + dof)),
        offset: SVector::from_fn(|row, _| at(x, D * N + row)),
        mu: number(mu),
        key,
    }
}

pub(crate) fn surface(x: &[f64]) -> Surface<Real> {
    Surface {
        friction: [at(x, 0), at(x, 1)],
        spin: at(x, 2),
        roll: [at(x, 3), at(x, 4)],
        compliance: [at(x, 5), at(x, 6)],
    }
}

pub(crate) fn surface_of_c(surface: &Surface<Real>) -> c::Surface {
    c::Surface {
        friction: surface.friction,
        spin: surface.spin,
        roll: surface.roll,
        compliance: surface.compliance,
    }
}

pub(crate) fn law((law, lower, upper): Law) -> RowLaw<Real> {
    let (lower, upper) = (number(lower), number(upper));
    match law {
        0 => RowLaw::Limit,
        1 => RowLaw::Equality,
        _ => RowLaw::Box { lower, upper },
    }
}

pub(crate) fn joint_row(x: &[f64], bounds: Law, compliance: f64, key: u32) -> JointRow<Real, N> {
    JointRow { row: vector(x), offset: at(x, N), law: law(bounds), compliance: number(compliance), key }
}

pub(crate) fn joint_row_of_c(row: &JointRow<Real, N>, law: u32, (_, lower, upper): Law) -> c::JointRow {
    c::JointRow {
        row: row.row.into(),
        offset: row.offset,
        law,
        lower: number(lower),
        upper: number(upper),
        compliance: row.compliance,
        key: row.key,
    }
}
