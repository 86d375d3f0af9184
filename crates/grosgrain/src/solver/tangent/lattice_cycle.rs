//! Conjugate gradients with a multigrid cycle on the assembled matrix of a lattice.

use super::super::multigrid::LatticeMatrix;
use super::super::{Multigrid, MultigridError, MultigridParameters, SolverError};
use super::{LinearReport, indefinite};
use crate::assembly::{CellStiffness, Constraints, free_components};
use crate::linalg::{
    ConjugateGradientInfo, ConjugateGradientParameters, ConjugateGradientWorkspace, ConjugateGradients,
};
use crate::mesh::Lattice;

const MAX_ITERATIONS: usize = 1000;

/// A cycle is renewed at the next update after a solve that needs more than this times the iterations of the first solve with it, per
/// digit, and [`EXTRA`] more.
const GROWTH: f64 = 1.5;
const EXTRA: f64 = 5.0;

/// Matrix, cycle and vectors.
#[derive(Debug)]
pub(super) struct LatticeCycle {
    parameters: MultigridParameters,
    unknowns: usize,
    free: Vec<u8>,
    matrix: LatticeMatrix,
    cycle: Option<Multigrid<'static>>,
    /// Iterations per digit of the first solve with this cycle.
    pace: Option<f64>,
    is_worn: bool,
    loads: Vec<f64>,
    solution: Vec<f64>,
    workspace: ConjugateGradientWorkspace,
}

impl LatticeCycle {
    pub fn new(lattice: Lattice, spacing: [f64; 3], unknowns: usize) -> Self {
        let matrix = LatticeMatrix::new(lattice);
        Self {
            parameters: MultigridParameters { spacing, ..MultigridParameters::default() },
            unknowns,
            free: Vec::new(),
            cycle: None,
            pace: None,
            is_worn: false,
            loads: matrix.zeros(),
            solution: matrix.zeros(),
            workspace: ConjugateGradientWorkspace::default(),
            matrix,
        }
    }

    pub fn update(
        &mut self,
        cells: &dyn CellStiffness,
        constraints: &Constraints,
        lagged: bool,
    ) -> Result<(), SolverError> {
        let free = free_components(cells, constraints);
        let changed = free != self.free;
        self.free = free;
        self.matrix.fill(cells, &self.free);
        if changed || !lagged || self.is_worn || self.cycle.is_none() {
            // The old one goes first, so that there is never memory for two.
            self.cycle = None;
            self.cycle = Some(Multigrid::stored(cells, &self.free, self.parameters).map_err(|e| self.refused(e))?);
            (self.pace, self.is_worn) = (None, false);
        }
        Ok(())
    }

    /// A coarsest matrix without a factor shows that the finest is not positive definite.
    fn refused(&self, error: MultigridError) -> SolverError {
        match &error {
            MultigridError::Coarsest { source, .. } => {
                SolverError::Indefinite { unknowns: self.unknowns, evidence: format!("coarsest lattice: {source}") }
            }
            _ => error.into(),
        }
    }

    pub fn solve(&mut self, vector: &mut [f64], tolerance: f64) -> Result<LinearReport, SolverError> {
        self.matrix.gather(vector, &self.free, &mut self.loads);
        self.solution.fill(0.0);
        let outcome = self.iterate(tolerance);
        self.matrix.scatter(&self.solution, vector);
        let ConjugateGradientInfo { iterations, relative_residual } = outcome?;
        self.judge(iterations, relative_residual);
        Ok(LinearReport { iterations, relative_residual, refactored: false })
    }

    fn iterate(&mut self, tolerance: f64) -> Result<ConjugateGradientInfo, SolverError> {
        let Self { matrix, cycle, loads, solution, workspace, .. } = self;
        let Some(cycle) = cycle else {
            let evidence = "its preconditioner could not be made".to_owned();
            return Err(SolverError::Indefinite { unknowns: self.unknowns, evidence });
        };
        let parameters = ConjugateGradientParameters { tolerance, max_iterations: MAX_ITERATIONS };
        let mut solver = ConjugateGradients::new(&*matrix, parameters).with_workspace(std::mem::take(workspace));
        let outcome = solver.solve(loads, solution, cycle, &|_, _| true);
        *workspace = solver.into_workspace();
        outcome.map_err(|error| indefinite(error, self.unknowns))
    }

    /// Whether the cycle has become too old.
    fn judge(&mut self, iterations: usize, residual: f64) {
        let digits = -residual.max(f64::MIN_POSITIVE).log10();
        if iterations == 0 || digits <= 0.0 {
            return;
        }
        let pace = *self.pace.get_or_insert(iterations as f64 / digits);
        self.is_worn |= iterations as f64 > GROWTH * pace * digits + EXTRA;
    }
}
