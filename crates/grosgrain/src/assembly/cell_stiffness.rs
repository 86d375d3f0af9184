//! What an assembled or matrix-free operator needs to know of each cell.

use crate::element::CellMatrix;
use crate::mesh::Lattice;

/// The stiffness of every cell of a lattice, as a factor times a shared 24×24 matrix.
///
/// Fine cells share one reference matrix per material, coarse cells have one each; void cells have none.
pub trait CellStiffness: Sync {
    /// The lattice of cells.
    fn lattice(&self) -> Lattice;

    /// Factor and matrix \[N/m\] of the cell with this index, `None` for a void.
    fn stiffness(&self, cell: usize) -> Option<(f64, &CellMatrix)>;
}
