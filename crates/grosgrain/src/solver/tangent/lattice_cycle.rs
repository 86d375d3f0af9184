//! Conjugate gradients with a multigrid cycle on the assembled matrix of a lattice.

use super::super::multigrid::LatticeMatrix;
use super::super::{Multigrid, MultigridError, MultigridParameters, SolverError};
use super::wear::Wear;
use super::{LinearReport, indefinite};
use crate::assembly::{CellStiffness, Constraints, free_components};
use crate::linalg::{
    ConjugateGradientInfo, ConjugateGradientParameters, ConjugateGradientWorkspace, ConjugateGradients,
};
use crate::mesh::Lattice;

const MAX_ITERATIONS: usize = 1000;

/// Matrix, cycle and vectors.
#[derive(Debug)]
pub(super) struct LatticeCycle {
    parameters: MultigridParameters,
    unknowns: usize,
    free: Vec<u8>,
    matrix: LatticeMatrix,
    cycle: Option<Multigrid<'static>>,
    wear: Wear,
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
            wear: Wear::complete(),
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
        if changed || !lagged || self.wear.is_worn() {
            // The old one goes first, so that there is never memory for two.
            (self.cycle, self.wear) = (None, Wear::complete());
            self.cycle = Some(Multigrid::stored(cells, &self.free, self.parameters).map_err(|e| self.refused(e))?);
            self.wear = Wear::none();
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
        self.wear.book(iterations, relative_residual);
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
}
