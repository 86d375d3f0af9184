//! Coarse cells, the fine cells they hold, and the mesh of their connected parts.

mod carry;
mod coarse_mesh;
mod copies;
mod parts;
mod per_element;

pub use coarse_mesh::{CoarseMesh, Vertex};
pub use parts::CellPart;
pub use per_element::PerElement;

use crate::mesh::{Cell, Lattice, Node};

/// Index of a coarse cell in the coarse lattice, x fastest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CoarseCell(pub usize);

/// Index of a coarse node in the coarse lattice, x fastest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CoarseNode(pub usize);

/// Why a lattice cannot be coarsened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PartitionError {
    /// The coarsening degree is zero.
    #[error("the coarsening degree is 0; it is the number of fine cells per coarse cell along each axis, at least 1")]
    Degree,
    /// The degree does not divide the lattice.
    #[error("degree {degree} does not divide the {cells:?} fine cells; pad the body with voids to a multiple first")]
    NotDivisible {
        /// Fine cells along x, y, z.
        cells: [usize; 3],
        /// The degree.
        degree: usize,
    },
}

/// A box of fine cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CellBox {
    /// First fine cell.
    pub start: [usize; 3],
    /// Number of fine cells along x, y, z.
    pub cells: [usize; 3],
}

/// A fine lattice cut into coarse cells of d × d × d fine cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Partition {
    fine: Lattice,
    coarse: Lattice,
    degree: usize,
}

impl Partition {
    /// Cuts `fine` into coarse cells of `degree`³ fine cells.
    ///
    /// # Errors
    /// Degree zero, or one that does not divide the lattice.
    pub fn new(fine: Lattice, degree: usize) -> Result<Self, PartitionError> {
        if degree == 0 {
            return Err(PartitionError::Degree);
        }
        if fine.cells.iter().any(|n| n % degree != 0) {
            return Err(PartitionError::NotDivisible { cells: fine.cells, degree });
        }
        Ok(Self { fine, coarse: Lattice::new(fine.cells.map(|n| n / degree)), degree })
    }

    /// The lattice of fine cells.
    pub fn fine(&self) -> Lattice {
        self.fine
    }

    /// The lattice of coarse cells.
    pub fn coarse(&self) -> Lattice {
        self.coarse
    }

    /// Coarsening degree d: fine cells per coarse cell along each axis.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Number of fine nodes of a coarse cell, (d + 1)³.
    pub fn nodes_per_cell(&self) -> usize {
        (self.degree + 1).pow(3)
    }

    /// The lattice of the fine cells of one coarse cell.
    pub fn cell_lattice(&self) -> Lattice {
        Lattice::new([self.degree; 3])
    }

    /// The fine cells of a coarse cell.
    pub fn cell_box(&self, cell: CoarseCell) -> CellBox {
        let at = self.coarse.cell_position(Cell(cell.0));
        CellBox { start: at.map(|x| x * self.degree), cells: [self.degree; 3] }
    }

    /// The fine cells of a coarse cell and of its 26 neighbours, clipped at the lattice.
    pub fn one_ring(&self, cell: CoarseCell) -> CellBox {
        let at = self.coarse.cell_position(Cell(cell.0));
        let low = at.map(|x| x.saturating_sub(1));
        let high: [usize; 3] = std::array::from_fn(|a| (at[a] + 2).min(self.coarse.cells[a]));
        CellBox {
            start: low.map(|x| x * self.degree),
            cells: std::array::from_fn(|a| (high[a] - low[a]) * self.degree),
        }
    }

    /// Fine lattice nodes of a coarse cell, x fastest.
    pub fn fine_nodes(&self, cell: CoarseCell) -> impl Iterator<Item = Node> {
        let start = self.cell_box(cell).start;
        let (local, fine) = (self.cell_lattice(), self.fine);
        (0..local.node_count()).map(move |n| {
            let at = local.node_position(Node(n));
            fine.node(std::array::from_fn(|a| start[a] + at[a]))
        })
    }

    /// Fine cells of a coarse cell, x fastest.
    pub fn fine_cells(&self, cell: CoarseCell) -> impl Iterator<Item = Cell> {
        let start = self.cell_box(cell).start;
        let (local, fine) = (self.cell_lattice(), self.fine);
        (0..local.cell_count()).map(move |c| {
            let at = local.cell_position(Cell(c));
            fine.cell(std::array::from_fn(|a| start[a] + at[a]))
        })
    }

    /// The coarse cell that holds a fine cell.
    pub fn coarse_cell_of(&self, fine: Cell) -> CoarseCell {
        let at = self.fine.cell_position(fine).map(|x| x / self.degree);
        CoarseCell(self.coarse.cell(at).0)
    }

    /// Corner nodes of a coarse cell in the coarse lattice, x fastest.
    pub fn corners(&self, cell: CoarseCell) -> [CoarseNode; 8] {
        self.coarse.corners(Cell(cell.0)).map(|n| CoarseNode(n.0))
    }

    /// The fine node at the place of a coarse node.
    pub fn coincident_node(&self, node: CoarseNode) -> Node {
        let at = self.coarse.node_position(Node(node.0));
        self.fine.node(at.map(|x| x * self.degree))
    }

    /// Local index of the corner nodes among the (d + 1)³ fine nodes of a coarse cell.
    pub fn local_corners(&self) -> [usize; 8] {
        let local = self.cell_lattice();
        let d = self.degree;
        std::array::from_fn(|a| local.node([d * (a & 1), d * (a >> 1 & 1), d * (a >> 2)]).0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_are_clipped_at_the_lattice() {
        let partition = Partition::new(Lattice::new([8, 4, 2]), 2).unwrap();
        let first = partition.one_ring(CoarseCell(0));
        assert_eq!((first.start, first.cells), ([0, 0, 0], [4, 4, 2]));
        let second = partition.one_ring(CoarseCell(1));
        assert_eq!((second.start, second.cells), ([0, 0, 0], [6, 4, 2]));
    }

    #[test]
    fn corners_are_the_coincident_fine_nodes() {
        let partition = Partition::new(Lattice::new([6, 3, 9]), 3).unwrap();
        for c in (0..partition.coarse().cell_count()).map(CoarseCell) {
            let nodes: Vec<Node> = partition.fine_nodes(c).collect();
            for (corner, local) in partition.corners(c).iter().zip(partition.local_corners()) {
                assert_eq!(partition.coincident_node(*corner), nodes[local]);
            }
        }
    }

    #[test]
    fn a_degree_that_does_not_divide_is_refused() {
        assert!(matches!(Partition::new(Lattice::new([5, 4, 4]), 2), Err(PartitionError::NotDivisible { .. })));
        assert!(matches!(Partition::new(Lattice::new([5, 4, 4]), 0), Err(PartitionError::Degree)));
    }
}
