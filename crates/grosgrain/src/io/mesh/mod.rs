//! Mesh files: Gmsh, Medit, TetGen, VTK and Abaqus become a [`MeshFile`], and all but TetGen and legacy VTK are written.
//!
//! No reader makes room for what a header claims, only for what is there.

mod abaqus;
mod contents;
mod file;
mod format;
mod gmsh;
mod medit;
mod node_numbers;
mod read_error;
mod scanner;
mod source;
mod tetgen;
mod write_error;

pub use abaqus::{AbaqusDeck, AbaqusMaterials, AbaqusWriteError, read_abaqus, write_abaqus};
pub(in crate::io) use contents::Contents;
pub use file::MeshFile;
pub use format::MeshFormat;
pub use gmsh::{read_gmsh, write_gmsh};
pub use medit::{read_medit, write_medit};
pub(in crate::io) use node_numbers::NodeNumbers;
pub use read_error::{MeshReadError, Place};
pub use source::{read_mesh, write_mesh};
pub use tetgen::read_tetgen;
pub use write_error::MeshWriteError;
