//! Training displacements per coarse cell.

use super::global::HarmonicDisplacements;
use super::rigid::{remove_rigid_motion, solve_symmetric};
use crate::fine::{FineModel, HARMONIC_FIELDS};
use crate::mesh::{Lattice, Node};
use crate::partition::{CoarseCell, Partition};

/// Training displacements of coarse cells: per cell a matrix of `3 (d + 1)³` rows (fine nodes x fastest,
/// component fastest) and one column per field, row-major.
///
/// Each column is free of rigid motion over the cell's nodes. At a node that touches no solid cell it is the
/// best affine fit of the others, so that every corner has a value.
#[derive(Clone, Debug, PartialEq)]
pub struct Training {
    cells: Vec<CoarseCell>,
    rows: usize,
    fields: usize,
    data: Vec<f64>,
}

impl Training {
    /// Training data from its parts: `data` holds one `rows × fields` matrix per cell.
    pub(super) fn from_parts(cells: Vec<CoarseCell>, rows: usize, data: Vec<f64>) -> Self {
        Self { cells, rows, fields: HARMONIC_FIELDS, data }
    }

    /// Cuts the data of the listed cells out of the displacements of the whole object.
    pub fn from_harmonic(
        model: &FineModel,
        partition: &Partition,
        cells: &[CoarseCell],
        harmonic: &HarmonicDisplacements,
    ) -> Self {
        let cutter = CellCutter::new(partition, model.grid().spacing);
        let mut data = Vec::with_capacity(cells.len() * cutter.rows() * HARMONIC_FIELDS);
        for &cell in cells {
            let nodes: Vec<Node> = partition.fine_nodes(cell).collect();
            data.extend(cutter.cut(&nodes, model.active(), &harmonic.displacements));
        }
        Self::from_parts(cells.to_vec(), cutter.rows(), data)
    }

    /// The coarse cells, in the order of their data.
    pub fn cells(&self) -> &[CoarseCell] {
        &self.cells
    }

    /// Number of fields.
    pub fn fields(&self) -> usize {
        self.fields
    }

    /// Rows of a cell's matrix, `3 (d + 1)³`.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The matrix of cell number `index` in [`Training::cells`], row-major `rows × fields`.
    pub fn of(&self, index: usize) -> &[f64] {
        let size = self.rows * self.fields;
        &self.data[size * index..][..size]
    }

    /// All matrices, one after the other.
    pub fn data(&self) -> &[f64] {
        &self.data
    }
}

/// Cuts a coarse cell's nodes out of displacements on a larger lattice.
pub(super) struct CellCutter {
    local: Lattice,
    spacing: [f64; 3],
}

impl CellCutter {
    pub(super) fn new(partition: &Partition, spacing: [f64; 3]) -> Self {
        Self { local: partition.cell_lattice(), spacing }
    }

    pub(super) fn rows(&self) -> usize {
        3 * self.local.node_count()
    }

    /// The `rows × 6` matrix of the cell whose fine nodes are `nodes` on a lattice with the marked `active` nodes and
    /// the six displacement vectors in `fields`, one after the other.
    pub(super) fn cut(&self, nodes: &[Node], active: &[bool], fields: &[f64]) -> Vec<f64> {
        let stride = 3 * active.len();
        let here: Vec<bool> = nodes.iter().map(|n| active[n.0]).collect();
        let mut matrix = vec![0.0; self.rows() * HARMONIC_FIELDS];
        let mut column = vec![0.0; self.rows()];
        for field in 0..HARMONIC_FIELDS {
            for (local, node) in nodes.iter().enumerate() {
                (0..3).for_each(|r| column[3 * local + r] = fields[stride * field + 3 * node.0 + r]);
            }
            if !here.iter().all(|a| *a) {
                self.extend_into_voids(&here, &mut column);
            }
            remove_rigid_motion(self.local, self.spacing, &vec![true; here.len()], &mut column);
            column.iter().enumerate().for_each(|(row, u)| matrix[HARMONIC_FIELDS * row + field] = *u);
        }
        matrix
    }

    /// Sets the nodes that are not marked to the affine field that fits the marked ones best: u ≈ ū + G (x − x̄).
    fn extend_into_voids(&self, active: &[bool], column: &mut [f64]) {
        let position = |n: usize| -> [f64; 3] {
            let at = self.local.node_position(Node(n));
            std::array::from_fn(|a| at[a] as f64 * self.spacing[a])
        };
        let known: Vec<usize> = (0..active.len()).filter(|&n| active[n]).collect();
        let count = known.len() as f64;
        let centre: [f64; 3] = std::array::from_fn(|a| known.iter().map(|&n| position(n)[a]).sum::<f64>() / count);
        let offset = |n: usize| -> [f64; 3] { std::array::from_fn(|a| position(n)[a] - centre[a]) };
        let mut spread = [[0.0; 3]; 3];
        for r in known.iter().map(|&n| offset(n)) {
            (0..9).for_each(|i| spread[i / 3][i % 3] += r[i / 3] * r[i % 3]);
        }
        for component in 0..3 {
            let mean = known.iter().map(|&n| column[3 * n + component]).sum::<f64>() / count;
            let mut moment = [0.0; 3];
            for &n in &known {
                let r = offset(n);
                (0..3).for_each(|a| moment[a] += r[a] * (column[3 * n + component] - mean));
            }
            let gradient = solve_symmetric(spread, moment);
            for n in (0..active.len()).filter(|&n| !active[n]) {
                let r = offset(n);
                column[3 * n + component] = mean + (0..3).map(|a| gradient[a] * r[a]).sum::<f64>();
            }
        }
    }
}
