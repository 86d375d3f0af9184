//! Faces of cells and who shares them.

use super::{Dimension, SimplexMesh};
use rayon::prelude::*;

/// What entries beyond the d nodes of a face hold.
pub(super) const NO_NODE: u32 = u32::MAX;

/// A face as one of its cells sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Side {
    /// The d nodes, ascending.
    pub key: [u32; 3],
    /// The cell.
    pub cell: u32,
    /// The corner of the cell that is not in the face.
    pub opposite: u8,
    /// Whether the nodes in outward order are an even permutation of the key; cells on both sides of a face differ in it.
    pub even: bool,
}

/// The d nodes of a face in the order in which a right-handed turn points out of the cell; along x from its start in two dimensions.
pub(super) fn outward_nodes(mesh: &SimplexMesh, cell: usize, opposite: usize) -> [u32; 3] {
    let nodes = mesh.cell(cell);
    match mesh.dimension() {
        Dimension::One => [nodes[1 - opposite], NO_NODE, NO_NODE],
        Dimension::Two => [nodes[(opposite + 1) % 3], nodes[(opposite + 2) % 3], NO_NODE],
        Dimension::Three => [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]][opposite].map(|n: usize| nodes[n]),
    }
}

fn side(mesh: &SimplexMesh, cell: usize, opposite: usize) -> Side {
    let mut key = outward_nodes(mesh, cell, opposite);
    // The end of a segment is even, its start odd.
    let mut even = mesh.dimension() != Dimension::One || opposite == 0;
    for (a, b) in [(0, 1), (1, 2), (0, 1)] {
        if key[a] > key[b] {
            key.swap(a, b);
            even = !even;
        }
    }
    Side { key, cell: cell as u32, opposite: opposite as u8, even }
}

/// All sides of all cells, those of one face together.
pub(super) fn sorted_sides(mesh: &SimplexMesh) -> Vec<Side> {
    let corners = mesh.dimension().corners();
    let sides = (0..corners * mesh.cell_count()).into_par_iter().map(|n| side(mesh, n / corners, n % corners));
    let mut sides: Vec<Side> = sides.collect();
    sides.par_sort_unstable();
    sides
}

/// The sides of each face.
pub(super) fn by_face(sides: &[Side]) -> impl Iterator<Item = &[Side]> {
    sides.chunk_by(|a, b| a.key == b.key)
}
