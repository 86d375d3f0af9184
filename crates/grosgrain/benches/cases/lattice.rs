//! The stiffness of a whole body: analysis, assembly, factorisation, solve; and iteration instead.

use std::sync::Arc;

use grosgrain::assembly::{Constraints, LatticePattern};
use grosgrain::fine::{FineModel, gravity};
use grosgrain::linalg::{Cholesky, CholeskyError};
use grosgrain::mesh::{Lattice, Node};
use grosgrain::progress::silent;
use grosgrain::solver::{AnalysedLattice, Hold, LatticeSystem, SolveReport, SolverChoice, SolverError};

use super::{Outcome, RATIO, SPACING, layered};

/// A layered cube held at x = 0.
pub struct LatticeCase {
    model: FineModel,
    analysed: Arc<AnalysedLattice>,
    constraints: Constraints,
    values: Vec<f64>,
    cholesky: Cholesky,
    load: Vec<f64>,
    column: Vec<f64>,
}

impl LatticeCase {
    pub fn new(cells: usize) -> Outcome<Self> {
        let model = layered([cells; 3], RATIO)?;
        let analysed = Arc::new(analyse(cells)?);
        let mut load = vec![0.0; analysed.pattern().order()];
        analysed.pattern().gather_into(&gravity(&model, [0.0, 0.0, -9.81]), &mut load);
        let mut case = Self {
            values: vec![0.0; analysed.pattern().pattern().entry_count()],
            cholesky: Cholesky::new(analysed.symbolic().clone(), 1)?,
            constraints: held_at_end(model.grid().lattice),
            column: load.clone(),
            load,
            analysed,
            model,
        };
        case.assemble();
        Ok(case)
    }

    pub fn assemble(&mut self) {
        self.analysed.pattern().assemble_into(&self.model, &self.constraints, &mut self.values);
    }

    pub fn factor(&mut self) -> Result<(), CholeskyError> {
        self.cholesky.factor(&self.values)
    }

    pub fn solve(&mut self) {
        self.column.copy_from_slice(&self.load);
        self.cholesky.solve_in_place(&mut self.column);
    }

    pub fn unknowns(&self) -> usize {
        self.analysed.pattern().order()
    }

    /// Stored entries of the lower triangle.
    pub fn entries(&self) -> usize {
        self.values.len()
    }

    pub fn factor_entries(&self) -> usize {
        self.analysed.symbolic().factor_entries()
    }

    pub fn factor_flops(&self) -> f64 {
        self.analysed.symbolic().factor_flops()
    }
}

/// Pattern, ordering and symbolic factorisation of a cube.
pub fn analyse(cells: usize) -> Result<AnalysedLattice, SolverError> {
    AnalysedLattice::new(LatticePattern::full(Lattice::new([cells; 3])))
}

/// A layered cube held at x = 0 under gravity, solved by preconditioned conjugate gradients.
pub struct IterativeCase {
    model: FineModel,
    constraints: Constraints,
    load: Vec<f64>,
    block: Vec<f64>,
}

impl IterativeCase {
    pub fn new(cells: usize, ratio: f64) -> Outcome<Self> {
        let model = layered([cells; 3], ratio)?;
        let constraints = held_at_end(model.grid().lattice);
        let load = gravity(&model, [0.0, 0.0, -9.81]);
        Ok(Self { block: load.clone(), load, constraints, model })
    }

    /// Set-up and solve from zero.
    pub fn solve(&mut self) -> Result<SolveReport, SolverError> {
        self.block.copy_from_slice(&self.load);
        let hold = Hold::Fixed(&self.constraints);
        let system = LatticeSystem { cells: &self.model, spacing: SPACING, hold };
        system.solve(SolverChoice::Iterative, &mut self.block, &silent)
    }
}

fn held_at_end(lattice: Lattice) -> Constraints {
    let at_end: Vec<bool> = (0..lattice.node_count()).map(|n| lattice.node_position(Node(n))[0] == 0).collect();
    Constraints::nodes(&at_end)
}
