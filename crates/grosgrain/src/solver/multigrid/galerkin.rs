//! Galerkin cell matrices: the stiffness of a coarse cell is Σ Pᵀ K P over its children.
//!
//! Trilinear prolongation is local to nested cells, so Pᵀ K P of the lattice is the assembly of these.

use std::collections::HashMap;

use rayon::prelude::*;

use super::grid::Coarsening;
use crate::assembly::CellStiffness;
use crate::element::CellMatrix;
use crate::mesh::Cell;

/// The matrices of the cells of one lattice layer or of a whole lattice.
pub(super) type CellMatrices = Vec<CellMatrix>;

/// Cells of the finest lattice with their products Pᵀ K P, computed once per matrix and octant.
pub(super) struct FineCells<'a> {
    cells: &'a dyn CellStiffness,
    free: &'a [u8],
    coarsening: Coarsening,
    weights: [[[f64; 8]; 8]; 8],
    products: HashMap<usize, Vec<CellMatrix>>,
}

/// Matrices with more users than this are projected once; others cell by cell.
const SHARED_FROM: usize = 16;

impl<'a> FineCells<'a> {
    pub fn new(cells: &'a dyn CellStiffness, free: &'a [u8], coarsening: Coarsening) -> Self {
        let mut users: HashMap<usize, (usize, &CellMatrix)> = HashMap::new();
        for (_, matrix) in (0..cells.lattice().cell_count()).filter_map(|c| cells.stiffness(c)) {
            users.entry(address(matrix)).or_insert((0, matrix)).0 += 1;
        }
        let weights = std::array::from_fn(|octant| coarsening.weights(octant));
        let project = |matrix: &CellMatrix| weights.iter().map(|p| projected(matrix, p)).collect();
        let shared = users.into_iter().filter(|(_, (count, _))| *count > SHARED_FROM);
        let products = shared.map(|(key, (_, matrix))| (key, project(matrix))).collect();
        Self { cells, free, coarsening, weights, products }
    }

    /// The matrices of layer k of the coarse cells.
    pub fn coarse_layer(&self, k: usize) -> CellMatrices {
        let [nx, ny, _] = self.coarsening.coarse.cells;
        (0..nx * ny).into_par_iter().map(|c| self.coarse_cell([c % nx, c / nx, k])).collect()
    }

    fn coarse_cell(&self, at: [usize; 3]) -> CellMatrix {
        let mut sum = [0.0; 576];
        for (octant, cell) in self.coarsening.child_cells(at) {
            let Some((factor, matrix)) = self.cells.stiffness(cell) else { continue };
            let free = self.coarsening.fine.corners(Cell(cell)).map(|n| self.free[n.0]);
            match self.products.get(&address(matrix)) {
                Some(products) if free == [7; 8] => add(&mut sum, factor, &products[octant]),
                _ => add(&mut sum, factor, &projected(&held(matrix, &free), &self.weights[octant])),
            }
        }
        sum
    }
}

/// Adds Pᵀ K P of layer k of the cells to the coarse matrices they lie in.
pub(super) fn add_layer(coarsening: &Coarsening, k: usize, layer: &[CellMatrix], coarse: &mut [CellMatrix]) {
    let weights: [_; 8] = std::array::from_fn(|octant| coarsening.weights(octant));
    let [nx, ny, _] = coarsening.coarse.cells;
    let per_layer = coarsening.fine.cells[0] * coarsening.fine.cells[1];
    let coarse_k = if coarsening.halved[2] { k / 2 } else { k };
    coarse[coarse_k * nx * ny..(coarse_k + 1) * nx * ny].par_iter_mut().enumerate().for_each(|(c, sum)| {
        for (octant, cell) in coarsening.child_cells([c % nx, c / nx, coarse_k]) {
            if cell / per_layer == k {
                add(sum, 1.0, &projected(&layer[cell % per_layer], &weights[octant]));
            }
        }
    });
}

pub(super) fn add(sum: &mut CellMatrix, factor: f64, term: &CellMatrix) {
    sum.iter_mut().zip(term).for_each(|(s, t)| *s += factor * t);
}

/// K with zero rows and columns where a component of a corner is no unknown.
pub(super) fn held(matrix: &[f64], free: &[u8; 8]) -> CellMatrix {
    let is_free = |i: usize| free[i / 3] >> (i % 3) & 1 == 1;
    std::array::from_fn(|e| if is_free(e / 24) && is_free(e % 24) { matrix[e] } else { 0.0 })
}

/// Pᵀ K P for the scalar weights p[f][c] applied to each component.
pub(super) fn projected(matrix: &CellMatrix, p: &[[f64; 8]; 8]) -> CellMatrix {
    let mut half = [0.0; 576];
    for row in 0..24 {
        for f in 0..8 {
            for c in (0..8).filter(|c| p[f][*c] != 0.0) {
                for r in 0..3 {
                    half[24 * row + 3 * c + r] += matrix[24 * row + 3 * f + r] * p[f][c];
                }
            }
        }
    }
    let mut whole = [0.0; 576];
    for f in 0..8 {
        for c in (0..8).filter(|c| p[f][*c] != 0.0) {
            for i in 0..72 {
                whole[72 * c + i] += p[f][c] * half[72 * f + i];
            }
        }
    }
    whole
}

/// What tells shared matrices apart.
fn address(matrix: &CellMatrix) -> usize {
    std::ptr::from_ref(matrix).addr()
}
