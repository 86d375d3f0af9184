//! Newton systems of meshes of eight-node elements with any topology.

use super::super::SolverError;
use super::LinearReport;
use super::block_matrix::BlockMatrix;
use super::indefinite;
use super::lagged_factor::LaggedFactor;
use crate::assembly::Constraints;
use crate::element::CellMatrix;
use crate::linalg::{
    ConjugateGradientError, ConjugateGradientInfo, ConjugateGradientParameters, ConjugateGradientWorkspace,
    ConjugateGradients,
};

/// With a factor of the matrix itself one or two iterations are the rule; an old factor is given up long before this.
const MAX_ITERATIONS: usize = 500;

/// The tangent stiffness of elements that meet at vertices, three unknowns per vertex, whose matrices change from one Newton
/// iteration to the next while the elements meet at the same vertices.
///
/// Conjugate gradients on the current matrix, with the last Cholesky factor as a preconditioner. The factor is renewed when a
/// solve costs more iterations than the solves since the last factorisation did on average, the price of the factorisation
/// included (the rule for replacing a machine whose upkeep grows). Prices are counted operations, never seconds, so that
/// runs are repeatable.
///
/// Memory: about 2.4 kB per vertex for the matrix and its pattern, 40 B per vertex and vector, and the factor, 12 B × (3 n)^{4/3}
/// or so for n vertices, from the first factorisation on.
#[derive(Debug)]
pub struct ElementTangent {
    /// Vertices in elimination order.
    order: Vec<u32>,
    matrix: BlockMatrix,
    factor: LaggedFactor,
    is_current: bool,
    loads: Vec<f64>,
    solution: Vec<f64>,
    workspace: ConjugateGradientWorkspace,
}

impl ElementTangent {
    /// A system of elements with these corners, whose vertices are eliminated in the given `order`, each of them once.
    ///
    /// # Errors
    /// When the factor does not fit into indices.
    ///
    /// # Panics
    /// Panics when a corner is not in `order`.
    pub fn new(order: Vec<u32>, corners: &[[u32; 8]]) -> Result<Self, SolverError> {
        let mut rank = vec![u32::MAX; order.len()];
        order.iter().enumerate().for_each(|(r, v)| rank[*v as usize] = r as u32);
        let corners = corners.iter().map(|c| c.map(|v| rank[v as usize])).collect();
        let matrix = BlockMatrix::new(order.len(), corners)?;
        let factor = LaggedFactor::new(&matrix)?;
        let zeros = vec![0.0; 3 * order.len()];
        let workspace = ConjugateGradientWorkspace::default();
        Ok(Self { matrix, factor, is_current: false, loads: zeros.clone(), solution: zeros, workspace, order })
    }

    /// Number of unknowns, three per vertex.
    pub fn unknowns(&self) -> usize {
        3 * self.order.len()
    }

    /// Memory that the factor takes \[B\].
    pub fn factor_bytes(&self) -> usize {
        8 * self.factor.symbolic().factor_entries()
    }

    /// Adds up the tangents \[N/m\] of the elements by their numbers; prescribed components of vertices are left out. With `lagged`
    /// the last factor is kept until a solve finds it too old; without, and where other components are prescribed than before, the
    /// matrix is factored now.
    ///
    /// # Errors
    /// [`SolverError::Indefinite`] when the matrix is factored and has a pivot that is not positive, also with its diagonal raised by a
    /// billionth; a factor that does not fit into memory.
    pub fn update<'k>(
        &mut self,
        stiffness: impl Fn(usize) -> &'k CellMatrix + Sync,
        constraints: &Constraints,
        lagged: bool,
    ) -> Result<(), SolverError> {
        self.update_scaled(|element| (1.0, stiffness(element)), constraints, lagged)
    }

    /// [`Self::update`] with a factor for each matrix.
    pub(super) fn update_scaled<'k>(
        &mut self,
        stiffness: impl Fn(usize) -> (f64, &'k CellMatrix) + Sync,
        constraints: &Constraints,
        lagged: bool,
    ) -> Result<(), SolverError> {
        let changed = self.matrix.hold(constraints, &self.order);
        self.matrix.assemble(&stiffness);
        self.is_current = false;
        if changed || !lagged || !self.factor.exists() {
            self.refactor()?;
        }
        Ok(())
    }

    fn refactor(&mut self) -> Result<(), SolverError> {
        self.is_current = false;
        self.factor.factor(&self.matrix)?;
        self.is_current = true;
        Ok(())
    }

    /// Solves K x = f for `vector`, three entries per vertex, in place until ‖f − K x‖ ≤ tolerance ‖f‖; prescribed components are left
    /// out of f and come out as zero.
    ///
    /// # Errors
    /// [`SolverError::Indefinite`] at a direction of negative curvature or a pivot that is not positive; a residual that rounding keeps
    /// above the tolerance, or numbers that are not finite ([`SolverError::Iterative`]). `vector` then holds the last iterate.
    ///
    /// # Panics
    /// Panics when `vector` has not three entries per vertex.
    pub fn solve(&mut self, vector: &mut [f64], tolerance: f64) -> Result<LinearReport, SolverError> {
        assert_eq!(vector.len(), self.unknowns(), "three entries per vertex");
        for (three, vertex) in self.loads.chunks_exact_mut(3).zip(&self.order) {
            three.copy_from_slice(&vector[3 * *vertex as usize..][..3]);
        }
        self.matrix.keep_free(&mut self.loads);
        self.solution.fill(0.0);
        let outcome = self.solve_in_order(tolerance);
        for (three, vertex) in self.solution.chunks_exact(3).zip(&self.order) {
            vector[3 * *vertex as usize..][..3].copy_from_slice(three);
        }
        outcome
    }

    fn solve_in_order(&mut self, tolerance: f64) -> Result<LinearReport, SolverError> {
        let mut before = 0;
        if !self.is_current && self.factor.exists() && self.factor.allowance().is_enough() {
            match self.iterate(tolerance) {
                Err(ConjugateGradientError::Interrupted { iterations, .. }) => before = iterations,
                outcome => return self.booked(outcome, 0),
            }
        }
        let refactored = !self.is_current;
        if refactored {
            self.refactor()?;
        }
        let outcome = self.iterate(tolerance);
        Ok(LinearReport { refactored, ..self.booked(outcome, before)? })
    }

    fn booked(
        &mut self,
        outcome: Result<ConjugateGradientInfo, ConjugateGradientError>,
        before: usize,
    ) -> Result<LinearReport, SolverError> {
        let info = outcome.map_err(|error| indefinite(error, self.unknowns()))?;
        self.factor.book(info.iterations);
        let iterations = before + info.iterations;
        Ok(LinearReport { iterations, relative_residual: info.relative_residual, refactored: false })
    }

    /// Conjugate gradients from the solution so far; interrupted when an old factor is no longer worth it.
    fn iterate(&mut self, tolerance: f64) -> Result<ConjugateGradientInfo, ConjugateGradientError> {
        let parameters = ConjugateGradientParameters { tolerance, max_iterations: MAX_ITERATIONS };
        let (is_current, allowance) = (self.is_current, self.factor.allowance());
        let monitor = |iteration, residual| is_current || allowance.covers(iteration, residual, tolerance);
        let workspace = std::mem::take(&mut self.workspace);
        let mut solver = ConjugateGradients::new(&self.matrix, parameters).with_workspace(workspace);
        let outcome = solver.solve(&self.loads, &mut self.solution, &mut self.factor, &monitor);
        self.workspace = solver.into_workspace();
        outcome
    }
}
