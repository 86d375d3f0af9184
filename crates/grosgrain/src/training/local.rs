//! Harmonic displacements on the one-ring of a coarse cell, or on the cell alone.

use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use super::cell_data::{CellCutter, known_nodes};
use super::{Training, TrainingError};
use crate::assembly::{CellStiffness, LatticePattern, Window, active_nodes};
use crate::fine::{FineModel, HARMONIC_FIELDS, constant_stress_loads};
use crate::mesh::{Cell, Lattice, Node, hull};
use crate::partition::{CellBox, CellPart, CoarseCell, CoarseMesh, Partition, PerElement};
use crate::progress::Progress;
use crate::solver::{AnalysedLattice, DirectSolver, SolverError, TOLERANCE, free_support};

/// The domain of a local problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RingKind {
    /// The cell and its 26 neighbours, clipped at the lattice.
    OneRing,
    /// The cell alone.
    SingleCell,
}

/// Solves the local problems of coarse cells.
///
/// Boxes of one shape share one symbolic analysis; factors and workspaces are kept and used again. Cells are
/// independent: each is solved on one thread, so results do not depend on the number of threads.
pub struct LocalTrainer {
    partition: Partition,
    kind: RingKind,
    analysed: Mutex<HashMap<[usize; 3], Arc<AnalysedLattice>>>,
    idle: Mutex<HashMap<[usize; 3], Vec<Workspace>>>,
}

struct Workspace {
    solver: DirectSolver,
    fields: Vec<f64>,
}

impl LocalTrainer {
    /// A trainer for the coarse cells of `partition`.
    pub fn new(partition: &Partition, kind: RingKind) -> Self {
        Self { partition: *partition, kind, analysed: Mutex::default(), idle: Mutex::default() }
    }

    /// Training data of the listed elements of `mesh` (ascending), in parallel over coarse cells.
    ///
    /// # Errors
    /// When a local problem is not solved, or the callback interrupts.
    pub fn train(
        &self,
        model: &FineModel,
        mesh: &CoarseMesh,
        elements: &[CellPart],
        progress: Progress<'_>,
    ) -> Result<Training, TrainingError> {
        // Cells after the first failure are skipped, so that the same one is reported whatever the threads do.
        let (done, failed) = (AtomicUsize::new(0), AtomicUsize::new(usize::MAX));
        let cells: Vec<&[CellPart]> = elements.chunk_by(|a, b| a.cell == b.cell).collect();
        let matrices: Vec<Result<Vec<Box<[f64]>>, TrainingError>> = cells
            .par_iter()
            .enumerate()
            .map(|(index, parts)| {
                if failed.load(Ordering::Relaxed) < index {
                    return Err(TrainingError::Interrupted);
                }
                let matrices = self.train_cell(model, mesh, parts).map_err(|source| {
                    failed.fetch_min(index, Ordering::Relaxed);
                    self.failure(parts[0].cell, source)
                })?;
                let count = done.fetch_add(1, Ordering::Relaxed) + 1;
                if !progress("training", count, cells.len()) {
                    failed.store(0, Ordering::Relaxed);
                    return Err(TrainingError::Interrupted);
                }
                Ok(matrices)
            })
            .collect();
        let matrices: Result<Vec<Vec<Box<[f64]>>>, TrainingError> = matrices.into_iter().collect();
        let matrices = PerElement::new(elements.to_vec(), matrices?.into_iter().flatten().collect());
        Ok(Training::from_parts(3 * self.partition.nodes_per_cell(), matrices))
    }

    /// Training matrices of some parts of one coarse cell, `3 (d + 1)³ × 6` row-major each, on the calling thread; no part, no matrix.
    ///
    /// # Errors
    /// When the local problem is not solved.
    pub fn train_cell(
        &self,
        model: &FineModel,
        mesh: &CoarseMesh,
        parts: &[CellPart],
    ) -> Result<Vec<Box<[f64]>>, SolverError> {
        let Some(cell) = parts.first().map(|part| part.cell) else { return Ok(Vec::new()) };
        let domain = self.domain(cell);
        let mut workspace = self.take(domain.cells)?;
        let solved = solve(model, domain, &mut workspace);
        let matrices = solved.map(|active| {
            let nodes = self.nodes_in(domain, cell);
            let cutter = CellCutter::new(&self.partition, model.grid().spacing);
            let cut = |part: &CellPart| {
                let known = known_nodes(mesh, *part, (&nodes, &active), self.kind == RingKind::SingleCell);
                cutter.cut(&nodes, &known, &workspace.fields)
            };
            parts.iter().map(cut).collect()
        });
        lock(&self.idle).entry(domain.cells).or_default().push(workspace);
        matrices
    }

    fn domain(&self, cell: CoarseCell) -> CellBox {
        match self.kind {
            RingKind::OneRing => self.partition.one_ring(cell),
            RingKind::SingleCell => self.partition.cell_box(cell),
        }
    }

    /// The coarse cell's fine nodes as nodes of the domain's own lattice.
    fn nodes_in(&self, domain: CellBox, cell: CoarseCell) -> Vec<Node> {
        let own = self.partition.cell_box(cell).start;
        let (local, ring) = (self.partition.cell_lattice(), Lattice::new(domain.cells));
        (0..local.node_count())
            .map(|n| {
                let at = local.node_position(Node(n));
                ring.node(std::array::from_fn(|a| own[a] - domain.start[a] + at[a]))
            })
            .collect()
    }

    fn take(&self, shape: [usize; 3]) -> Result<Workspace, SolverError> {
        if let Some(workspace) = lock(&self.idle).get_mut(&shape).and_then(Vec::pop) {
            return Ok(workspace);
        }
        let solver = DirectSolver::new(self.analysed(shape)?, HARMONIC_FIELDS)?;
        let fields = vec![0.0; 3 * HARMONIC_FIELDS * Lattice::new(shape).node_count()];
        Ok(Workspace { solver, fields })
    }

    fn analysed(&self, shape: [usize; 3]) -> Result<Arc<AnalysedLattice>, SolverError> {
        let mut known = lock(&self.analysed);
        if let Some(analysed) = known.get(&shape) {
            return Ok(analysed.clone());
        }
        let analysed = Arc::new(AnalysedLattice::new(LatticePattern::full(Lattice::new(shape)))?);
        known.insert(shape, analysed.clone());
        Ok(analysed)
    }

    fn failure(&self, cell: CoarseCell, source: SolverError) -> TrainingError {
        TrainingError::Local { at: self.partition.coarse().cell_position(Cell(cell.0)), source }
    }
}

/// Solves for the six harmonic displacements of the domain; returns which of its nodes touch a solid cell.
fn solve(model: &FineModel, domain: CellBox, workspace: &mut Workspace) -> Result<Vec<bool>, SolverError> {
    let window = Window::new(model, domain.start, domain.cells);
    let lattice = window.lattice();
    let void: Vec<bool> = (0..lattice.cell_count()).map(|c| window.stiffness(c).is_none()).collect();
    let active = active_nodes(&window);
    let spacing = model.grid().spacing;
    constant_stress_loads(lattice, spacing, &hull(&void, &lattice), &mut workspace.fields);
    workspace.solver.factor(&window, &free_support(lattice, spacing, &void, &active))?;
    let residual = workspace.solver.solve_in_place(&mut workspace.fields);
    if residual.is_nan() || residual > TOLERANCE {
        let order = workspace.solver.analysed().pattern().order();
        return Err(SolverError::Inaccurate { residual, tolerance: TOLERANCE, order });
    }
    Ok(active)
}

/// A thread that panicked leaves the pools as they were: both hold finished values only.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
