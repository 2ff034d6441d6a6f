//! Small dense linear algebra.

pub(crate) mod block_factor;
pub(crate) mod blocks;
pub(crate) mod cholesky;
pub(crate) mod dot2;
pub(crate) mod elimination;
pub(crate) mod flat;
pub(crate) mod lu;
pub(crate) mod sparsity;
pub(crate) mod stacked;
pub(crate) mod substitution;
pub(crate) mod sum;
pub(crate) mod vector;
pub(crate) mod zip;
