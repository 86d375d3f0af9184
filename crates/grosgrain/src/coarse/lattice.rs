//! A coarse model without split cells as a lattice.

use crate::assembly::{CellStiffness, Constraints};
use crate::element::CellMatrix;
use crate::mesh::Lattice;
use crate::partition::{CoarseCell, CoarseMesh};

/// A coarse mesh that is a lattice, with the stiffness of its cells: what lattice solvers take.
pub struct CoarseLattice<'a> {
    mesh: &'a CoarseMesh,
    stiffness: Vec<&'a CellMatrix>,
}

impl<'a> CoarseLattice<'a> {
    /// The lattice of a mesh with these stiffnesses, one per element; `None` where cells or nodes are split.
    pub fn new(mesh: &'a CoarseMesh, stiffness: Vec<&'a CellMatrix>) -> Option<Self> {
        mesh.is_lattice().then_some(Self { mesh, stiffness })
    }

    /// Three entries per vertex as three per coarse lattice node; zero at nodes without a vertex.
    pub fn from_vertices(&self, of_vertices: &[f64]) -> Vec<f64> {
        let mut of_nodes = vec![0.0; 3 * self.lattice().node_count()];
        for (vertex, three) in self.mesh.vertices().iter().zip(of_vertices.chunks_exact(3)) {
            of_nodes[3 * vertex.node.0..][..3].copy_from_slice(three);
        }
        of_nodes
    }

    /// The way back.
    pub fn to_vertices(&self, of_nodes: &[f64]) -> Vec<f64> {
        self.mesh.vertices().iter().flat_map(|vertex| [0, 1, 2].map(|r| of_nodes[3 * vertex.node.0 + r])).collect()
    }

    /// Prescribed components of vertices as those of lattice nodes.
    pub fn constraints(&self, of_vertices: &Constraints) -> Constraints {
        let mut of_nodes = Constraints::none(self.lattice().node_count());
        for (number, vertex) in self.mesh.vertices().iter().enumerate() {
            (0..3).filter(|r| of_vertices.is_fixed(number, *r)).for_each(|r| of_nodes.fix(vertex.node.0, r));
        }
        of_nodes
    }
}

impl CellStiffness for CoarseLattice<'_> {
    fn lattice(&self) -> Lattice {
        self.mesh.partition().coarse()
    }

    fn stiffness(&self, cell: usize) -> Option<(f64, &CellMatrix)> {
        self.mesh.elements_of(CoarseCell(cell)).next().map(|element| (1.0, self.stiffness[element]))
    }
}
