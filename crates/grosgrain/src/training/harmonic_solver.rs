//! The harmonic displacements of a body that changes.

use std::sync::Arc;

use super::TrainingError;
use super::global::{HarmonicDisplacements, loads, without_rigid_motion};
use crate::assembly::{CellStiffness, LatticePattern, active_nodes};
use crate::fine::{FineModel, HARMONIC_FIELDS};
use crate::mesh::Lattice;
use crate::progress::Progress;
use crate::solver::{AnalysedLattice, DirectSolver, SolveReport, SolverChoice, SolverError, TOLERANCE, free_support};

/// Up to this many unknowns the lattice is factored anew at every change.
pub const REFACTOR_LIMIT: usize = 150_000;

/// Solves for the harmonic displacements of a lattice again and again while its cells change.
///
/// Up to [`REFACTOR_LIMIT`] unknowns the order of elimination is found once, for all nodes of the lattice whether the body touches
/// them or not, and a change costs a numerical factorisation and six solves. Larger lattices are solved as by
/// [`HarmonicDisplacements::solve`].
#[derive(Debug)]
pub struct HarmonicSolver {
    direct: Option<DirectSolver>,
}

impl HarmonicSolver {
    /// A solver for bodies on `lattice`.
    ///
    /// # Errors
    /// When the factor does not fit into memory.
    pub fn new(lattice: Lattice) -> Result<Self, TrainingError> {
        if 3 * lattice.node_count() > REFACTOR_LIMIT {
            return Ok(Self { direct: None });
        }
        let analysed = AnalysedLattice::new(LatticePattern::full(lattice)).map_err(TrainingError::Global)?;
        let direct = DirectSolver::for_large(Arc::new(analysed), HARMONIC_FIELDS).map_err(TrainingError::Global)?;
        Ok(Self { direct: Some(direct) })
    }

    /// The harmonic displacements of `model` as it is now.
    ///
    /// # Errors
    /// When the systems are not solved, or the callback interrupts.
    ///
    /// # Panics
    /// Panics when the model is not on the lattice of this solver.
    pub fn solve(&mut self, model: &FineModel, progress: Progress<'_>) -> Result<HarmonicDisplacements, TrainingError> {
        let Some(direct) = &mut self.direct else {
            return HarmonicDisplacements::solve(model, SolverChoice::Auto, progress);
        };
        assert_eq!(direct.analysed().pattern().lattice(), model.lattice(), "a model on another lattice");
        let (lattice, spacing) = (model.lattice(), model.grid().spacing);
        let active = active_nodes(model);
        let mut displacements = loads(model);
        let support = free_support(lattice, spacing, &model.grid().void, &active);
        direct.factor(model, &support).map_err(TrainingError::Global)?;
        let residual = direct.solve_in_place(&mut displacements);
        if residual.is_nan() || residual > TOLERANCE {
            let order = direct.analysed().pattern().order();
            let source = SolverError::Inaccurate { residual, tolerance: TOLERANCE, order };
            return Err(TrainingError::Global(source));
        }
        let report = SolveReport {
            kind: "cholesky",
            reason: format!("the order of elimination is kept up to {REFACTOR_LIMIT} unknowns"),
            unknowns: 3 * model.active_count(),
            iterations: 0,
            relative_residual: residual,
        };
        Ok(HarmonicDisplacements { displacements: without_rigid_motion(model, displacements), report })
    }
}
