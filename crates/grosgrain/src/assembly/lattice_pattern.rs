//! The 27-point pattern of a lattice stiffness in elimination order, and assembly straight into it.

use std::sync::Arc;

use super::{CellStiffness, Constraints};
use crate::linalg::{SparsePattern, nested_dissection};
use crate::mesh::{Lattice, Node};

const NONE: u32 = u32::MAX;
/// Stencil code of a node's coupling to itself.
const CENTRE: u8 = 13;

/// Which unknowns a lattice stiffness couples, numbered in nested-dissection order.
///
/// The unknown of node n and component r has index `3 rank(n) + r`; nodes left out have no rank.
#[derive(Debug)]
pub struct LatticePattern {
    lattice: Lattice,
    rank: Vec<u32>,
    nodes: Vec<u32>,
    neighbour_starts: Vec<u32>,
    neighbours: Vec<u8>,
    pattern: Arc<SparsePattern>,
}

impl LatticePattern {
    /// The pattern on all nodes of the lattice; void nodes become identity rows. It depends on the
    /// lattice's shape only, so one analysis serves every body of that shape.
    pub fn full(lattice: Lattice) -> Self {
        Self::on_nodes(lattice, &vec![true; lattice.node_count()])
    }

    /// The pattern on the marked nodes of the lattice.
    pub fn on_nodes(lattice: Lattice, active: &[bool]) -> Self {
        let mut nodes = nested_dissection(lattice.nodes());
        nodes.retain(|n| active[*n as usize]);
        let mut rank = vec![NONE; lattice.node_count()];
        nodes.iter().enumerate().for_each(|(r, n)| rank[*n as usize] = r as u32);
        let (neighbour_starts, neighbours) = later_neighbours(lattice, &nodes, &rank);
        let mut this = Self {
            lattice,
            rank,
            nodes,
            neighbour_starts,
            neighbours,
            pattern: Arc::new(SparsePattern { column_starts: vec![0], rows: Vec::new() }),
        };
        this.pattern = Arc::new(this.sparse_pattern());
        this
    }

    /// The lattice.
    pub fn lattice(&self) -> Lattice {
        self.lattice
    }

    /// The sparse pattern, three unknowns per node.
    pub fn pattern(&self) -> &Arc<SparsePattern> {
        &self.pattern
    }

    /// Number of unknowns.
    pub fn order(&self) -> usize {
        3 * self.nodes.len()
    }

    /// First unknown of a node, `None` if it was left out.
    pub fn unknown(&self, node: Node) -> Option<usize> {
        match self.rank[node.0] {
            NONE => None,
            rank => Some(3 * rank as usize),
        }
    }

    /// Copies a lattice vector (3 entries per node, x fastest) into elimination order.
    pub fn gather_into(&self, lattice_vector: &[f64], unknowns: &mut [f64]) {
        for (rank, &node) in self.nodes.iter().enumerate() {
            let node = node as usize;
            unknowns[3 * rank..3 * rank + 3].copy_from_slice(&lattice_vector[3 * node..3 * node + 3]);
        }
    }

    /// Copies back; entries of nodes that were left out stay as they are.
    pub fn scatter_into(&self, unknowns: &[f64], lattice_vector: &mut [f64]) {
        for (rank, &node) in self.nodes.iter().enumerate() {
            let node = node as usize;
            lattice_vector[3 * node..3 * node + 3].copy_from_slice(&unknowns[3 * rank..3 * rank + 3]);
        }
    }

    /// Adds up the cell matrices into the pattern's values. Prescribed components and nodes without a solid
    /// cell become identity rows and columns.
    pub fn assemble_into(&self, cells: &dyn CellStiffness, constraints: &Constraints, values: &mut [f64]) {
        let mut blocks = [[0.0; 9]; 27];
        let mut next = 0;
        for (rank, &node) in self.nodes.iter().enumerate() {
            let neighbours = self.neighbours_of(rank);
            self.couple(cells, node as usize, neighbours, &mut blocks);
            self.prescribe(constraints, node as usize, neighbours, &mut blocks);
            for column in 0..3 {
                // The node itself is eliminated first: its block heads the list and is cut at the diagonal.
                let own = &blocks[usize::from(CENTRE)][4 * column..3 * column + 3];
                values[next..next + own.len()].copy_from_slice(own);
                next += own.len();
                for &code in &neighbours[1..] {
                    values[next..next + 3].copy_from_slice(&blocks[usize::from(code)][3 * column..][..3]);
                    next += 3;
                }
            }
        }
    }

