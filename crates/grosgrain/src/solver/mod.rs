//! Solving lattice systems: Cholesky in nested-dissection order, or conjugate gradients.

mod direct;
mod free_support;
mod lattice_solver;

pub use direct::{AnalysedLattice, DirectSolver, SolverError, Support};
pub use free_support::free_support;
pub use lattice_solver::{LatticeSolver, SolveReport, SolverChoice};

/// Relative residual ‖f − K u‖ / ‖f‖ that every solution reaches.
pub const TOLERANCE: f64 = 1e-8;
