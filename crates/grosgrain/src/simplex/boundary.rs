//! The boundary of a mesh: faces with outward normals, and which of them surround cavities.

use super::faces::{NO_NODE, by_face, outward_nodes, sorted_sides};
use super::shells::shells;
use super::{Dimension, SimplexMesh};
use crate::linalg::matrix3::cross;

/// Why a mesh has no boundary that divides inside from outside.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BoundaryError {
    /// A face has three or more cells.
    #[error("cells {}, {}, {} share one face, that of nodes {nodes:?}; at most two can, so remove the cells that overlap", cells[0], cells[1], cells[2])]
    Crowded {
        /// Nodes of the face, from 0.
        nodes: Vec<u32>,
        /// The first three of its cells, from 0.
        cells: [u32; 3],
    },
    /// Two cells lie on the same side of their common face.
    #[error("cells {} and {} lie on the same side of their common face, that of nodes {nodes:?}; remove one, or mesh anew", cells[0], cells[1])]
    Folded {
        /// Nodes of the face, from 0.
        nodes: Vec<u32>,
        /// The cells, from 0.
        cells: [u32; 2],
    },
}

/// A face with a cell on one side only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundaryFace {
    nodes: [u32; 3],
    /// The cell.
    pub cell: u32,
    /// Outward unit normal times the measure of the face \[m², m or 1\].
    pub normal: [f64; 3],
    /// The shell that it belongs to.
    pub shell: u32,
}

impl BoundaryFace {
    /// The d nodes; seen from outside they run against the clock.
    pub fn nodes(&self) -> &[u32] {
        let count = self.nodes.iter().position(|n| *n == NO_NODE).unwrap_or(3);
        &self.nodes[..count]
    }

    /// Measure of the face \[m², m or 1\].
    pub fn measure(&self) -> f64 {
        self.normal.iter().map(|x| x * x).sum::<f64>().sqrt()
    }
}

/// A closed part of the boundary, connected through edges (three dimensions) or nodes (two dimensions).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shell {
    /// Number of faces.
    pub faces: usize,
    /// What it encloses, (1/d) Σ ∫ x·n \[m³, m² or m\]: positive around a body, negative around a cavity.
    pub enclosed: f64,
}

impl Shell {
    /// Whether it is the wall of a cavity, which carries no traction when a body is stretched (`kharevych2009numerical`, section 4.2).
    pub fn is_cavity(&self) -> bool {
        self.enclosed < 0.0
    }
}

/// All faces with a cell on one side only.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundary {
    faces: Vec<BoundaryFace>,
    shells: Vec<Shell>,
    branching: Vec<BranchingRidge>,
}

/// An edge (three dimensions) or node (two dimensions) at which more than two boundary faces meet: parts that touch there only hang on a hinge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BranchingRidge {
    /// Both nodes of the edge, or the node twice.
    pub nodes: [u32; 2],
    /// How many boundary faces meet.
    pub faces: usize,
}

impl Boundary {
    /// The boundary of a mesh. Where parts touch at an edge (at a node in two dimensions) only, shells go on along the void between them, so that walls of cavities stay apart
    /// from the outer boundary.
    ///
    /// # Errors
    /// A face with more than two cells, or with two on the same side.
    pub fn of_mesh(mesh: &SimplexMesh) -> Result<Self, BoundaryError> {
        let sides = sorted_sides(mesh);
        let mut faces = Vec::new();
        for sides in by_face(&sides) {
            let nodes = || sides[0].key[..mesh.dimension().axes()].to_vec();
            match sides {
                [side] => faces.push(face(mesh, side.cell as usize, side.opposite as usize)),
                [a, b] if a.even != b.even => {}
                [a, b] => return Err(BoundaryError::Folded { nodes: nodes(), cells: [a.cell, b.cell] }),
                _ => {
                    let cells = std::array::from_fn(|n| sides[n].cell);
                    return Err(BoundaryError::Crowded { nodes: nodes(), cells });
                }
            }
        }
        faces.sort_by_key(|face| face.cell);
        let (numbers, count, branching) = shells(mesh, &faces);
        let mut shells = vec![Shell { faces: 0, enclosed: 0.0 }; count];
        let mut origins = vec![None; count];
        for (face, number) in faces.iter_mut().zip(numbers) {
            face.shell = number;
            let shell = &mut shells[number as usize];
            let at = mesh.nodes()[face.nodes[0] as usize];
            let origin = *origins[number as usize].get_or_insert(at);
            shell.faces += 1;
            let height: f64 = (0..3).map(|r| (at[r] - origin[r]) * face.normal[r]).sum();
            shell.enclosed += height / mesh.dimension().axes() as f64;
        }
        Ok(Self { faces, shells, branching })
    }

    /// All faces, in the order of their cells.
    pub fn faces(&self) -> &[BoundaryFace] {
        &self.faces
    }

    /// The closed parts that the faces form, in the order of their first faces.
    pub fn shells(&self) -> &[Shell] {
        &self.shells
    }

    /// Whether a face belongs to the wall of a cavity.
    pub fn is_cavity(&self, face: &BoundaryFace) -> bool {
        self.shells[face.shell as usize].is_cavity()
    }

    /// The faces that are not walls of cavities.
    pub fn outer(&self) -> impl Iterator<Item = &BoundaryFace> {
        self.faces.iter().filter(|face| !self.is_cavity(face))
    }

    /// Where more than two faces meet at an edge or node; none in a manifold.
    pub fn branching(&self) -> &[BranchingRidge] {
        &self.branching
    }
}

fn face(mesh: &SimplexMesh, cell: usize, opposite: usize) -> BoundaryFace {
    let nodes = outward_nodes(mesh, cell, opposite);
    let edge = |n: usize| -> [f64; 3] {
        let (from, to) = (mesh.nodes()[nodes[0] as usize], mesh.nodes()[nodes[n] as usize]);
        std::array::from_fn(|r| to[r] - from[r])
    };
    let normal = match mesh.dimension() {
        Dimension::One => [if opposite == 0 { 1.0 } else { -1.0 }, 0.0, 0.0],
        Dimension::Two => {
            let along = edge(1);
            [along[1], -along[0], 0.0]
        }
        Dimension::Three => cross(&edge(1), &edge(2)).map(|x| 0.5 * x),
    };
    BoundaryFace { nodes, cell: cell as u32, normal, shell: 0 }
}
