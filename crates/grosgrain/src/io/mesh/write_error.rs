//! Why a mesh is not written.

use std::path::PathBuf;

/// Why a mesh is not written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshWriteError {
    /// The file that is not written, and the reason.
    #[error("{}: {reason}", path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// Why it is not written.
        reason: Box<MeshWriteError>,
    },
    /// The operating system refuses.
    #[error("cannot be written: {0}")]
    Io(#[from] std::io::Error),
    /// The VTU file is not written.
    #[error(transparent)]
    Vtk(#[from] crate::io::vtk::VtkError),
    /// The Abaqus file is not written.
    #[error(transparent)]
    Abaqus(#[from] super::AbaqusWriteError),
    /// The name is that of no format that is written.
    #[error(
        "has no extension of a mesh format that is written; known are .msh (Gmsh), .mesh (Medit), .vtu (VTK) and .inp (Abaqus)"
    )]
    UnknownFormat,
    /// Gmsh numbers groups from 1.
    #[error("{cells} cells have the tag {tag}, but Gmsh numbers groups from 1; give them another tag, or write .mesh")]
    NegativeTag {
        /// The lowest tag.
        tag: i32,
        /// Number of its cells.
        cells: usize,
    },
}
