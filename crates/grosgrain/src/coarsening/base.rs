//! The functions that the training data correct.

use std::sync::Arc;

use super::COLUMNS;
use crate::assembly::{CellStiffness, Constraints, LatticePattern};
use crate::element::{CellMatrix, gauss_2x2x2, trilinear, trilinear_gradients};
use crate::mesh::{Cell, Lattice, Node};
use crate::solver::{AnalysedLattice, DirectSolver, SolverError, Support};

/// Which functions a cell starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BaseKind {
    /// Discrete harmonic extension of the corners' Kronecker deltas (the papers').
    Harmonic,
    /// Trilinear weights.
    Trilinear,
    /// The cell's own elastic extension of trilinear data on its faces.
    Material,
}

/// Base functions of all cells of one shape: `3 (d + 1)³ × 24`, row-major, rows of fine nodes (x fastest,
/// component fastest), columns of corners likewise.
#[derive(Clone, Debug)]
pub struct BaseFunctions {
    weights: Vec<[f64; 8]>,
    functions: Vec<f64>,
}

impl BaseFunctions {
    /// φ_i of the coarse cell with `degree`³ fine cells of edge lengths `spacing`: minimises Σ_i ∫ |∇φ_i|² with
    /// φ_i = δ at the corners, natural conditions elsewhere. Depends on degree and aspect ratio only.
    ///
    /// # Errors
    /// When the scalar Laplace problem is not solved.
    pub fn harmonic(degree: usize, spacing: [f64; 3]) -> Result<Self, SolverError> {
        let cells = LaplaceCells { lattice: Lattice::new([degree; 3]), matrix: laplace_matrix(spacing) };
        Ok(Self::from_weights(harmonic_weights(&cells)?))
    }

    /// Trilinear weights.
    pub fn trilinear(degree: usize) -> Self {
        let lattice = Lattice::new([degree; 3]);
        let weight = |n: usize| trilinear(lattice.node_position(Node(n)).map(|x| x as f64 / degree as f64));
        Self::from_weights((0..lattice.node_count()).map(weight).collect())
    }

    fn from_weights(weights: Vec<[f64; 8]>) -> Self {
        let mut functions = vec![0.0; 3 * weights.len() * COLUMNS];
        for (node, weight) in weights.iter().enumerate() {
            for r in 0..3 {
                let row = &mut functions[(3 * node + r) * COLUMNS..][..COLUMNS];
                (0..8).for_each(|i| row[3 * i + r] = weight[i]);
            }
        }
        Self { weights, functions }
    }

    /// Scalar weights of the corners at each fine node.
    pub fn weights(&self) -> &[[f64; 8]] {
        &self.weights
    }

    /// The `3 (d + 1)³ × 24` matrix.
    pub fn functions(&self) -> &[f64] {
        &self.functions
    }
}

/// Elastic extensions of trilinear face data into coarse cells.
pub struct MaterialBase {
    solver: DirectSolver,
    surface: Constraints,
    trilinear: BaseFunctions,
    block: Vec<f64>,
}

/// Stiffness of a void, relative to the softest solid cell, while face data are extended through a cell: an
/// island inside a void then has a position, and voids carry next to nothing.
const VOID_STIFFNESS: f64 = 1e-6;

impl MaterialBase {
    /// Room for cells of `degree`³ fine cells.
    ///
    /// # Errors
    /// When the symbolic analysis fails.
    pub fn new(degree: usize) -> Result<Self, SolverError> {
        let lattice = Lattice::new([degree; 3]);
        let analysed = Arc::new(AnalysedLattice::new(LatticePattern::full(lattice))?);
        let on_surface = |n: usize| lattice.node_position(Node(n)).iter().any(|x| *x == 0 || *x == degree);
        let mask: Vec<bool> = (0..lattice.node_count()).map(on_surface).collect();
        Ok(Self {
            solver: DirectSolver::new(analysed, COLUMNS)?,
            surface: Constraints::nodes(&mask),
            trilinear: BaseFunctions::trilinear(degree),
            block: vec![0.0; 3 * lattice.node_count() * COLUMNS],
        })
    }

    /// The functions of one cell whose fine cells are `cells`, `3 (d + 1)³ × 24` row-major.
    ///
    /// # Errors
    /// When the extension problem is not solved.
    pub fn functions(&mut self, cells: &dyn CellStiffness) -> Result<Vec<f64>, SolverError> {
        let filled = FilledVoids::new(cells);
        self.residual_of_trilinear(&filled);
        self.solver.factor(&filled, &Support::Constraints(self.surface.clone()))?;
        self.solver.solve_in_place(&mut self.block);
        let rows = self.block.len() / COLUMNS;
        let mut functions = self.trilinear.functions.clone();
        for (column, correction) in self.block.chunks_exact(rows).enumerate() {
            correction.iter().enumerate().for_each(|(row, c)| functions[row * COLUMNS + column] += c);
        }
        Ok(functions)
    }

    /// Sets the block to −K N for the trilinear N, one column per corner and component.
    fn residual_of_trilinear(&mut self, cells: &dyn CellStiffness) {
        let lattice = cells.lattice();
        let rows = 3 * lattice.node_count();
        self.block.fill(0.0);
        for cell in 0..lattice.cell_count() {
            let Some((factor, matrix)) = cells.stiffness(cell) else { continue };
            let corners = lattice.corners(Cell(cell));
            for (a, node) in corners.iter().enumerate() {
                for (b, other) in corners.iter().enumerate() {
                    for (i, weight) in self.trilinear.weights[other.0].iter().enumerate() {
                        for entry in 0..9 {
                            let (r, c) = (entry / 3, entry % 3);
                            self.block[rows * (3 * i + c) + 3 * node.0 + r] -=
                                factor * weight * matrix[24 * (3 * a + r) + 3 * b + c];
                        }
                    }
                }
            }
        }
    }
}

