//! What may be wrong with a mesh as a body: parts that are not connected, nodes at one place, faces and edges that belong to too many.

use super::faces::{by_face, sorted_sides};
use super::{Boundary, BoundaryError, BoundingBox, BoundingTree, OverlapError, Overlaps, SimplexMesh};
use crate::linalg::DisjointSets;

/// Nodes closer than this share of the diagonal of the box around the mesh are at one place.
const ONE_PLACE: f64 = 1e-10;
/// Cells that have more than this share of the smaller one in common overlap.
const OVERLAP: f64 = 1e-9;

/// How bad a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The mesh can be computed with; what was found may be meant.
    Warning,
    /// The mesh is no body.
    Error,
}

/// Something odd about a mesh. Cells and nodes count from 0.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshFinding {
    /// Faces with too many cells, or cells on one side of a face.
    #[error(transparent)]
    Boundary(#[from] BoundaryError),
    /// Cells overlap.
    #[error("cells {} and {} overlap in {measure:.3e}, {share:.1e} of the smaller one; mesh anew", cells[0], cells[1])]
    Overlapping {
        /// The pair with the greatest share.
        cells: [u32; 2],
        /// What they have in common \[m, m² or m³\].
        measure: f64,
        /// The same as a share of the smaller cell.
        share: f64,
    },
    /// Parts that have no node in common.
    #[error(
        "the mesh has {count} parts that are not connected, the smallest with {cells} cells around cell {cell}; keep one, or merge nodes where they should be joined"
    )]
    Components {
        /// How many.
        count: usize,
        /// Number of cells of the smallest.
        cells: usize,
        /// Its first cell.
        cell: u32,
    },
    /// Parts that share nodes, but no face.
    #[error(
        "{count} parts hang on a node or edge only, the smallest with {cells} cells around cell {cell}; they turn freely there, so join them by faces or remove them"
    )]
    Hinged {
        /// How many parts with no face in common there are.
        count: usize,
        /// Number of cells of the smallest.
        cells: usize,
        /// Its first cell.
        cell: u32,
    },
    /// Boundary edges (three dimensions) or nodes (two dimensions) with more than two boundary faces.
    #[error("the boundary is no manifold: {faces} of its faces meet at nodes {} and {} (such places in all: {count})", nodes[0], nodes[1])]
    Branching {
        /// Nodes of the first, alike in two dimensions.
        nodes: [u32; 2],
        /// How many faces meet there.
        faces: usize,
        /// How many such edges or nodes there are.
        count: usize,
    },
    /// Nodes at one place.
    #[error(
        "nodes {} and {} both lie at ({}, {}, {}), and {count} nodes in all lie where another one does; merge them unless there is a crack",
        nodes[0], nodes[1], at[0], at[1], at[2]
    )]
    Duplicates {
        /// The first pair.
        nodes: [u32; 2],
        /// Their place \[m\].
        at: [f64; 3],
        /// How many nodes lie where one with a smaller number does.
        count: usize,
    },
    /// Nodes that no cell has.
    #[error("node {node} belongs to no cell (such nodes in all: {count}); remove them")]
    Unused {
        /// The first.
        node: u32,
        /// How many there are.
        count: usize,
    },
}

impl MeshFinding {
    /// Whether one can go on.
    pub fn severity(&self) -> Severity {
        match self {
            Self::Boundary(_) | Self::Overlapping { .. } => Severity::Error,
            _ => Severity::Warning,
        }
    }
}

/// All findings but cells that overlap without sharing a face (see [`check_overlap`]); none for a connected body with a manifold boundary.
pub fn check_mesh(mesh: &SimplexMesh) -> Vec<MeshFinding> {
    let mut findings = Vec::new();
    match Boundary::of_mesh(mesh) {
        Err(error) => findings.push(error.into()),
        Ok(boundary) => findings.extend(boundary.branching().first().map(|first| MeshFinding::Branching {
            nodes: first.nodes,
            faces: first.faces,
            count: boundary.branching().len(),
        })),
    }
    let (components, pieces) = (components(mesh), pieces(mesh));
    let (count, cells, cell) = smallest(&components);
    if count > 1 {
        findings.push(MeshFinding::Components { count, cells, cell });
    }
    let (all, cells, cell) = smallest(&pieces);
    if all > count {
        findings.push(MeshFinding::Hinged { count: all, cells, cell });
    }
    findings.extend(duplicates(mesh));
    findings.extend(unused(mesh));
    findings
}