    /// Stiffness of a node towards the listed neighbours: `blocks[code][3 column + row]`, the column being the node's.
    fn couple(&self, cells: &dyn CellStiffness, node: usize, neighbours: &[u8], blocks: &mut [[f64; 9]; 27]) {
        let mut wanted = 0u32;
        for &code in neighbours {
            blocks[usize::from(code)] = [0.0; 9];
            wanted |= 1 << code;
        }
        let at = self.lattice.node_position(Node(node));
        for corner in 0..8 {
            let Some(cell) = cell_with_corner(self.lattice, at, corner) else { continue };
            let Some((factor, matrix)) = cells.stiffness(cell) else { continue };
            let rows = &matrix[72 * corner..][..72];
            for (other, &code) in STENCIL_CODES[corner].iter().enumerate() {
                if wanted >> code & 1 == 0 {
                    continue;
                }
                let block = &mut blocks[usize::from(code)];
                for column in 0..3 {
                    let three = &rows[24 * column + 3 * other..][..3];
                    (0..3).for_each(|row| block[3 * column + row] += factor * three[row]);
                }
            }
        }
    }

    /// Clears rows and columns of prescribed components; zero diagonal entries become one.
    fn prescribe(&self, constraints: &Constraints, node: usize, neighbours: &[u8], blocks: &mut [[f64; 9]; 27]) {
        for &code in neighbours {
            let other = neighbour(self.lattice, node, code);
            if constraints.is_free(node) && constraints.is_free(other) {
                continue;
            }
            for component in 0..3 {
                let block = &mut blocks[usize::from(code)];
                if constraints.is_fixed(node, component) {
                    block[3 * component..3 * component + 3].fill(0.0);
                }
                if constraints.is_fixed(other, component) {
                    (0..3).for_each(|column| block[3 * column + component] = 0.0);
                }
            }
        }
        let own = &mut blocks[usize::from(CENTRE)];
        for component in 0..3 {
            if own[4 * component] == 0.0 {
                own[4 * component] = 1.0;
            }
        }
    }

    fn neighbours_of(&self, rank: usize) -> &[u8] {
        &self.neighbours[self.neighbour_starts[rank] as usize..self.neighbour_starts[rank + 1] as usize]
    }

    fn sparse_pattern(&self) -> SparsePattern {
        let mut column_starts = Vec::with_capacity(self.order() + 1);
        let mut rows = Vec::with_capacity(9 * self.neighbours.len());
        column_starts.push(0);
        for (rank, &node) in self.nodes.iter().enumerate() {
            for column in 0..3 {
                for &code in self.neighbours_of(rank) {
                    let other = self.rank[neighbour(self.lattice, node as usize, code)];
                    let first = if code == CENTRE { column } else { 0 };
                    rows.extend((first..3).map(|row| 3 * other + row));
                }
                column_starts.push(rows.len() as u32);
            }
        }
        SparsePattern { column_starts, rows }
    }
}

/// For each node in elimination order, the stencil codes of itself and of its neighbours that are eliminated
/// later, in the order of their elimination.
fn later_neighbours(lattice: Lattice, nodes: &[u32], rank: &[u32]) -> (Vec<u32>, Vec<u8>) {
    let (mut starts, mut codes) = (vec![0u32], Vec::new());
    let mut found: Vec<(u32, u8)> = Vec::with_capacity(27);
    for (own, &node) in nodes.iter().enumerate() {
        let at = lattice.node_position(Node(node as usize));
        found.clear();
        for code in 0..27u8 {
            let Some(other) = neighbour_in_lattice(lattice, at, code) else { continue };
            if rank[other] != NONE && rank[other] >= own as u32 {
                found.push((rank[other], code));
            }
        }
        found.sort_unstable();
        codes.extend(found.iter().map(|(_, code)| *code));
        starts.push(codes.len() as u32);
    }
    (starts, codes)
}

/// Stencil code (dx + 1) + 3 (dy + 1) + 9 (dz + 1) of a cell's corner seen from another: `STENCIL_CODES[from][to]`.
const STENCIL_CODES: [[u8; 8]; 8] = stencil_codes();

