//! Meshes of simplices (segments, triangles, tetrahedra) and elasticity in as many dimensions.

mod error;
mod mesh;
mod tensor;

pub use error::SimplexMeshError;
pub use mesh::{Dimension, SimplexMesh};
pub use tensor::{MandelTensor, mandel_strain};
