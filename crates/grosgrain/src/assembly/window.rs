//! A box cut out of a larger lattice.

use super::CellStiffness;
use crate::element::CellMatrix;
use crate::mesh::{Cell, Lattice};

/// The cells of a box inside a larger lattice, as a lattice of their own.
pub struct Window<'a> {
    parent: &'a dyn CellStiffness,
    start: [usize; 3],
    lattice: Lattice,
    /// The cells that count; all where there is none.
    own: Option<Vec<bool>>,
}

impl<'a> Window<'a> {
    /// The box of `cells` cells whose first cell is at `start` in `parent`.
    pub fn new(parent: &'a dyn CellStiffness, start: [usize; 3], cells: [usize; 3]) -> Self {
        Self { parent, start, lattice: Lattice::new(cells), own: None }
    }

    /// The same box with all cells void but the marked ones.
    ///
    /// # Panics
    /// Panics when there is not one mark per cell of the box.
    pub fn limited_to(self, own: Vec<bool>) -> Self {
        assert_eq!(own.len(), self.lattice.cell_count(), "one mark per cell of the box");
        Self { own: Some(own), ..self }
    }

    /// First cell of the box in the larger lattice.
    pub fn start(&self) -> [usize; 3] {
        self.start
    }
}

impl CellStiffness for Window<'_> {
    fn lattice(&self) -> Lattice {
        self.lattice
    }

    fn stiffness(&self, cell: usize) -> Option<(f64, &CellMatrix)> {
        if self.own.as_ref().is_some_and(|own| !own[cell]) {
            return None;
        }
        let at = self.lattice.cell_position(Cell(cell));
        let outer = self.parent.lattice().cell(std::array::from_fn(|a| at[a] + self.start[a]));
        self.parent.stiffness(outer.0)
    }
}
