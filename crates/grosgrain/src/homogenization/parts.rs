//! The parts of a mesh.

use crate::simplex::{SimplexMesh, components, pieces};

/// The part of a node that no cell uses.
pub(super) const NO_PART: u32 = u32::MAX;

/// The parts of a mesh: cells that hang together by nodes.
#[derive(Clone, Debug)]
pub(super) struct Parts {
    /// Part of each node.
    pub(super) of_node: Vec<u32>,
    /// The first cell of each part.
    pub(super) first_cells: Vec<usize>,
    /// Whether some cells hang together by an edge or a node alone, which makes a mechanism, or nearly one, of a part.
    pub(super) has_hinges: bool,
}

impl Parts {
    pub(super) fn new(mesh: &SimplexMesh) -> Self {
        let (part_of, count) = components(mesh);
        let mut parts = Self {
            of_node: vec![NO_PART; mesh.nodes().len()],
            first_cells: Vec::with_capacity(count),
            has_hinges: pieces(mesh).1 > count,
        };
        for (cell, part) in part_of.into_iter().enumerate() {
            if part as usize == parts.first_cells.len() {
                parts.first_cells.push(cell);
            }
            mesh.cell(cell).iter().for_each(|node| parts.of_node[*node as usize] = part);
        }
        parts
    }

    pub(super) fn count(&self) -> usize {
        self.first_cells.len()
    }
}
