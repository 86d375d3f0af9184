//! Solving lattice systems: Cholesky in nested-dissection order, or conjugate gradients.

mod direct;

pub use direct::{AnalysedLattice, DirectSolver, SolverError, Support};
