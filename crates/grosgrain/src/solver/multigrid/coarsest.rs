//! The coarsest lattice, solved by a dense Cholesky factor.

use super::galerkin::CellMatrices;
use super::grid::Layout;
use crate::linalg::{DenseCholesky, DenseCholeskyError};
use crate::mesh::{Lattice, Node};

pub(super) struct Coarsest {
    /// Entries of the layout that have stiffness, in the order of the factor.
    unknowns: Vec<usize>,
    factor: DenseCholesky,
}

impl Coarsest {
    /// Assembles layers of cell matrices, adds `shift` times the diagonal, and factors.
    pub fn new(
        lattice: Lattice,
        layer: impl Fn(usize) -> CellMatrices,
        shift: f64,
    ) -> Result<Self, DenseCholeskyError> {
        let size = 3 * lattice.node_count();
        let mut full = vec![0.0; size * size];
        for k in 0..lattice.cells[2] {
            for (c, matrix) in layer(k).iter().enumerate() {
                let [nx, ny, _] = lattice.cells;
                let corners = lattice.corners(lattice.cell([c % nx, c / nx % ny, k]));
                let global = |i: usize| 3 * corners[i / 3].0 + i % 3;
                for (entry, value) in matrix.iter().enumerate() {
                    full[size * global(entry / 24) + global(entry % 24)] += value;
                }
            }
        }
        let kept: Vec<usize> = (0..size).filter(|i| full[size * i + i] > 0.0).collect();
        let n = kept.len();
        let mut matrix = vec![0.0; n * n];
        for (row, i) in kept.iter().enumerate() {
            for (column, j) in kept.iter().enumerate() {
                let factor = if row == column { 1.0 + shift } else { 1.0 };
                matrix[n * row + column] = factor * full[size * i + j];
            }
        }
        let layout = Layout::rows(lattice);
        let place = |i: usize| layout.index(lattice.node_position(Node(i / 3))) + i % 3 * layout.component;
        Ok(Self { unknowns: kept.into_iter().map(place).collect(), factor: DenseCholesky::new(n, matrix)? })
    }

    /// x = A⁻¹ b.
    pub fn solve(&self, b: &[f64], x: &mut [f64]) {
        let mut values: Vec<f64> = self.unknowns.iter().map(|i| b[*i]).collect();
        self.factor.solve_in_place(&mut values);
        x.fill(0.0);
        self.unknowns.iter().zip(values).for_each(|(i, value)| x[*i] = value);
    }
}
