//! The surface of a voxel body as the picture crate takes it.

use std::collections::HashMap;

use grosgrain::mesh::{BoundaryFace, Node, VoxelGrid, boundary_faces};
use grosgrain_picture::{Lines, Panel, QuadSurface};

/// The faces of a body that can be seen, and their nodes.
pub struct BodySurface<'a> {
    grid: &'a VoxelGrid,
    /// The faces.
    pub faces: Vec<BoundaryFace>,
    /// The nodes of the faces, each once: the vertices of the surface.
    pub nodes: Vec<Node>,
    row_of: HashMap<Node, u32>,
}

impl<'a> BodySurface<'a> {
    /// The surface of what is left of a body without its `hidden` cells.
    pub fn new(grid: &'a VoxelGrid, hidden: &[bool]) -> Self {
        let faces = boundary_faces(hidden, &grid.lattice);
        let (mut nodes, mut row_of) = (Vec::new(), HashMap::new());
        for node in faces.iter().flat_map(|face| face.corners) {
            row_of.entry(node).or_insert_with(|| {
                nodes.push(node);
                nodes.len() as u32 - 1
            });
        }
        Self { grid, faces, nodes, row_of }
    }

    /// The vertex of a node of the surface.
    pub fn vertex(&self, node: Node) -> usize {
        self.row_of[&node] as usize
    }

    /// A panel that shows the surface with its nodes at the places that `position` says, plainly coloured.
    pub fn panel(&self, position: impl Fn(Node) -> [f64; 3]) -> Panel {
        let positions = self.nodes.iter().map(|node| position(*node)).collect();
        let quads = self.faces.iter().map(|face| face.corners.map(|node| self.row_of[&node])).collect();
        Panel { surface: QuadSurface { positions, quads }, ..Panel::default() }
    }

    /// Edges of the surface's faces that lie on faces of coarse cells of `degree`³ fine ones.
    pub fn coarse_grid(&self, degree: usize, position: impl Fn(Node) -> [f64; 3]) -> Lines {
        let lattice = self.grid.lattice;
        let mut edges: Vec<[Node; 2]> = Vec::new();
        for corners in self.faces.iter().map(|face| face.corners) {
            for (a, b) in (0..4).map(|i| (corners[i], corners[(i + 1) % 4])) {
                let (p, q) = (lattice.node_position(a), lattice.node_position(b));
                let normal_axes =
                    (0..3).filter(|&axis| corners.iter().any(|n| lattice.node_position(*n)[axis] != p[axis]));
                if normal_axes.clone().any(|axis| p[axis] == q[axis] && p[axis] % degree == 0) {
                    edges.push([a.min(b), a.max(b)]);
                }
            }
        }
        edges.sort_unstable();
        edges.dedup();
        edges.iter().map(|edge| edge.map(&position)).collect()
    }
}
