//! A box of hexahedral cells and its nodes, numbered x fastest.

/// Index of a fine cell in its [`Lattice`], x fastest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell(pub usize);

/// Index of a fine lattice node, x fastest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Node(pub usize);

/// A box of `cells[0] × cells[1] × cells[2]` hexahedra.
///
/// Cell (i, j, k) has index `i + nx (j + ny k)`; its eight corners, numbered x fastest
/// (000, 100, 010, 110, 001, …), are nodes of the `(nx+1) × (ny+1) × (nz+1)` node lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Lattice {
    /// Number of cells along x, y, z.
    pub cells: [usize; 3],
}

impl Lattice {
    /// A lattice of `cells` hexahedra along x, y, z.
    pub const fn new(cells: [usize; 3]) -> Self {
        Self { cells }
    }

    /// Number of cells.
    pub const fn cell_count(&self) -> usize {
        self.cells[0] * self.cells[1] * self.cells[2]
    }

    /// Number of nodes along x, y, z.
    pub const fn nodes(&self) -> [usize; 3] {
        [self.cells[0] + 1, self.cells[1] + 1, self.cells[2] + 1]
    }

    /// Number of nodes.
    pub const fn node_count(&self) -> usize {
        let [nx, ny, nz] = self.nodes();
        nx * ny * nz
    }

    /// Index of the cell at (i, j, k).
    pub const fn cell(&self, at: [usize; 3]) -> Cell {
        Cell(at[0] + self.cells[0] * (at[1] + self.cells[1] * at[2]))
    }

    /// Index of the node at (i, j, k).
    pub const fn node(&self, at: [usize; 3]) -> Node {
        let [nx, ny, _] = self.nodes();
        Node(at[0] + nx * (at[1] + ny * at[2]))
    }

    /// Grid position (i, j, k) of a cell.
    pub const fn cell_position(&self, cell: Cell) -> [usize; 3] {
        unravel(cell.0, self.cells)
    }

    /// Grid position (i, j, k) of a node.
    pub const fn node_position(&self, node: Node) -> [usize; 3] {
        unravel(node.0, self.nodes())
    }

    /// The eight corner nodes of a cell, x fastest.
    pub const fn corners(&self, cell: Cell) -> [Node; 8] {
        let [nx, ny, _] = self.nodes();
        let base = self.node(self.cell_position(cell)).0;
        let (y, z) = (nx, nx * ny);
        [
            Node(base),
            Node(base + 1),
            Node(base + y),
            Node(base + y + 1),
            Node(base + z),
            Node(base + z + 1),
            Node(base + z + y),
            Node(base + z + y + 1),
        ]
    }

    /// The cell `offset` away from the position `at`, `None` outside of the lattice.
    pub fn neighbour(&self, at: [usize; 3], offset: [isize; 3]) -> Option<Cell> {
        let mut to = at;
        for a in 0..3 {
            to[a] = at[a].checked_add_signed(offset[a]).filter(|&i| i < self.cells[a])?;
        }
        Some(self.cell(to))
    }

    /// The up to eight cells that have `node` as a corner, x fastest.
    pub fn cells_at(&self, node: Node) -> impl Iterator<Item = Cell> {
        let at = self.node_position(node);
        let lattice = *self;
        (0..8).filter_map(move |c: isize| lattice.neighbour(at, [(c & 1) - 1, (c >> 1 & 1) - 1, (c >> 2) - 1]))
    }
}

const fn unravel(index: usize, extent: [usize; 3]) -> [usize; 3] {
    [index % extent[0], index / extent[0] % extent[1], index / (extent[0] * extent[1])]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_and_indices_are_inverse_with_x_fastest() {
        let lattice = Lattice::new([3, 4, 5]);
        assert_eq!(lattice.cell([1, 0, 0]), Cell(1));
        assert_eq!(lattice.node([0, 1, 0]), Node(4));
        for c in 0..lattice.cell_count() {
            assert_eq!(lattice.cell(lattice.cell_position(Cell(c))), Cell(c));
        }
        for n in 0..lattice.node_count() {
            assert_eq!(lattice.node(lattice.node_position(Node(n))), Node(n));
        }
    }

    #[test]
    fn cells_at_a_node_are_those_that_have_it_as_a_corner() {
        let lattice = Lattice::new([3, 1, 2]);
        for n in (0..lattice.node_count()).map(Node) {
            let expected: Vec<_> =
                (0..lattice.cell_count()).map(Cell).filter(|c| lattice.corners(*c).contains(&n)).collect();
            assert_eq!(lattice.cells_at(n).collect::<Vec<_>>(), expected, "node {n:?}");
        }
    }

    #[test]
    fn corners_are_numbered_x_fastest() {
        let lattice = Lattice::new([2, 2, 2]);
        let positions = lattice.corners(lattice.cell([1, 1, 1])).map(|n| lattice.node_position(n));
        for (a, p) in positions.iter().enumerate() {
            assert_eq!(*p, [1 + (a & 1), 1 + (a >> 1 & 1), 1 + (a >> 2)]);
        }
    }
}
