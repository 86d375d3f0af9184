//! Harmonic displacements on the one-ring of a coarse cell, or on the cell alone.

use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use super::cell_data::{CellCutter, known_nodes};
use super::condensed::{CondensedPlan, CondensedShape, CondensedSolver, CoreDisplacements};
use super::{Training, TrainingError};
use crate::assembly::{CellStiffness, LatticePattern, Window, active_nodes};
use crate::fine::{FineModel, HARMONIC_FIELDS, constant_stress_loads};
use crate::mesh::{Cell, Lattice, Node, hull};
use crate::partition::{CellBox, CellPart, CoarseCell, CoarseMesh, Partition, PerElement};
use crate::progress::Progress;
use crate::solver::{AnalysedLattice, DirectSolver, SolverError, TOLERANCE, free_support};

/// Training matrices of the parts of one coarse cell.
type PartMatrices = Vec<Box<[f64]>>;

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
/// A box is eliminated from outside in, so that only the cell's own unknowns are substituted backwards. Where parts of it hang
/// together by edges or nodes, the whole box is factored with a small shift and its solution refined.
/// Boxes of one shape share one symbolic analysis; factors and workspaces are kept and used again. Cells are
/// independent: each is solved on one thread, so results do not depend on the number of threads.
pub struct LocalTrainer {
    partition: Partition,
    kind: RingKind,
    analysed: Mutex<HashMap<[usize; 3], Arc<AnalysedLattice>>>,
    idle: Mutex<HashMap<[usize; 3], Vec<Workspace>>>,
    condensed: Mutex<HashMap<CondensedShape, CondensedPool>>,
}

#[derive(Default)]
struct CondensedPool {
    plan: Option<Arc<CondensedPlan>>,
    idle: Vec<CondensedSolver>,
}

struct Workspace {
    solver: DirectSolver,
    fields: Vec<f64>,
}

impl LocalTrainer {
    /// A trainer for the coarse cells of `partition`.
    pub fn new(partition: &Partition, kind: RingKind) -> Self {
        Self {
            partition: *partition,
            kind,
            analysed: Mutex::default(),
            idle: Mutex::default(),
            condensed: Mutex::default(),
        }
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
        self.train_by(elements, progress, &|parts| self.train_cell(model, mesh, parts))
    }