/// The pair of cells with the greatest common share if that is more than rounding; slower than the other checks, since all cells are intersected.
pub fn check_overlap(mesh: &SimplexMesh) -> Option<MeshFinding> {
    let overlaps = match Overlaps::new(mesh, mesh) {
        Ok(overlaps) => overlaps,
        Err(OverlapError::Dimensions { .. } | OverlapError::Apart { .. }) => return None,
    };
    let mut worst = None;
    let mut greatest = OVERLAP;
    for q in 0..mesh.cell_count() {
        for (p, measure) in overlaps.of_coarse(q).iter().filter(|(p, _)| (*p as usize) < q) {
            let measures = overlaps.fine_measures();
            let share = measure / measures[q].min(measures[*p as usize]);
            if share > greatest {
                greatest = share;
                worst = Some(MeshFinding::Overlapping { cells: [*p, q as u32], measure: *measure, share });
            }
        }
    }
    worst
}

/// The part of the mesh to which each cell belongs, counted from 0 in the order of first cells, and how many there are; cells with a common node belong together.
pub fn components(mesh: &SimplexMesh) -> (Vec<u32>, usize) {
    let mut first: Vec<Option<u32>> = vec![None; mesh.nodes().len()];
    let mut sets = DisjointSets::new(mesh.cell_count());
    for cell in 0..mesh.cell_count() {
        for node in mesh.cell(cell) {
            let other = *first[*node as usize].get_or_insert(cell as u32);
            sets.unite(other, cell as u32);
        }
    }
    sets.numbered()
}

/// As [`components`], but cells belong together only if they have a common face.
pub fn pieces(mesh: &SimplexMesh) -> (Vec<u32>, usize) {
    let mut sets = DisjointSets::new(mesh.cell_count());
    for sides in by_face(&sorted_sides(mesh)) {
        sides.windows(2).for_each(|pair| sets.unite(pair[0].cell, pair[1].cell));
    }
    sets.numbered()
}

/// How many parts there are, and the number of cells and first cell of the smallest.
fn smallest((numbers, count): &(Vec<u32>, usize)) -> (usize, usize, u32) {
    let mut parts = vec![(0, 0); *count];
    for (cell, number) in numbers.iter().enumerate().rev() {
        let part = &mut parts[*number as usize];
        *part = (part.0 + 1, cell as u32);
    }
    let (cells, cell) = parts.into_iter().min().unwrap_or_default();
    (*count, cells, cell)
}

fn duplicates(mesh: &SimplexMesh) -> Option<MeshFinding> {
    let nodes = mesh.nodes();
    let around = BoundingBox::of_points(nodes.iter().copied());
    let squared = (ONE_PLACE * around.diagonal()).powi(2);
    let tree = BoundingTree::new(nodes.iter().map(|at| BoundingBox { lower: *at, upper: *at }).collect());
    let mut first = None;
    let mut count = 0;
    for (node, at) in (0..).zip(nodes) {
        let mut least = node;
        tree.visit_within(*at, squared, |other| least = least.min(other));
        if least < node {
            first.get_or_insert(([least, node], *at));
            count += 1;
        }
    }
    first.map(|(nodes, at)| MeshFinding::Duplicates { nodes, at, count })
}

fn unused(mesh: &SimplexMesh) -> Option<MeshFinding> {
    let mut used = vec![false; mesh.nodes().len()];
    (0..mesh.cell_count()).flat_map(|cell| mesh.cell(cell)).for_each(|node| used[*node as usize] = true);
    let node = used.iter().position(|used| !used)? as u32;
    Some(MeshFinding::Unused { node, count: used.iter().filter(|used| !**used).count() })
}

#[cfg(test)]
mod tests {
    use super::super::{BoxCut, Dimension, SimplexLattice};
    use super::*;

    fn boxes(dimension: Dimension, solid: impl Fn([usize; 3]) -> bool) -> SimplexMesh {
        let around = BoundingBox { lower: [0.0; 3], upper: [4.0; 3] };
        let lattice = SimplexLattice { dimension, boxes: [4; 3], around, cut: BoxCut::Alike };
        let mesh = lattice.mesh().unwrap();
        mesh.part(|cell| solid(mesh.centre(cell).map(|x| x as usize))).unwrap().0
    }