const fn stencil_codes() -> [[u8; 8]; 8] {
    let mut codes = [[0; 8]; 8];
    let mut pair = 0;
    while pair < 64 {
        let (from, to) = (pair / 8, pair % 8);
        let (x, y, z) = ((to & 1) + 1 - (from & 1), (to >> 1 & 1) + 1 - (from >> 1 & 1), (to >> 2) + 1 - (from >> 2));
        codes[from][to] = (x + 3 * y + 9 * z) as u8;
        pair += 1;
    }
    codes
}

fn neighbour(lattice: Lattice, node: usize, code: u8) -> usize {
    let [nx, ny, _] = lattice.nodes();
    let code = usize::from(code);
    node + code % 3 + nx * (code / 3 % 3) + nx * ny * (code / 9) - 1 - nx - nx * ny
}

fn neighbour_in_lattice(lattice: Lattice, at: [usize; 3], code: u8) -> Option<usize> {
    let code = usize::from(code);
    let steps = [code % 3, code / 3 % 3, code / 9];
    let mut other = [0; 3];
    for a in 0..3 {
        other[a] = (at[a] + steps[a]).checked_sub(1).filter(|x| *x < lattice.nodes()[a])?;
    }
    Some(lattice.node(other).0)
}

/// The cell that has the node at `at` as its corner number `corner`.
fn cell_with_corner(lattice: Lattice, at: [usize; 3], corner: usize) -> Option<usize> {
    let mut cell = [0; 3];
    for a in 0..3 {
        cell[a] = at[a].checked_sub(corner >> a & 1).filter(|x| *x < lattice.cells[a])?;
    }
    Some(lattice.cell(cell).0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::{CellMatrix, Hex8};
    use crate::material::IsotropicMaterial;
    use crate::mesh::Cell;

    struct Example {
        lattice: Lattice,
        matrix: CellMatrix,
    }

    impl CellStiffness for Example {
        fn lattice(&self) -> Lattice {
            self.lattice
        }

        fn stiffness(&self, cell: usize) -> Option<(f64, &CellMatrix)> {
            (cell % 5 != 3).then_some((1.0 + cell as f64, &self.matrix))
        }
    }

    fn dense(example: &Example) -> Vec<Vec<f64>> {
        let n = 3 * example.lattice.node_count();
        let mut k = vec![vec![0.0; n]; n];
        for cell in 0..example.lattice.cell_count() {
            let Some((factor, matrix)) = example.stiffness(cell) else { continue };
            let corners = example.lattice.corners(Cell(cell));
            for (index, value) in matrix.iter().enumerate() {
                let (row, column) = (index / 24, index % 24);
                k[3 * corners[row / 3].0 + row % 3][3 * corners[column / 3].0 + column % 3] += factor * value;
            }
        }
        k
    }

    #[test]
    fn assembled_entries_are_the_sums_of_the_cell_matrices() {
        let matrix = Hex8::new([1.0, 2.0, 0.5]).stiffness(&IsotropicMaterial::new(2.0, 0.3).unwrap().tensor());
        let example = Example { lattice: Lattice::new([4, 3, 2]), matrix };
        let mut constraints = Constraints::none(example.lattice.node_count());
        constraints.fix(7, 1);
        let dense = dense(&example);
        let pattern = LatticePattern::full(example.lattice);
        let mut values = vec![f64::NAN; pattern.pattern().entry_count()];
        pattern.assemble_into(&example, &constraints, &mut values);
        let mut seen = 0.0;
        let rounding = 1e-15 * dense.iter().flatten().fold(0.0f64, |m, v| m.max(v.abs()));
        for (rank_a, &a) in pattern.nodes.iter().enumerate() {
            for c in 0..3 {
                for e in pattern.pattern().column(3 * rank_a + c) {
                    let row = pattern.pattern().rows[e] as usize;
                    let (b, r) = (pattern.nodes[row / 3] as usize, row % 3);
                    let exact = match (
                        constraints.is_fixed(a as usize, c) || constraints.is_fixed(b, r),
                        row == 3 * rank_a + c,
                    ) {
                        (true, diagonal) => f64::from(u8::from(diagonal)),
                        (false, true) if dense[3 * a as usize + c][3 * b + r] == 0.0 => 1.0,
                        _ => dense[3 * a as usize + c][3 * b + r],
                    };
                    assert!(
                        (values[e] - exact).abs() <= rounding,
                        "({b},{r}),({a},{c}): {} against {exact}",
                        values[e]
                    );
                    seen += values[e].abs();
                }
            }
        }
        assert!(seen > 0.0);
    }
}
