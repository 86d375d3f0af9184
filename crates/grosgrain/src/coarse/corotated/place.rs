//! Where the elements of a coarse model are.

use super::frame::{CoarseBox, Columns};
use crate::coarse::CoarseModel;
use crate::mesh::Cell;
use crate::partition::CellPart;

/// The box of all coarse cells and the place of each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub cell: CoarseBox,
    spacing: [f64; 3],
    origin: [f64; 3],
}

impl Place {
    /// The places of the cells of a body whose frame starts at `origin` \[m\].
    pub fn new(coarse: &CoarseModel, origin: [f64; 3]) -> Self {
        Self { cell: CoarseBox::new(coarse.spacing()), spacing: coarse.spacing(), origin }
    }

    /// Position of the coarse cell of an element in the coarse lattice.
    pub fn at(coarse: &CoarseModel, element: CellPart) -> [usize; 3] {
        coarse.partition().coarse().cell_position(Cell(element.cell.0))
    }

    /// Reference centre of the coarse cell of an element \[m\].
    pub fn centre(&self, coarse: &CoarseModel, element: CellPart) -> [f64; 3] {
        let at = Self::at(coarse, element);
        std::array::from_fn(|a| self.origin[a] + self.spacing[a] * (at[a] as f64 + 0.5))
    }

    /// Displacements of the corners of element number `index`, from three per vertex.
    pub fn displacement(coarse: &CoarseModel, index: usize, u: &[f64]) -> Columns {
        let corners = &coarse.mesh().corners()[index];
        std::array::from_fn(|n| u[3 * corners[n / 3] as usize + n % 3])
    }
}