    /// Training data of the listed elements from `matrices` of the parts of a coarse cell, in parallel over coarse cells.
    pub(super) fn train_by(
        &self,
        elements: &[CellPart],
        progress: Progress<'_>,
        matrices: &(dyn Fn(&[CellPart]) -> Result<PartMatrices, SolverError> + Sync),
    ) -> Result<Training, TrainingError> {
        // Cells after the first failure are skipped, so that the same one is reported whatever the threads do.
        let (done, failed) = (AtomicUsize::new(0), AtomicUsize::new(usize::MAX));
        let cells: Vec<&[CellPart]> = elements.chunk_by(|a, b| a.cell == b.cell).collect();
        let outcomes: Vec<Result<Vec<Box<[f64]>>, TrainingError>> = cells
            .par_iter()
            .enumerate()
            .map(|(index, parts)| {
                if failed.load(Ordering::Relaxed) < index {
                    return Err(TrainingError::Interrupted);
                }
                let matrices = matrices(parts).map_err(|source| {
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
        let matrices: Result<Vec<Vec<Box<[f64]>>>, TrainingError> = outcomes.into_iter().collect();
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
        if let Some(matrices) = self.train_condensed(model, mesh, parts, (cell, domain)) {
            return Ok(matrices);
        }
        let mut workspace = self.take(domain.cells)?;
        let solved = solve(model, domain, &mut workspace);
        let matrices = solved.map(|active| {
            let nodes = self.nodes_in(domain, cell);
            self.cut(mesh, parts, (&nodes, &active, &workspace.fields), model.grid().spacing)
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

    /// By elimination from outside in; `None` where that cannot tell motions without stiffness from soft ones.
    fn train_condensed(
        &self,
        model: &FineModel,
        mesh: &CoarseMesh,
        parts: &[CellPart],
        (cell, domain): (CoarseCell, CellBox),
    ) -> Option<Vec<Box<[f64]>>> {
        let own = self.partition.cell_box(cell).start;
        let core = std::array::from_fn(|a| own[a] - domain.start[a]);
        let shape = CondensedShape { cells: domain.cells, core, degree: self.partition.degree() };
        let mut solver = self.condensed(shape)?;
        let spacing = model.grid().spacing;
        let found = solver.solve(&Window::new(model, domain.start, domain.cells), spacing);
        lock(&self.condensed).entry(shape).or_default().idle.push(solver);
        let CoreDisplacements { active, fields } = found?;
        let nodes: Vec<Node> = (0..active.len()).map(Node).collect();
        Some(self.cut(mesh, parts, (&nodes, &active, &fields), spacing))
    }

    fn condensed(&self, shape: CondensedShape) -> Option<CondensedSolver> {
        let mut pools = lock(&self.condensed);
        let pool = pools.entry(shape).or_default();
        if let Some(solver) = pool.idle.pop() {
            return Some(solver);
        }
        if pool.plan.is_none() {
            pool.plan = Some(Arc::new(CondensedPlan::new(shape).ok()?));
        }
        pool.plan.clone().map(CondensedSolver::new)
    }

    /// One matrix for each of the parts, cut out of displacements on a lattice with these active nodes, of which `nodes` are the cell's.
    pub(super) fn cut(
        &self,
        mesh: &CoarseMesh,
        parts: &[CellPart],
        (nodes, active, fields): (&[Node], &[bool], &[f64]),
        spacing: [f64; 3],
    ) -> Vec<Box<[f64]>> {
        let cutter = CellCutter::new(&self.partition, spacing);
        let cut = |part: &CellPart| {
            let known = known_nodes(mesh, *part, (nodes, active), self.kind == RingKind::SingleCell);
            cutter.cut(nodes, &known, fields)
        };
        parts.iter().map(cut).collect()
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
pub(super) fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{Elasticity, IsotropicMaterial, Material, MaterialTable};
    use crate::mesh::{Components, Label, Neighbourhood, VoxelGrid};
    use proptest::prelude::*;

    fn body(cells: [usize; 3], labels: &[u8], ratio: f64) -> FineModel {
        let mut grid = VoxelGrid::uniform(cells, [1.0, 0.5, 1.5], Label(0));
        for (c, label) in labels.iter().enumerate() {
            grid.labels[c] = Label(i32::from(*label > 3));
            grid.void[c] = *label == 0;
        }
        let mut table = MaterialTable::new();
        for (label, young) in [(0, 1e5), (1, 1e5 * ratio)] {
            let elasticity = Elasticity::Isotropic(IsotropicMaterial::new(young, 0.45).unwrap());
            table.insert(Label(label), Material::linear("", elasticity, 1.0));
        }
        FineModel::new(grid, &table).unwrap()
    }

    /// Both ways for every cell whose domain is in one part (else parts may turn against each other, and there is no one answer);
    /// returns how many went outside in.
    fn compare(model: &FineModel, degree: usize, kind: RingKind, tolerance: f64) -> usize {
        let partition = Partition::new(model.lattice(), degree).unwrap();
        let mesh = CoarseMesh::new(&model.grid().void, &partition);
        let trainer = LocalTrainer::new(&partition, kind);
        let mut condensed = 0;
        for cell in (0..partition.coarse().cell_count()).map(CoarseCell) {
            if partition.fine_cells(cell).all(|c| model.is_void(c)) {
                continue;
            }
            let domain = trainer.domain(cell);
            let window = Window::new(model, domain.start, domain.cells);
            let void: Vec<bool> = (0..window.lattice().cell_count()).map(|c| window.stiffness(c).is_none()).collect();
            if Components::new(&void, &window.lattice(), Neighbourhood::Faces).count() != 1 {
                continue;
            }
            let parts = &mesh.elements()[mesh.elements_of(cell)];
            let Some(found) = trainer.train_condensed(model, &mesh, parts, (cell, domain)) else { continue };
            condensed += 1;
            let mut workspace = trainer.take(domain.cells).unwrap();
            let active = solve(model, domain, &mut workspace).unwrap();
            let fields = (&trainer.nodes_in(domain, cell)[..], &active[..], &workspace.fields[..]);
            let expected = trainer.cut(&mesh, parts, fields, model.grid().spacing);
            for (found, expected) in found.iter().zip(&expected) {
                let size = expected.iter().fold(0.0f64, |m, x| m.max(x.abs()));
                let error = found.iter().zip(expected).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
                assert!(error <= tolerance * size, "cell {cell:?}: {error} of {size}");
            }
        }
        condensed
    }

    #[test]
    fn outside_in_equals_the_whole_ring() {
        for (degree, ratio) in [(1, 50.0), (2, 1e4), (3, 50.0)] {
            let cells = [4 * degree, 3 * degree, degree];
            let labels: Vec<u8> = (0..cells.iter().product()).map(|n: usize| 1 + (n * n / 3 % 6) as u8).collect();
            let model = body(cells, &labels, ratio);
            assert_eq!(compare(&model, degree, RingKind::OneRing, 1e-8), 12);
            assert_eq!(compare(&model, degree, RingKind::SingleCell, 1e-8), 12);
        }
    }

    /// Both ways have a residual near rounding; a ratio of 10⁶ between neighbours multiplies it.
    #[test]
    fn outside_in_equals_the_whole_ring_at_a_million_to_one() {
        let labels: Vec<u8> = (0..192).map(|n: usize| 1 + (n * n / 3 % 6) as u8).collect();
        assert_eq!(compare(&body([8, 6, 4], &labels, 1e6), 2, RingKind::OneRing, 1e-7), 24);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]
        #[test]
        fn outside_in_equals_the_whole_ring_with_voids(labels in proptest::collection::vec(0u8..7, 6 * 6 * 4)) {
            prop_assume!(labels.iter().any(|l| *l > 0));
            let model = body([6, 6, 4], &labels, 50.0);
            let void = &model.grid().void;
            prop_assume!(void.iter().any(|v| *v));
            compare(&model, 2, RingKind::OneRing, 1e-6);
        }
    }

    #[test]
    fn a_ring_that_is_cut_in_two_is_solved_part_by_part() {
        // A void plane of voxels through the middle of the second coarse cell.
        let cells = [6, 4, 4];
        let labels: Vec<u8> = (0..96).map(|n| if n % 6 == 2 { 0 } else { 1 + (n % 5) as u8 }).collect();
        let cut = body(cells, &labels, 50.0);
        let alone: Vec<u8> = (0..96).map(|n| if n % 6 <= 2 { 0 } else { labels[n] }).collect();
        let partition = Partition::new(cut.lattice(), 2).unwrap();
        let last = CellPart::whole(CoarseCell(2));
        let trainer = LocalTrainer::new(&partition, RingKind::OneRing);
        let train = |model: &FineModel| {
            let mesh = CoarseMesh::new(&model.grid().void, &partition);
            let place = (last.cell, trainer.domain(last.cell));
            trainer.train_condensed(model, &mesh, &[last], place).unwrap().remove(0)
        };
        let (both, one) = (train(&cut), train(&body(cells, &alone, 50.0)));
        let size = one.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        assert!(both.iter().zip(one.iter()).all(|(a, b)| (a - b).abs() < 1e-9 * size));
    }
}
