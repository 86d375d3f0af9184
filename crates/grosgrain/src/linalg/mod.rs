//! Sparse and dense linear algebra: orderings, Cholesky (analyse once, factor often,
//! solve many), conjugate gradients, reductions in a fixed order.

mod cholesky;
mod ordering;
mod sparse_pattern;

pub use cholesky::{Cholesky, CholeskyError, SymbolicCholesky};
pub use ordering::nested_dissection;
pub use sparse_pattern::SparsePattern;
