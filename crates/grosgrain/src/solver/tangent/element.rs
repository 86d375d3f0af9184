//! Newton systems of meshes of elements with eight, four or any other number of corners and any topology.

use super::super::SolverError;
use super::super::block_matrix::BlockMatrix;
use super::super::multigrid::{MeshCycle, MeshGrid};
use super::LinearReport;
use super::indefinite;
use super::lagged_factor::LaggedFactor;
use super::wear::Wear;
use crate::assembly::Constraints;
use crate::linalg::{
    ConjugateGradientError, ConjugateGradientInfo, ConjugateGradientParameters, ConjugateGradientWorkspace,
    ConjugateGradients, Monitor, Preconditioner,
};
use crate::mesh::Lattice;

/// With a factor of the matrix itself one or two iterations are the rule; an old factor is given up long before this.
const MAX_ITERATIONS: usize = 1000;

/// The tangent stiffness of elements of N corners that meet at vertices, three unknowns per vertex, whose matrices change from one Newton
/// iteration to the next while the elements meet at the same vertices.
///
/// Conjugate gradients on the current matrix. The preconditioner is the last Cholesky factor ([`Self::new`]) or a multigrid cycle on
/// coarser meshes of the same topology ([`Self::on_lattice`]). The factor is renewed when a solve costs more iterations than the solves since the
/// last factorisation did on average, the price of the factorisation included (the rule for replacing a machine whose upkeep grows).
/// Prices are counted operations, never seconds, so that runs are repeatable. The cycle is renewed by the next update after a
/// solve that needs more than 1.5 n + 5 iterations, n being those of the first solve with it, per decimal digit.
///
/// Memory per vertex of hexahedra: about 2.1 kB for the matrix, 0.3 kB per element for its places, 0.2 kB for vectors; with a cycle 1.8 kB more;
/// with a factor the pattern and a copy of the matrix, 1.5 kB, and the factor itself, about 90 B × (3 n)^{4/3} for n vertices, twice that in double precision, from the first factorisation on.
/// Nothing is allocated by [`Self::solve`] but a factor and the vectors of the first call.
#[derive(Debug)]
pub struct ElementTangent<const N: usize = 8> {
    /// Vertices in elimination order.
    order: Vec<u32>,
    matrix: BlockMatrix<f64, N>,
    method: Method,
    loads: Vec<f64>,
    solution: Vec<f64>,
    workspace: ConjugateGradientWorkspace,
}

#[derive(Debug)]
enum Method {
    /// A factor, and whether it is that of the matrix.
    Factor(LaggedFactor, bool),
    Cycle(Box<MeshCycle>, Wear),
}

/// Where the elements of a mesh lie: each in a cell of a lattice, its corners at those of the cell. Several elements may lie in one cell.
#[derive(Clone, Debug, PartialEq)]
pub struct ElementCells {
    /// The lattice.
    pub lattice: Lattice,
    /// Edge lengths of a cell \[m\].
    pub spacing: [f64; 3],
    /// The cell of each element.
    pub cells: Vec<u32>,
}

impl ElementTangent {
    /// [`Self::new`] for elements in the cells of a lattice: with more than `factor_limit` unknowns ([`super::COARSE_FACTOR_LIMIT`] is a good one for coarse elements) a multigrid
    /// cycle takes the place of the factor. The cycle is the faster choice by far for large meshes, split or not.
    ///
    /// # Errors
    /// When the factor does not fit into indices.
    ///
    /// # Panics
    /// Panics when a corner is not in `order`, or there is not one cell per element.
    pub fn on_lattice(
        order: Vec<u32>,
        corners: &[[u32; 8]],
        place: ElementCells,
        factor_limit: usize,
    ) -> Result<Self, SolverError> {
        assert_eq!(place.cells.len(), corners.len(), "one cell per element");
        if 3 * order.len() <= factor_limit {
            return Self::new(order, corners);
        }
        let matrix = Self::matrix(&order, corners)?;
        let ElementCells { lattice, spacing, cells } = place;
        let grid = MeshGrid { lattice, cells, corners: matrix.corners().to_vec(), vertices: order.len() };
        let cycle = Box::new(MeshCycle::new(grid, spacing)?);
        Ok(Self::with_method(order, matrix, Method::Cycle(cycle, Wear::complete())))
    }
}

impl<const N: usize> ElementTangent<N> {
    /// A system of elements with these corners, whose vertices are eliminated in the given `order`, each of them once.
    ///
    /// # Errors
    /// When the factor does not fit into indices.
    ///
    /// # Panics
    /// Panics when a corner is not in `order`.
    pub fn new(order: Vec<u32>, corners: &[[u32; N]]) -> Result<Self, SolverError> {
        let matrix = Self::matrix(&order, corners)?;
        let factor = LaggedFactor::new(&matrix)?;
        Ok(Self::with_method(order, matrix, Method::Factor(factor, false)))
    }

