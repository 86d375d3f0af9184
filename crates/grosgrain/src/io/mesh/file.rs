//! What a mesh file holds, and how the elements that it lists become a body.

use super::MeshReadError;
use crate::simplex::{Dimension, SimplexMesh};

/// The body in a mesh file: the elements of the highest dimension that stands there.
///
/// All cells are simplices and none is inside out; coordinates are in the units of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFile {
    /// Segments, triangles or tetrahedra.
    pub dimension: Dimension,
    /// Positions of the nodes, all of which cells use; in the units of the file.
    pub nodes: Vec<[f64; 3]>,
    /// Corners of each cell, counted from 0; the first d + 1 count.
    pub cells: Vec<[u32; 4]>,
    /// The tag of each cell: physical group, reference, region, element set or material number.
    pub tags: Vec<i32>,
    /// Names that the file gives to tags.
    pub names: Vec<(i32, String)>,
    /// What was left out or changed, e.g. `triangles left out: 1012`.
    pub skipped: Vec<String>,
}

impl MeshFile {
    /// The body as a mesh; the units of the file are taken for metres.
    ///
    /// # Errors
    /// A surface or a curve in space in place of a body, and all that [`SimplexMesh::new`] refuses.
    pub fn into_mesh(self) -> Result<SimplexMesh, MeshReadError> {
        let axes = self.dimension.axes();
        if let Some((node, at)) = self.nodes.iter().enumerate().find(|(_, at)| at[axes..].iter().any(|x| *x != 0.0)) {
            return Err(MeshReadError::Surface { dimension: self.dimension, node, at: *at });
        }
        Ok(SimplexMesh::new(self.dimension, self.nodes, self.cells, self.tags)?)
    }

    /// The file with all coordinates times a factor, e.g. 0.001 for millimetres.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.nodes.iter_mut().flatten().for_each(|x| *x *= factor);
        self
    }
}
