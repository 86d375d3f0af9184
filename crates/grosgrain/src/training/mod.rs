//! Training data: harmonic displacements on the whole object, on the one-ring of a coarse cell, or on the cell alone.

mod cell_data;
mod condensed;
mod cost;
mod global;
mod harmonic_solver;
mod local;
mod rigid;
mod substructured;
mod trainer;

pub use cell_data::Training;
pub use cost::{RunTimeTraining, TrainingCost, run_time_training};
pub use global::HarmonicDisplacements;
pub use harmonic_solver::{HarmonicSolver, REFACTOR_LIMIT};
pub use local::{LocalTrainer, RingKind};
pub use substructured::{InterfaceForces, InterfaceSpace, Means, Substructures};
pub use trainer::Trainer;

use std::sync::Arc;

use crate::fine::FineModel;
use crate::partition::{CellPart, CoarseMesh};
use crate::progress::Progress;
use crate::solver::{SolveReport, SolverChoice, SolverError};

/// On which domain the harmonic displacements of a coarse cell are solved (`he2022fast`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrainingKind {
    /// The whole object.
    Global,
    /// The cell and its neighbours, clipped at the object's boundary.
    OneRing,
    /// The cell and its neighbours, coupled by a few means per interface; see [`Substructures`].
    Substructured,
    /// The cell alone; known to be poor, kept as the reference.
    SingleCell,
}

/// Why there are no training data.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrainingError {
    /// A local problem was not solved.
    #[error("the harmonic displacements around coarse cell ({}, {}, {}) were not found: {source}", at[0], at[1], at[2])]
    Local {
        /// Position of the coarse cell.
        at: [usize; 3],
        /// Why.
        source: SolverError,
    },
    /// The problem on the whole object was not solved.
    #[error("the global harmonic displacements were not found: {0}")]
    Global(#[source] SolverError),
    /// The caller's progress callback asked to stop.
    #[error("interrupted while training")]
    Interrupted,
}

/// Training data of the listed elements of `mesh` (ascending), and how the global problem was solved if there was one.
///
/// # Errors
/// When a problem is not solved, or the callback interrupts.
pub fn train(
    model: &FineModel,
    mesh: &CoarseMesh,
    elements: &[CellPart],
    kind: TrainingKind,
    progress: Progress<'_>,
) -> Result<(Training, Option<SolveReport>), TrainingError> {
    match kind {
        TrainingKind::Global => {
            let harmonic = HarmonicDisplacements::solve(model, SolverChoice::Auto, progress)?;
            let training = Training::from_harmonic(model, mesh, elements, &harmonic);
            Ok((training, Some(harmonic.report)))
        }
        TrainingKind::OneRing => {
            Ok((LocalTrainer::new(mesh.partition(), RingKind::OneRing).train(model, mesh, elements, progress)?, None))
        }
        TrainingKind::Substructured => {
            let harmonic = HarmonicDisplacements::solve(model, SolverChoice::Auto, progress)?;
            let forces = Arc::new(InterfaceForces::new(model, mesh.partition(), &harmonic));
            let substructures = Substructures::new(model, forces, InterfaceSpace::default());
            Ok((substructures.train(model, mesh, elements, progress)?, Some(harmonic.report)))
        }
        TrainingKind::SingleCell => Ok((
            LocalTrainer::new(mesh.partition(), RingKind::SingleCell).train(model, mesh, elements, progress)?,
            None,
        )),
    }
}
