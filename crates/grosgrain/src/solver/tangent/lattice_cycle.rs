//! Conjugate gradients with a multigrid cycle on the assembled matrix of a lattice.

use super::super::SolverError;
use super::super::multigrid::{LatticeMatrix, StencilCycle};
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
    unknowns: usize,
    free: Vec<u8>,
    matrix: LatticeMatrix,
    cycle: StencilCycle,
    wear: Wear,
    loads: Vec<f64>,
    solution: Vec<f64>,
    workspace: ConjugateGradientWorkspace,
}

impl LatticeCycle {
    /// For the cells `solid` of a lattice.
    pub fn new(lattice: Lattice, solid: Vec<u32>, spacing: [f64; 3], unknowns: usize) -> Result<Self, SolverError> {
        let matrix = LatticeMatrix::new(lattice);
        Ok(Self {
            unknowns,
            free: vec![0; lattice.node_count()],
            cycle: StencilCycle::new(lattice, solid, spacing)?,
            wear: Wear::complete(),
            loads: matrix.zeros(),
            solution: matrix.zeros(),
            workspace: ConjugateGradientWorkspace::default(),
            matrix,
        })
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
            self.wear = Wear::complete();
            self.cycle.update(cells, &self.free)?;
            self.wear = Wear::none();
        }
        Ok(())
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
        let parameters = ConjugateGradientParameters { tolerance, max_iterations: MAX_ITERATIONS };
        let mut solver = ConjugateGradients::new(&*matrix, parameters).with_workspace(std::mem::take(workspace));
        let outcome = solver.solve(loads, solution, cycle, &|_, _| true);
        *workspace = solver.into_workspace();
        outcome.map_err(|error| indefinite(error, self.unknowns))
    }
}
