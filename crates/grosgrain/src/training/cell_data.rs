//! Training displacements per coarse cell.

use super::global::HarmonicDisplacements;
use super::rigid::{remove_rigid_motion, solve_symmetric};
use crate::fine::{FineModel, HARMONIC_FIELDS};
use crate::mesh::{Lattice, Node};
use crate::partition::{CellPart, CoarseMesh, Partition, PerElement};

/// Training displacements of elements: per element a matrix of `3 (d + 1)³` rows (fine nodes of the coarse cell x fastest,
/// component fastest) and one column per field, row-major.
///
/// Each column is free of rigid motion over the coarse cell's nodes. At a node that touches no solid cell of the element it is the
/// best affine fit of those that do, so that every corner has a value.
#[derive(Clone, Debug, PartialEq)]
pub struct Training {
    rows: usize,
    fields: usize,
    matrices: PerElement<Box<[f64]>>,
}

impl Training {
    /// Training data from its parts: one `rows × fields` matrix per element.
    pub(super) fn from_parts(rows: usize, matrices: PerElement<Box<[f64]>>) -> Self {
        Self { rows, fields: HARMONIC_FIELDS, matrices }
    }

    /// Cuts the data of the listed elements of `mesh` out of the displacements of the whole object.
    pub fn from_harmonic(
        model: &FineModel,
        mesh: &CoarseMesh,
        elements: &[CellPart],
        harmonic: &HarmonicDisplacements,
    ) -> Self {
        let partition = mesh.partition();
        let cutter = CellCutter::new(partition, model.grid().spacing);
        let matrices = elements.iter().map(|&element| {
            let nodes: Vec<Node> = partition.fine_nodes(element.cell).collect();
            let known = known_nodes(mesh, element, (&nodes, model.active()), false);
            cutter.cut(&nodes, &known, &harmonic.displacements)
        });
        Self::from_parts(cutter.rows(), PerElement::new(elements.to_vec(), matrices.collect()))
    }

    /// The elements, in the order of their data.
    pub fn elements(&self) -> &[CellPart] {
        self.matrices.elements()
    }

    /// Number of fields.
    pub fn fields(&self) -> usize {
        self.fields
    }

    /// Rows of an element's matrix, `3 (d + 1)³`.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The matrix of element number `index` in [`Training::elements`], row-major `rows × fields`.
    pub fn of(&self, index: usize) -> &[f64] {
        &self.matrices.values()[index]
    }

    /// The matrices of all elements.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.matrices.values().iter().map(AsRef::as_ref)
    }

    /// Takes renewed data into those of a mesh that has the elements `now`, see [`PerElement::replace`].
    ///
    /// # Panics
    /// Panics when an element of `now` has no data, old or renewed.
    pub fn replace(&mut self, now: &[CellPart], renewed: Self) {
        self.matrices.replace(now, renewed.matrices);
    }
}

/// Which of the coarse cell's fine `nodes` the data of an element are cut from: all that move with its material
/// ([`CoarseMesh::tied_nodes`]), or where the displacements are those of the `cell_alone` its own. In a mesh that does not split all
/// that are `active` on the lattice of the displacements, because what hangs together is not told apart there.
pub(super) fn known_nodes(
    mesh: &CoarseMesh,
    element: CellPart,
    (nodes, active): (&[Node], &[bool]),
    cell_alone: bool,
) -> Vec<bool> {
    match (mesh.splits(), cell_alone) {
        (true, true) => mesh.touched_nodes(element),
        (true, false) => mesh.tied_nodes(element),
        (false, _) => nodes.iter().map(|n| active[n.0]).collect(),
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

    /// The `rows × 6` matrix of a cell whose fine nodes are `nodes` on the lattice of the six displacement vectors in `fields`, which stand one
    /// after the other; what is not `known` is extended from what is.
    pub(super) fn cut(&self, nodes: &[Node], known: &[bool], fields: &[f64]) -> Box<[f64]> {
        let stride = fields.len() / HARMONIC_FIELDS;
        let mut matrix = vec![0.0; self.rows() * HARMONIC_FIELDS];
        let mut column = vec![0.0; self.rows()];
        for field in 0..HARMONIC_FIELDS {
            for (local, node) in nodes.iter().enumerate() {
                (0..3).for_each(|r| column[3 * local + r] = fields[stride * field + 3 * node.0 + r]);
            }
            if !known.iter().all(|k| *k) {
                self.extend_from(known, &mut column);
            }
            remove_rigid_motion(self.local, self.spacing, &vec![true; known.len()], &mut column);
            column.iter().enumerate().for_each(|(row, u)| matrix[HARMONIC_FIELDS * row + field] = *u);
        }
        matrix.into_boxed_slice()
    }

    /// Sets the nodes that are not `known` to the affine field that fits the known ones best: u ≈ ū + G (x − x̄).
    fn extend_from(&self, is_known: &[bool], column: &mut [f64]) {
        let position = |n: usize| -> [f64; 3] {
            let at = self.local.node_position(Node(n));
            std::array::from_fn(|a| at[a] as f64 * self.spacing[a])
        };
        let known: Vec<usize> = (0..is_known.len()).filter(|&n| is_known[n]).collect();
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
            for n in (0..is_known.len()).filter(|&n| !is_known[n]) {
                let r = offset(n);
                column[3 * n + component] = mean + (0..3).map(|a| gradient[a] * r[a]).sum::<f64>();
            }
        }
    }
}
