//! Sparse and dense linear algebra: orderings, Cholesky (analyse once, factor often,
//! solve many), conjugate gradients, reductions in a fixed order.
