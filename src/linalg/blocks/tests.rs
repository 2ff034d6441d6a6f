//! Inverses of the blocks of contacts.

use super::inverse;
use nalgebra::SMatrix;
use proptest::array::uniform9;
use proptest::prelude::*;

/// Is `B⁻¹ B` the unit matrix, for `B = J Jᵀ + I/10`?
fn inverts<const D: usize>(entries: &[f64]) -> Result<(), TestCaseError> {
    let root = SMatrix::<f64, D, D>::from_iterator(entries.iter().copied());
    let block = root * root.transpose() + SMatrix::identity() * 0.1;
    let inverse = SMatrix::from_data(nalgebra::ArrayStorage(inverse(&block.data.0)));
    let error = (inverse * block - SMatrix::identity()).norm();
    prop_assert!(error <= 1e-13, "{D} rows: {error}");
    Ok(())
}

proptest! {
    #[test]
    fn a_block_of_up_to_three_rows_has_an_inverse(entries in uniform9(-1.0_f64..1.0)) {
        inverts::<1>(&entries)?;
        inverts::<2>(&entries)?;
        inverts::<3>(&entries)?;
    }
}

#[test]
fn a_singular_block_has_none() {
    assert_eq!(inverse(&[[0.0_f64]]), [[0.0]]);
    assert_eq!(inverse(&[[1.0_f64, 1.0], [1.0, 1.0]]), [[0.0; 2]; 2]);
    assert_eq!(inverse(&[[2.0_f32, 1.0, 3.0], [1.0, 2.0, 3.0], [3.0, 3.0, 6.0]]), [[0.0; 3]; 3]);
    // Singular but for rounding.
    let block = [[1.0 + f64::EPSILON, 1.0], [1.0, 1.0]];
    assert_eq!(inverse(&block), [[0.0; 2]; 2]);
    assert_eq!(inverse(&[[1.0_f64; 4]; 4]), [[0.0; 4]; 4]);
}
