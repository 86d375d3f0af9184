//! What of a coarse cell is solid: its parts, and the nodes that they touch.

use crate::assembly::{CellStiffness, Window};
use crate::fine::FineModel;
use crate::mesh::{Cell, Components, Lattice, Neighbourhood, Node, hull};
use crate::partition::{CoarseCell, Partition};

/// The mark of a node that touches no solid fine cell.
const INACTIVE: u8 = u8::MAX;

/// The solid fine cells of a coarse cell and their face-connected parts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Solids {
    /// Which fine cells are void, x fastest.
    pub void: Vec<bool>,
    /// Number of face-connected parts.
    pub parts: usize,
    /// Parts hang together by edges or nodes, or there are too many of them: no exact elimination.
    pub hinged: bool,
    part_of: Vec<u8>,
}

impl Solids {
    pub(super) fn new(model: &FineModel, partition: &Partition, cell: CoarseCell) -> Self {
        let void: Vec<bool> = partition.fine_cells(cell).map(|c| model.is_void(c)).collect();
        let lattice = partition.cell_lattice();
        if void.iter().all(|v| !v) {
            return Self { void, parts: 1, hinged: false, part_of: vec![0; lattice.node_count()] };
        }
        let components = Components::new(&void, &lattice, Neighbourhood::Faces);
        let parts = components.count();
        let hinged =
            parts != Components::new(&void, &lattice, Neighbourhood::Nodes).count() || parts >= usize::from(INACTIVE);
        let mut part_of = vec![INACTIVE; lattice.node_count()];
        for c in (0..void.len()).map(Cell) {
            if let Some(part) = components.of(c) {
                lattice.corners(c).iter().for_each(|n| part_of[n.0] = part as u8);
            }
        }
        Self { void, parts, hinged, part_of }
    }

    /// The part that a local node belongs to.
    pub(super) fn part(&self, node: usize) -> Option<usize> {
        let part = self.part_of[node];
        (part != INACTIVE).then_some(usize::from(part))
    }

    /// Which local nodes touch a solid fine cell.
    pub(super) fn active(&self) -> Vec<bool> {
        self.part_of.iter().map(|p| *p != INACTIVE).collect()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.parts == 0
    }

    pub(super) fn is_full(&self) -> bool {
        self.void.iter().all(|v| !v)
    }

    /// The hull of the solid fine cells in the cell's own box.
    pub(super) fn own_hull(&self, local: &Lattice) -> Vec<bool> {
        if self.is_full() { vec![true; self.void.len()] } else { hull(&self.void, local) }
    }
}

/// Integrals of the gradients of the shape functions over the marked fine cells, per node in quarters of a fine cell's faces: whole numbers, so
/// that what cancels cancels exactly. The load of a constant stress σ is σ times them (`node_loads`).
pub(super) fn face_quarters(lattice: &Lattice, hull: &[bool]) -> Vec<[f64; 3]> {
    let mut faces = vec![[0.0; 3]; lattice.node_count()];
    for cell in (0..hull.len()).filter(|&c| hull[c]) {
        for (a, node) in lattice.corners(Cell(cell)).iter().enumerate() {
            (0..3).for_each(|axis| faces[node.0][axis] += if a >> axis & 1 == 1 { 1.0 } else { -1.0 });
        }
    }
    faces
}

/// The local number of a lattice node in a coarse cell; the node must belong to the cell.
pub(super) fn local_node(partition: &Partition, cell: CoarseCell, node: Node) -> usize {
    let start = partition.cell_box(cell).start;
    let at = partition.fine().node_position(node);
    partition.cell_lattice().node(std::array::from_fn(|a| at[a] - start[a])).0
}

/// H u for one column of three values per local node of the cell.
pub(super) fn multiply(model: &FineModel, partition: &Partition, cell: CoarseCell, u: &[f64]) -> Vec<f64> {
    let own = partition.cell_box(cell);
    let window = Window::new(model, own.start, own.cells);
    let lattice = window.lattice();
    let mut product = vec![0.0; u.len()];
    for c in 0..lattice.cell_count() {
        let Some((factor, matrix)) = window.stiffness(c) else { continue };
        let corners = lattice.corners(Cell(c));
        let entry = |i: usize| 3 * corners[i / 3].0 + i % 3;
        for (row, values) in matrix.chunks_exact(24).enumerate() {
            let sum: f64 = values.iter().enumerate().map(|(column, k)| k * u[entry(column)]).sum();
            product[entry(row)] += factor * sum;
        }
    }
    product
}