    fn matrix(order: &[u32], corners: &[[u32; N]]) -> Result<BlockMatrix<f64, N>, SolverError> {
        let mut rank = vec![u32::MAX; order.len()];
        order.iter().enumerate().for_each(|(r, v)| rank[*v as usize] = r as u32);
        BlockMatrix::new(order.len(), corners.iter().map(|c| c.map(|v| rank[v as usize])).collect())
    }

    fn with_method(order: Vec<u32>, matrix: BlockMatrix<f64, N>, method: Method) -> Self {
        let zeros = vec![0.0; 3 * order.len()];
        let workspace = ConjugateGradientWorkspace::default();
        Self { order, matrix, method, loads: zeros.clone(), solution: zeros, workspace }
    }

    /// Number of unknowns, three per vertex.
    pub fn unknowns(&self) -> usize {
        3 * self.order.len()
    }

    /// Adds up the tangents \[N/m\] of the elements by their numbers, row-major matrices of 3 N rows, corners slowest; prescribed components of vertices are left out. With `lagged`
    /// the last factor or cycle is kept until a solve finds it too old; without, and where other components are prescribed than before,
    /// it is renewed now.
    ///
    /// # Errors
    /// [`SolverError::Indefinite`] when the matrix or that of the coarsest mesh is factored and has a pivot that is not positive, also with its diagonal raised by a
    /// billionth; a factor that does not fit into memory.
    ///
    /// # Panics
    /// Panics when a matrix has fewer than 9 N² entries.
    pub fn update<'k>(
        &mut self,
        stiffness: impl Fn(usize) -> &'k [f64] + Sync,
        constraints: &Constraints,
        lagged: bool,
    ) -> Result<(), SolverError> {
        self.update_scaled(|element| (1.0, stiffness(element)), constraints, lagged)
    }

    /// [`Self::update`] with a factor for each matrix.
    pub(super) fn update_scaled<'k>(
        &mut self,
        stiffness: impl Fn(usize) -> (f64, &'k [f64]) + Sync,
        constraints: &Constraints,
        lagged: bool,
    ) -> Result<(), SolverError> {
        let changed = self.matrix.hold(constraints, &self.order);
        self.matrix.assemble(&stiffness);
        let anew = changed || !lagged;
        match &mut self.method {
            Method::Factor(factor, is_current) => {
                *is_current = false;
                if anew || !factor.exists() {
                    factor.factor(&self.matrix)?;
                    *is_current = true;
                }
            }
            Method::Cycle(cycle, wear) if anew || wear.is_worn() => {
                *wear = Wear::complete();
                cycle.update(self.matrix.free(), &stiffness)?;
                *wear = Wear::none();
            }
            Method::Cycle(..) => {}
        }
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
        let mut system = System {
            matrix: &self.matrix,
            loads: &self.loads,
            solution: &mut self.solution,
            workspace: &mut self.workspace,
        };
        let outcome = match &mut self.method {
            Method::Factor(factor, is_current) => system.solve_with_factor(factor, is_current, tolerance),
            Method::Cycle(cycle, wear) => system.solve_with_cycle(cycle, wear, tolerance),
        };
        for (three, vertex) in self.solution.chunks_exact(3).zip(&self.order) {
            vector[3 * *vertex as usize..][..3].copy_from_slice(three);
        }
        outcome
    }

    /// "cholesky" or "multigrid-pcg".
    pub fn kind(&self) -> &'static str {
        match self.method {
            Method::Factor(..) => "cholesky",
            Method::Cycle(..) => "multigrid-pcg",
        }
    }
}

struct System<'s, const N: usize> {
    matrix: &'s BlockMatrix<f64, N>,
    loads: &'s [f64],
    solution: &'s mut [f64],
    workspace: &'s mut ConjugateGradientWorkspace,
}

