//! Gmsh meshes.

mod encoding;
mod kind;
mod read;
mod version_2;
mod version_4;
mod write;

use super::{MeshReadError, Place};
pub use read::read_gmsh;
pub use write::write_gmsh;
