//! Newton systems (K + shift M) x = r: the matrices change in every iteration, the pattern stays, tolerances are loose.

mod element;
mod lagged_factor;
mod lattice;
mod lattice_cycle;
mod wear;

pub use element::{ElementCells, ElementTangent};
pub use lattice::LatticeTangent;

use super::SolverError;
use crate::linalg::ConjugateGradientError;

/// Number of unknowns of a lattice up to which a Cholesky factor serves Newton systems as well as a multigrid cycle or better, counted by operations
/// and measured with `examples/tangent_solvers.rs`.
pub const FACTOR_LIMIT: usize = 8_000;

/// The same for coarse elements: in stiff layers and bones that these do not resolve a cycle needs many iterations, a factor of the last matrix few
/// (measured on the cut trunk of `scenes/fig4-abdomen.toml`, 26,000 unknowns; factors grow with the power 4/3 of the unknowns, their cost with the square).
pub const COARSE_FACTOR_LIMIT: usize = 60_000;

/// How a Newton system was solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearReport {
    /// Iterations of conjugate gradients, those with a preconditioner that was given up included.
    pub iterations: usize,
    /// True ‖f − K x‖ / ‖f‖.
    pub relative_residual: f64,
    /// Whether the preconditioner was renewed during the solve.
    pub refactored: bool,
}

/// Negative curvature as an error of its own.
fn indefinite(error: ConjugateGradientError, unknowns: usize) -> SolverError {
    match error {
        ConjugateGradientError::Indefinite { what, value, iteration } => {
            let evidence = format!("{what} has the quadratic form {value:.2e} in iteration {iteration}");
            SolverError::Indefinite { unknowns, evidence }
        }
        other => other.into(),
    }
}