impl<const N: usize> System<'_, N> {
    fn solve_with_factor(
        &mut self,
        factor: &mut LaggedFactor,
        is_current: &mut bool,
        tolerance: f64,
    ) -> Result<LinearReport, SolverError> {
        let mut before = 0;
        let allowance = factor.allowance();
        if !*is_current && factor.exists() && allowance.is_enough() {
            let monitor = |iteration, residual| allowance.covers(iteration, residual, tolerance);
            match self.iterate(factor, tolerance, &monitor) {
                Err(ConjugateGradientError::Interrupted { iterations, .. }) => before = iterations,
                outcome => {
                    let info = outcome.map_err(|error| self.refused(error))?;
                    factor.book(info.iterations);
                    return Ok(report(info, 0, false));
                }
            }
        }
        let refactored = !*is_current;
        loop {
            if !*is_current {
                factor.factor(self.matrix)?;
                *is_current = true;
            }
            let patience = factor.patience();
            let monitor = |iteration, residual| residual <= tolerance || iteration < patience;
            match self.iterate(factor, tolerance, &monitor) {
                Err(error) if patience < MAX_ITERATIONS && is_loss_of_digits(&error) => {
                    before += patience;
                    factor.ask_for_double();
                    *is_current = false;
                }
                outcome => return outcome.map(|info| report(info, before, refactored)).map_err(|e| self.refused(e)),
            }
        }
    }

    fn solve_with_cycle(
        &mut self,
        cycle: &mut MeshCycle,
        wear: &mut Wear,
        tolerance: f64,
    ) -> Result<LinearReport, SolverError> {
        let info = self.iterate(cycle, tolerance, &|_, _| true).map_err(|error| self.refused(error))?;
        wear.book(info.iterations, info.relative_residual);
        Ok(report(info, 0, false))
    }

    /// Conjugate gradients from the solution so far.
    fn iterate(
        &mut self,
        preconditioner: &mut dyn Preconditioner,
        tolerance: f64,
        monitor: Monitor,
    ) -> Result<ConjugateGradientInfo, ConjugateGradientError> {
        let parameters = ConjugateGradientParameters { tolerance, max_iterations: MAX_ITERATIONS };
        let workspace = std::mem::take(self.workspace);
        let mut solver = ConjugateGradients::new(self.matrix, parameters).with_workspace(workspace);
        let outcome = solver.solve(self.loads, self.solution, preconditioner, monitor);
        *self.workspace = solver.into_workspace();
        outcome
    }

    fn refused(&self, error: ConjugateGradientError) -> SolverError {
        indefinite(error, 3 * self.matrix.vertices())
    }
}

/// Whether a preconditioner in single precision may be what has failed: slow, not definite, or beyond its range.
fn is_loss_of_digits(error: &ConjugateGradientError) -> bool {
    match error {
        ConjugateGradientError::Interrupted { .. } | ConjugateGradientError::NonFinite { .. } => true,
        ConjugateGradientError::Indefinite { what, .. } => *what != "the operator",
        _ => false,
    }
}

fn report(info: ConjugateGradientInfo, before: usize, refactored: bool) -> LinearReport {
    let ConjugateGradientInfo { iterations, relative_residual } = info;
    LinearReport { iterations: before + iterations, relative_residual, refactored }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::DenseCholesky;

    /// Symmetric and positive definite: a 12×12 Laplacian of each component with a little of everything.
    fn matrix(element: usize) -> [f64; 144] {
        std::array::from_fn(|e| {
            let (row, column) = ((e / 12).max(e % 12), (e / 12).min(e % 12));
            let noise = 0.1 * ((7 * row + 3 * column + 5 * element) as f64).sin();
            noise + if row == column { 4.0 + element as f64 } else { -f64::from(u8::from(row % 3 == column % 3)) }
        })
    }

    #[test]
    fn elements_of_four_corners_are_assembled_and_solved_as_a_dense_matrix_is() {
        // A corner that stands twice in an element gets the sum of what stands for it.
        let corners: [[u32; 4]; 5] = [[0, 1, 2, 3], [5, 3, 2, 1], [4, 5, 0, 3], [6, 4, 5, 1], [2, 6, 2, 0]];
        let matrices: Vec<[f64; 144]> = (0..5).map(matrix).collect();
        let mut constraints = Constraints::none(7);
        [(0, 0), (0, 1), (0, 2), (4, 1)].into_iter().for_each(|(node, r)| constraints.fix(node, r));
        let mut dense = vec![0.0; 21 * 21];
        for (corners, matrix) in corners.iter().zip(&matrices) {
            let at = |i: usize| 3 * corners[i / 3] as usize + i % 3;
            (0..144).for_each(|e| dense[21 * at(e / 12) + at(e % 12)] += matrix[e]);
        }
        let is_fixed = |i: usize| constraints.is_fixed(i / 3, i % 3);
        for (i, j) in (0..441).map(|e| (e / 21, e % 21)).filter(|(i, j)| is_fixed(*i) || is_fixed(*j)) {
            dense[21 * i + j] = f64::from(u8::from(i == j));
        }
        let loads: Vec<f64> = (0..21).map(|i| (i as f64).cos()).collect();
        let mut exact: Vec<f64> = (0..21).map(|i| if is_fixed(i) { 0.0 } else { loads[i] }).collect();
        DenseCholesky::new(21, dense).unwrap().solve_in_place(&mut exact);
        for order in [vec![0, 1, 2, 3, 4, 5, 6], vec![3, 6, 0, 5, 2, 1, 4]] {
            let mut tangent = ElementTangent::new(order, &corners).unwrap();
            tangent.update(|e| &matrices[e], &constraints, false).unwrap();
            let mut found = loads.clone();
            tangent.solve(&mut found, 1e-13).unwrap();
            for i in 0..21 {
                assert!((found[i] - exact[i]).abs() < 1e-12, "entry {i}: {} against {}", found[i], exact[i]);
            }
        }
    }
}
