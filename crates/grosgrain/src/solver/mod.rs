//! Solving lattice systems and meshes of elements: Cholesky in nested-dissection order, or conjugate gradients with multigrid.

mod block_matrix;
mod direct;
mod element_system;
mod free_support;
mod lattice_solver;
pub mod multigrid;
mod refined_cholesky;
mod rigid_motions;
mod tangent;

pub use direct::{AnalysedLattice, DirectSolver, SolverError, Support};
pub use element_system::ElementSystem;
pub use free_support::{free_support, six_components, six_components_among};
pub use lattice_solver::{Hold, LatticeSystem, SolveReport, SolverChoice};
pub use multigrid::{Cycle, Multigrid, MultigridError, MultigridParameters};
pub(crate) use refined_cholesky::RefinedCholesky;
pub use rigid_motions::RigidMotions;
pub use tangent::{COARSE_FACTOR_LIMIT, ElementCells, ElementTangent, FACTOR_LIMIT, LatticeTangent, LinearReport};

/// Relative residual ‖f − K u‖ / ‖f‖ that every solution of a lattice system or a mesh of elements reaches. (Local training problems are eliminated from outside
/// in without a solution for all unknowns, so there is no residual; see `training`.)
pub const TOLERANCE: f64 = 1e-8;
