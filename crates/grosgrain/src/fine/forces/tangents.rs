//! One tangent stiffness for every solid cell.

use rayon::prelude::*;

use crate::assembly::CellStiffness;
use crate::element::CellMatrix;
use crate::fine::FineModel;
use crate::linalg::matrix3::Matrix3;
use crate::mesh::{Cell, Lattice};

/// The slot of a void.
const NONE: u32 = u32::MAX;

/// Tangent stiffness \[N/m\] of every solid cell of a fine model: 4.6 kB each, allocated once and refilled by
/// [`FineForces::tangents`](super::FineForces::tangents).
#[derive(Clone, Debug)]
pub struct CellTangents {
    lattice: Lattice,
    /// Where the matrix of a cell stands.
    slots: Vec<u32>,
    cells: Vec<u32>,
    matrices: Vec<CellMatrix>,
}

impl CellTangents {
    /// Zero matrices for the solid cells of a model.
    pub fn new(model: &FineModel) -> Self {
        let mut tangents =
            Self { lattice: model.grid.lattice, slots: Vec::new(), cells: Vec::new(), matrices: Vec::new() };
        tangents.follow(model);
        tangents
    }

    /// Adds a block \[N/m\] to the diagonal of corner 0…7 of a cell: its share of a mass, a contact.
    ///
    /// # Panics
    /// If the cell is void.
    pub fn add_to_corner_diagonal(&mut self, cell: Cell, corner: usize, block: &Matrix3) {
        let matrix = &mut self.matrices[self.slots[cell.0] as usize];
        for (i, j) in (0..9).map(|n| (n / 3, n % 3)) {
            matrix[24 * (3 * corner + i) + 3 * corner + j] += block[i][j];
        }
    }

    /// Adds `factor` times other tangents of the same cells.
    ///
    /// # Panics
    /// If the solid cells are others.
    pub fn add(&mut self, factor: f64, other: &Self) {
        assert_eq!(self.cells, other.cells, "tangents of the same cells");
        self.matrices.par_iter_mut().zip(&other.matrices).for_each(|(to, from)| {
            to.iter_mut().zip(from).for_each(|(to, from)| *to += factor * from);
        });
    }

    /// Makes the solid cells those of the model; what is there keeps its place if they are the same.
    pub(super) fn follow(&mut self, model: &FineModel) {
        let count = model.grid.lattice.cell_count();
        let solid = |cell: usize| !model.is_void(Cell(cell));
        let same = self.slots.len() == count && (0..count).all(|c| solid(c) == (self.slots[c] != NONE));
        if same && self.lattice == model.grid.lattice {
            return;
        }
        self.lattice = model.grid.lattice;
        self.cells.clear();
        self.cells.extend((0..count).filter(|c| solid(*c)).map(|c| c as u32));
        self.slots.clear();
        self.slots.resize(count, NONE);
        self.cells.iter().zip(0..).for_each(|(cell, slot)| self.slots[*cell as usize] = slot);
        self.matrices.resize(self.cells.len(), [0.0; 576]);
    }

    /// The solid cells and their matrices.
    pub(super) fn cells_mut(&mut self) -> impl ParallelIterator<Item = (Cell, &mut CellMatrix)> {
        self.cells.par_iter().map(|cell| Cell(*cell as usize)).zip(&mut self.matrices)
    }
}

impl CellStiffness for CellTangents {
    fn lattice(&self) -> Lattice {
        self.lattice
    }

    fn stiffness(&self, cell: usize) -> Option<(f64, &CellMatrix)> {
        Some((1.0, self.matrices.get(self.slots[cell] as usize)?))
    }
}