/// Cells with every void replaced by a very soft solid.
struct FilledVoids<'a> {
    cells: &'a dyn CellStiffness,
    soft: Option<(f64, CellMatrix)>,
}

impl<'a> FilledVoids<'a> {
    fn new(cells: &'a dyn CellStiffness) -> Self {
        let size = |(factor, matrix): (f64, &CellMatrix)| factor * matrix[0];
        let softest = (0..cells.lattice().cell_count())
            .filter_map(|c| cells.stiffness(c))
            .min_by(|a, b| size(*a).total_cmp(&size(*b)));
        Self { cells, soft: softest.map(|(factor, matrix)| (VOID_STIFFNESS * factor, *matrix)) }
    }
}

impl CellStiffness for FilledVoids<'_> {
    fn lattice(&self) -> Lattice {
        self.cells.lattice()
    }

    fn stiffness(&self, cell: usize) -> Option<(f64, &CellMatrix)> {
        self.cells.stiffness(cell).or_else(|| self.soft.as_ref().map(|(factor, matrix)| (*factor, matrix)))
    }
}

struct LaplaceCells {
    lattice: Lattice,
    matrix: CellMatrix,
}

impl CellStiffness for LaplaceCells {
    fn lattice(&self) -> Lattice {
        self.lattice
    }

    fn stiffness(&self, _: usize) -> Option<(f64, &CellMatrix)> {
        Some((1.0, &self.matrix))
    }
}

/// ∫ ∇N_a·∇N_b on one fine cell, times the 3×3 identity; edge lengths relative to their largest.
fn laplace_matrix(spacing: [f64; 3]) -> CellMatrix {
    let largest = spacing.iter().fold(0.0f64, |m, h| m.max(*h));
    let h = spacing.map(|s| s / largest);
    let mut matrix = [0.0; 576];
    for point in gauss_2x2x2() {
        let gradients = trilinear_gradients(point.at).map(|g| [g[0] / h[0], g[1] / h[1], g[2] / h[2]]);
        for (a, b) in (0..64).map(|n| (n / 8, n % 8)) {
            let product: f64 = (0..3).map(|i| gradients[a][i] * gradients[b][i]).sum();
            let entry = point.weight * h.iter().product::<f64>() * product;
            (0..3).for_each(|r| matrix[24 * (3 * a + r) + 3 * b + r] += entry);
        }
    }
    matrix
}

fn harmonic_weights(cells: &LaplaceCells) -> Result<Vec<[f64; 8]>, SolverError> {
    let lattice = cells.lattice;
    let d = lattice.cells[0];
    let corners: [usize; 8] = std::array::from_fn(|a| lattice.node([d * (a & 1), d * (a >> 1 & 1), d * (a >> 2)]).0);
    let mut constraints = Constraints::none(lattice.node_count());
    corners.iter().for_each(|&n| (0..3).for_each(|r| constraints.fix(n, r)));
    let mut solver = DirectSolver::new(Arc::new(AnalysedLattice::new(LatticePattern::full(lattice))?), 8)?;
    solver.factor(cells, &Support::Constraints(constraints))?;
    let stride = 3 * lattice.node_count();
    let mut block = vec![0.0; 8 * stride];
    for cell in 0..lattice.cell_count() {
        let nodes = lattice.corners(Cell(cell));
        for (b, node) in nodes.iter().enumerate() {
            let Some(i) = corners.iter().position(|c| *c == node.0) else { continue };
            for (a, other) in nodes.iter().enumerate() {
                block[stride * i + 3 * other.0] -= cells.matrix[24 * 3 * a + 3 * b];
            }
        }
    }
    solver.solve_in_place(&mut block);
    let mut weights: Vec<[f64; 8]> =
        (0..lattice.node_count()).map(|n| std::array::from_fn(|i| block[stride * i + 3 * n])).collect();
    (0..8).for_each(|i| weights[corners[i]][i] = 1.0);
    Ok(weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn harmonic_weights_sum_to_one_and_are_deltas_at_the_corners() {
        for degree in 1..=5 {
            let base = BaseFunctions::harmonic(degree, [1.0, 0.5, 2.0]).unwrap();
            for weights in base.weights() {
                assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            }
            assert_eq!(base.weights()[0][0], 1.0);
            assert_eq!(base.weights().last().unwrap()[7], 1.0);
        }
    }

    #[test]
    fn harmonic_weights_balance_at_every_free_node() {
        let degree = 3;
        let spacing = [1.0, 0.5, 2.0];
        let base = BaseFunctions::harmonic(degree, spacing).unwrap();
        let (lattice, matrix) = (Lattice::new([degree; 3]), laplace_matrix(spacing));
        let mut flux = vec![0.0; lattice.node_count()];
        for cell in 0..lattice.cell_count() {
            let nodes = lattice.corners(Cell(cell));
            for (a, b) in (0..64).map(|n| (n / 8, n % 8)) {
                flux[nodes[a].0] += matrix[24 * 3 * a + 3 * b] * base.weights()[nodes[b].0][2];
            }
        }
        let corner = |n: usize| lattice.node_position(Node(n)).iter().all(|x| *x == 0 || *x == degree);
        for n in 0..flux.len() {
            assert_eq!(flux[n].abs() > 1e-12, corner(n), "node {n}: {}", flux[n]);
        }
    }
}
