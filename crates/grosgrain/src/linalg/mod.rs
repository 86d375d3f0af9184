//! Sparse and dense linear algebra: orderings, Cholesky (analyse once, factor often,
//! solve many), conjugate gradients, reductions in a fixed order.

mod cholesky;
mod conjugate_gradients;
mod dense_cholesky;
mod disjoint_sets;
mod graph_order;
pub(crate) mod lanes;
pub mod matrix3;
pub(crate) mod matrix3_lanes;
mod multifrontal;
mod ordering;
mod polar;
mod reduction;
mod small_svd;
mod sparse_pattern;

pub use cholesky::{Cholesky, CholeskyError, FactorScalar, SymbolicCholesky};
pub use conjugate_gradients::{
    ConjugateGradientError, ConjugateGradientInfo, ConjugateGradientParameters, ConjugateGradientWorkspace,
    ConjugateGradients, Identity, LinearOperator, Monitor, Preconditioner, Projector,
};
pub use dense_cholesky::{DenseCholesky, DenseCholeskyError};
pub(crate) use disjoint_sets::DisjointSets;
pub use graph_order::{GraphOrderError, clique_order, graph_of_cliques, graph_order};
pub use multifrontal::{
    DenseFront, Eliminated, FrontalFactors, FrontalPlan, FrontalPlanError, FrontalSolver, box_tree, box_tree_around,
};
pub use ordering::{nested_dissection, postordered};
pub(crate) use polar::Polar;
pub use reduction::{dot, norm, step, sum_of_blocks};
pub use small_svd::SmallSvd;
pub use sparse_pattern::SparsePattern;
