//! Harmonic displacements of one coarse cell fully surrounded, as a whole and in parts, and of many cells on threads.

use std::sync::Arc;

use grosgrain::assembly::{CellStiffness, Constraints, LatticePattern, Window, active_nodes};
use grosgrain::fine::{FineModel, HARMONIC_FIELDS, constant_stress_loads};
use grosgrain::linalg::{Cholesky, CholeskyError, FrontalPlan, box_tree, box_tree_around};
use grosgrain::mesh::{Cell, Lattice};
use grosgrain::partition::{CellBox, CellPart, CoarseMesh, Partition};
use grosgrain::progress::silent;
use grosgrain::solver::{AnalysedLattice, SolverError, Support, free_support};
use grosgrain::training::{LocalTrainer, RingKind, Training, TrainingError};

use super::{CENTRE, Outcome, RATIO, layered};
use crate::simplicial::Simplicial;

/// Six static problems on the ring of a cell, or on the cell.
pub struct HarmonicCase {
    model: FineModel,
    mesh: CoarseMesh,
    trainer: LocalTrainer,
    domain: CellBox,
    trainer_degree: usize,
    analysed: Arc<AnalysedLattice>,
    constraints: Constraints,
    values: Vec<f64>,
    cholesky: Cholesky,
    loads: Vec<f64>,
    block: Vec<f64>,
}

impl HarmonicCase {
    pub fn new(degree: usize, kind: RingKind) -> Outcome<Self> {
        let model = layered([3 * degree; 3], RATIO)?;
        let partition = Partition::new(model.grid().lattice, degree)?;
        let domain = match kind {
            RingKind::OneRing => partition.one_ring(CENTRE),
            RingKind::SingleCell => partition.cell_box(CENTRE),
        };
        let trainer = LocalTrainer::new(&partition, kind);
        let mesh = CoarseMesh::new(&model.grid().void, &partition);
        trainer.train_cell(&model, &mesh, &[CellPart::whole(CENTRE)])?;
        let analysed = Arc::new(AnalysedLattice::new(LatticePattern::full(Lattice::new(domain.cells)))?);
        let cholesky = Cholesky::new(analysed.symbolic().clone(), HARMONIC_FIELDS)?;
        let constraints = determinate_support(&model, domain)?;
        let loads = loads_in_elimination_order(&model, &analysed);
        let values = vec![0.0; analysed.pattern().pattern().entry_count()];
        let block = loads.clone();
        let mut case = Self {
            model,
            mesh,
            trainer,
            domain,
            trainer_degree: degree,
            analysed,
            constraints,
            values,
            cholesky,
            loads,
            block,
        };
        case.assemble();
        case.factor()?;
        case.solve();
        Ok(case)
    }

    /// Everything: loads, assembly, factorisation, solve, cutting the cell out.
    pub fn train(&self) -> Result<Vec<Box<[f64]>>, SolverError> {
        self.trainer.train_cell(&self.model, &self.mesh, &[CellPart::whole(CENTRE)])
    }

    pub fn assemble(&mut self) {
        let window = Window::new(&self.model, self.domain.start, self.domain.cells);
        self.analysed.pattern().assemble_into(&window, &self.constraints, &mut self.values);
    }

    pub fn factor(&mut self) -> Result<(), CholeskyError> {
        self.cholesky.factor(&self.values)
    }

    pub fn solve(&mut self) {
        self.block.copy_from_slice(&self.loads);
        self.cholesky.solve_in_place(&mut self.block);
    }

    /// The same matrix for a factorisation entry by entry.
    pub fn simplicial(&self) -> Outcome<Simplicial> {
        Simplicial::new(self.analysed.pattern().pattern().clone(), HARMONIC_FIELDS)
    }

    /// Factors the assembled matrix with the baseline and solves for the six fields; false if it is not positive definite.
    pub fn factor_and_solve_with(&mut self, baseline: &mut Simplicial) -> bool {
        self.block.copy_from_slice(&self.loads);
        baseline.factor(&self.values) && {
            baseline.solve_in_place(&mut self.block);
            true
        }
    }

    /// The last solution, six columns in elimination order.
    pub fn solution(&self) -> &[f64] {
        &self.block
    }

    pub fn unknowns(&self) -> usize {
        self.analysed.pattern().order()
    }

    /// Operations of the elimination from outside in that training does, its six loads included.
    pub fn elimination_flops(&self) -> Outcome<f64> {
        let lattice = Lattice::new(self.domain.cells);
        let degree = self.trainer_degree;
        let corners = |c: usize| lattice.corners(Cell(c)).map(|n| n.0 as u32).to_vec();
        let elements: Vec<Vec<u32>> = (0..lattice.cell_count()).map(corners).collect();
        let groups = match self.domain.cells == [degree; 3] {
            true => box_tree(lattice.nodes()),
            false => box_tree_around(lattice.nodes(), [degree; 3], [2 * degree + 1; 3]),
        };
        Ok(FrontalPlan::new(lattice.node_count(), 3, &elements, &groups)?.operations(HARMONIC_FIELDS))
    }

    pub fn factor_flops(&self) -> f64 {
        self.analysed.symbolic().factor_flops()
    }

    /// Multiplications and additions of the forward and backward substitutions of six right-hand sides.
    pub fn solve_flops(&self) -> f64 {
        4.0 * (HARMONIC_FIELDS * self.analysed.symbolic().factor_entries()) as f64
    }
}

fn determinate_support(model: &FineModel, domain: CellBox) -> Outcome<Constraints> {
    let window = Window::new(model, domain.start, domain.cells);
    let lattice = window.lattice();
    let void: Vec<bool> = (0..lattice.cell_count()).map(|c| model.is_void(Cell(c))).collect();
    match free_support(lattice, model.grid().spacing, &void, &active_nodes(&window)) {
        Support::Constraints(constraints) => Ok(constraints),
        Support::Free => Err("the layered body is solid, yet it was not found to be one part".into()),
    }
}

fn loads_in_elimination_order(model: &FineModel, analysed: &AnalysedLattice) -> Vec<f64> {
    let lattice = analysed.pattern().lattice();
    let stride = 3 * lattice.node_count();
    let mut fields = vec![0.0; stride * HARMONIC_FIELDS];
    constant_stress_loads(lattice, model.grid().spacing, &vec![true; lattice.cell_count()], &mut fields);
    let mut loads = vec![0.0; fields.len()];
    for (field, unknowns) in fields.chunks_exact(stride).zip(loads.chunks_exact_mut(stride)) {
        analysed.pattern().gather_into(field, unknowns);
    }
    loads
}

/// One-ring training of 4 × 4 × 4 coarse cells.
pub struct ManyCells {
    model: FineModel,
    trainer: LocalTrainer,
    mesh: CoarseMesh,
    pool: rayon::ThreadPool,
}

impl ManyCells {
    pub fn new(degree: usize, threads: usize) -> Outcome<Self> {
        let model = layered([4 * degree; 3], RATIO)?;
        let partition = Partition::new(model.grid().lattice, degree)?;
        let trainer = LocalTrainer::new(&partition, RingKind::OneRing);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        let mesh = CoarseMesh::new(&model.grid().void, &partition);
        let case = Self { model, trainer, mesh, pool };
        case.train()?;
        Ok(case)
    }

    pub fn train(&self) -> Result<Training, TrainingError> {
        self.pool.install(|| self.trainer.train(&self.model, &self.mesh, self.mesh.elements(), &silent))
    }

    pub fn cell_count(&self) -> usize {
        self.mesh.elements().len()
    }
}
