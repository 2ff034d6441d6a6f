//! Small dense linear algebra: all that knows how a compiler turns loops into code.

pub(crate) mod blocks;
pub(crate) mod cholesky;
pub(crate) mod dot2;
pub(crate) mod elimination;
pub(crate) mod hints;
pub(crate) mod pivot;
pub(crate) mod sparsity;
pub(crate) mod substitution;
