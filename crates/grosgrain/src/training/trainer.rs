//! Training again and again while the body changes.

use std::sync::Arc;

use super::{
    HarmonicDisplacements, HarmonicSolver, InterfaceForces, InterfaceSpace, LocalTrainer, RingKind, Substructures,
    Training, TrainingError, TrainingKind,
};
use crate::fine::FineModel;
use crate::mesh::{Cell, Lattice};
use crate::partition::{CellPart, CoarseCell, CoarseMesh, Partition};
use crate::progress::Progress;
use crate::solver::SolverChoice;

/// Trains the coarse cells of one partition again and again; what does not depend on the body's material is kept.
pub struct Trainer {
    partition: Partition,
    engine: Engine,
}

enum Engine {
    Global(Box<HarmonicSolver>),
    Local(RingKind, Box<LocalTrainer>),
    Substructured {
        substructures: Box<Substructures>,
        /// Cells whose caches may be those of a body that was given up.
        unsettled: Vec<CoarseCell>,
        tolerance: f64,
    },
}

impl Trainer {
    /// A trainer for bodies on the fine lattice of `partition`; substructured training takes its interface forces from `initial`.
    ///
    /// # Errors
    /// When a factor does not fit into memory; for substructured training when the global problem is not solved, or the callback interrupts.
    pub fn new(
        initial: &FineModel,
        partition: &Partition,
        kind: TrainingKind,
        progress: Progress<'_>,
    ) -> Result<Self, TrainingError> {
        let local = |kind| Engine::Local(kind, Box::new(LocalTrainer::new(partition, kind)));
        let engine = match kind {
            TrainingKind::Global => Engine::Global(Box::new(HarmonicSolver::new(partition.fine())?)),
            TrainingKind::OneRing => local(RingKind::OneRing),
            TrainingKind::SingleCell => local(RingKind::SingleCell),
            TrainingKind::Substructured => {
                let harmonic = HarmonicDisplacements::solve(initial, SolverChoice::Auto, progress)?;
                let forces = Arc::new(InterfaceForces::new(initial, partition, &harmonic));
                let substructures = Box::new(Substructures::new(initial, forces, InterfaceSpace::default()));
                Engine::Substructured { substructures, unsettled: Vec::new(), tolerance: f64::INFINITY }
            }
        };
        Ok(Self { partition: *partition, engine })
    }

    /// Trains rings exactly whose bound of the relative error in energy is larger than this; of use for substructured training only.
    pub fn limit_error(&mut self, limit: f64) {
        if let Engine::Substructured { tolerance, .. } = &mut self.engine {
            *tolerance = limit;
        }
    }

    /// The coarse cells whose data depend on what is in the `changed` ones, ascending: themselves for single-cell training, their
    /// neighbours too for one-ring training, all for global training (`he2022fast`, §3.2).
    pub fn reach(&self, changed: &[CoarseCell]) -> Vec<CoarseCell> {
        let coarse = self.partition.coarse();
        match &self.engine {
            _ if changed.is_empty() => Vec::new(),
            Engine::Global(_) => (0..coarse.cell_count()).map(CoarseCell).collect(),
            Engine::Local(RingKind::OneRing, _) | Engine::Substructured { .. } => neighbourhood(coarse, changed),
            Engine::Local(RingKind::SingleCell, _) => ascending(changed.to_vec()),
        }
    }

    /// Training data of the listed elements of `mesh` (ascending) for the body as it is now; it has changed in the `changed` cells and nowhere
    /// else since the data of the last call were [settled](Self::settle).
    ///
    /// # Errors
    /// When a problem is not solved, or the callback interrupts.
    pub fn train(
        &mut self,
        model: &FineModel,
        mesh: &CoarseMesh,
        (changed, elements): (&[CoarseCell], &[CellPart]),
        progress: Progress<'_>,
    ) -> Result<Training, TrainingError> {
        match &mut self.engine {
            Engine::Global(solver) => {
                let harmonic = solver.solve(model, progress)?;
                Ok(Training::from_harmonic(model, mesh, elements, &harmonic))
            }
            Engine::Local(_, trainer) => trainer.train(model, mesh, elements, progress),
            Engine::Substructured { substructures, unsettled, tolerance } => {
                unsettled.extend(changed);
                *unsettled = ascending(std::mem::take(unsettled));
                substructures.renew(model, unsettled);
                substructures.train_within(model, mesh, elements, *tolerance, progress)
            }
        }
    }

    /// Tells that the body of the last training stays. Without this the next training starts from the one before.
    pub fn settle(&mut self) {
        if let Engine::Substructured { unsettled, .. } = &mut self.engine {
            unsettled.clear();
        }
    }
}

/// The cells and their 26 neighbours, ascending.
fn neighbourhood(coarse: Lattice, cells: &[CoarseCell]) -> Vec<CoarseCell> {
    let mut marked = vec![false; coarse.cell_count()];
    for cell in cells {
        let at = coarse.cell_position(Cell(cell.0));
        let low = at.map(|x| x.saturating_sub(1));
        let high: [usize; 3] = std::array::from_fn(|a| (at[a] + 2).min(coarse.cells[a]));
        for (k, j) in (low[2]..high[2]).flat_map(|k| (low[1]..high[1]).map(move |j| (k, j))) {
            let first = coarse.cell([low[0], j, k]).0;
            marked[first..first + high[0] - low[0]].fill(true);
        }
    }
    (0..marked.len()).filter(|c| marked[*c]).map(CoarseCell).collect()
}

fn ascending(mut cells: Vec<CoarseCell>) -> Vec<CoarseCell> {
    cells.sort_unstable();
    cells.dedup();
    cells
}