    fn joined(a: &SimplexMesh, b: &SimplexMesh, move_b: f64) -> SimplexMesh {
        let mut nodes = a.nodes().to_vec();
        nodes.extend(b.nodes().iter().map(|x| [x[0] + move_b, x[1], x[2]]));
        let shift = a.nodes().len() as u32;
        let cell = |mesh: &SimplexMesh, c: usize, shift: u32| -> [u32; 4] {
            std::array::from_fn(|n| mesh.cell(c).get(n).map_or(0, |node| node + shift))
        };
        let mut cells: Vec<[u32; 4]> = (0..a.cell_count()).map(|c| cell(a, c, 0)).collect();
        cells.extend((0..b.cell_count()).map(|c| cell(b, c, shift)));
        let tags = vec![0; cells.len()];
        SimplexMesh::new(a.dimension(), nodes, cells, tags).unwrap()
    }

    #[test]
    fn nothing_is_found_in_a_sound_body() {
        for dimension in [Dimension::One, Dimension::Two, Dimension::Three] {
            let mesh = boxes(dimension, |_| true);
            assert_eq!((check_mesh(&mesh), check_overlap(&mesh)), (vec![], None), "{dimension}");
        }
        let hollow = boxes(Dimension::Three, |at| at != [1, 1, 1]);
        assert_eq!(check_mesh(&hollow), []);
    }

    #[test]
    fn parts_are_counted_by_nodes_and_by_faces() {
        let apart = boxes(Dimension::Three, |at| at[0] == 0 || (at[0] == 2 && at[1] > 1));
        let found = check_mesh(&apart);
        let first = components(&apart).0.iter().position(|part| *part == 1).unwrap() as u32;
        assert_eq!(found, [MeshFinding::Components { count: 2, cells: 48, cell: first }]);
        assert_eq!(found[0].severity(), Severity::Warning);
        let hinged = boxes(Dimension::Three, |at| at == [0, 0, 0] || at == [1, 1, 0] || at == [2, 1, 0]);
        assert_eq!((components(&hinged).1, pieces(&hinged).1), (1, 2));
        let found = check_mesh(&hinged);
        assert!(matches!(found[0], MeshFinding::Branching { faces: 4, count: 1, .. }), "{found:?}");
        assert_eq!(found[1..], [MeshFinding::Hinged { count: 2, cells: 6, cell: 0 }]);
        let by_node = boxes(Dimension::Three, |at| at == [0, 0, 0] || at == [1, 1, 1]);
        assert_eq!(check_mesh(&by_node), [MeshFinding::Hinged { count: 2, cells: 6, cell: 0 }]);
    }

    #[test]
    fn nodes_at_one_place_are_found() {
        let half = boxes(Dimension::Two, |at| at[0] < 2);
        let seam = joined(&half, &half, 2.0);
        let found = check_mesh(&seam);
        assert!(matches!(found[0], MeshFinding::Components { count: 2, cells: 16, cell: 0 }), "{found:?}");
        // The five nodes of the seam; the first of them is node 2, at (2, 0).
        let pair = MeshFinding::Duplicates { nodes: [2, 15], at: [2.0, 0.0, 0.0], count: 5 };
        assert_eq!(found[1..], [pair]);
        let message = "nodes 2 and 15 both lie at (2, 0, 0), and 5 nodes in all lie where another one does; merge them unless there is a crack";
        assert_eq!(found[1].to_string(), message);
        assert_eq!(check_overlap(&seam), None);
    }

    #[test]
    fn cells_that_overlap_are_found_whether_they_share_a_face_or_not() {
        let unit = boxes(Dimension::Three, |at| at == [0, 0, 0]);
        let found = check_overlap(&joined(&unit, &unit, 0.75)).unwrap();
        let MeshFinding::Overlapping { cells: [p, q], measure, share } = &found else { panic!("{found}") };
        assert!(*p < 6 && *q >= 6 && *measure > 0.0 && (share - 6.0 * measure).abs() < 1e-15, "{found}");
        assert_eq!(found.severity(), Severity::Error);
        let nodes = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [9.0, 9.0, 0.0]];
        let folded = SimplexMesh::new(Dimension::Two, nodes, vec![[0, 1, 2, 0], [0, 1, 3, 0]], vec![0; 2]).unwrap();
        let found = check_mesh(&folded);
        assert!(matches!(found[0], MeshFinding::Boundary(BoundaryError::Folded { cells: [0, 1], .. })), "{found:?}");
        assert_eq!(found[1..], [MeshFinding::Unused { node: 4, count: 1 }]);
    }
}
