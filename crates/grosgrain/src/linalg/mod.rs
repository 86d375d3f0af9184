//! Sparse and dense linear algebra: orderings, Cholesky (analyse once, factor often,
//! solve many), conjugate gradients, reductions in a fixed order.

mod cholesky;
mod conjugate_gradients;
mod dense_cholesky;
pub(crate) mod lanes;
pub mod matrix3;
pub(crate) mod matrix3_lanes;
mod multifrontal;
mod ordering;
mod reduction;
mod sparse_pattern;

pub use cholesky::{Cholesky, CholeskyError, FactorScalar, SymbolicCholesky};
pub use conjugate_gradients::{
    ConjugateGradientError, ConjugateGradientInfo, ConjugateGradientParameters, ConjugateGradientWorkspace,
    ConjugateGradients, Identity, LinearOperator, Monitor, Preconditioner, Projector,
};
pub use dense_cholesky::{DenseCholesky, DenseCholeskyError};
pub use multifrontal::{
    DenseFront, Eliminated, FrontalFactors, FrontalPlan, FrontalPlanError, FrontalSolver, box_tree, box_tree_around,
};
pub use ordering::{nested_dissection, postordered};
pub use reduction::{dot, norm, step, sum_of_blocks};
pub use sparse_pattern::SparsePattern;
